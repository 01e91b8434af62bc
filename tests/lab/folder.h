#pragma once
// A folder of its own for each test, with an agent in it.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "cx/base/scratch_folder.h"

namespace cxlab::lab {

class FolderTest : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return scratch_->path() / name; }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(path(name).parent_path());
    std::ofstream(path(name)) << text;
    return path(name);
  }

  std::string read(const std::string& name) const {
    std::ifstream in(path(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }

  /// A scenario of `name`.yaml in an empty world, two seconds long, with an agent that has these rules.
  std::filesystem::path scenario(const std::string& name, const std::string& rules) const {
    write("agent.yaml", R"(/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}
)");
    write("rules/rules.clp", rules);
    return write(name + ".yaml",
                 "schema: 1\nduration_s: 2\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n");
  }

 private:
  std::unique_ptr<ScratchFolder> scratch_ = *ScratchFolder::create();
};

inline const char* kQuietRules = "(defrule tick (time ?) =>)\n";

}  // namespace cxlab::lab
