#pragma once
// A folder of its own for each test, with an agent in it, and runs of that agent.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "lab/run.h"
#include "lab/session.h"
#include "scenarios/shipped/catalogue.h"
#include "tests/support/agent_text.h"
#include "tests/support/files.h"

namespace cxlab::lab {

class FolderTest : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return temp_ / name; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return temp_.write(name, text);
  }
  std::string read(const std::string& name) const { return content_of(path(name)); }

  /// A scenario of `name`.yaml in an empty world, two seconds long, with an agent that has these rules.
  std::filesystem::path scenario(const std::string& name, const std::string& rules,
                                 const std::vector<std::string>& plugins = {}) const {
    write("agent.yaml", agent_text("rules", plugins));
    write("rules/rules.clp", rules);
    return write(name + ".yaml",
                 "schema: 1\nduration_s: 2\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n");
  }
  Scenario loaded(const std::string& name) const {
    auto scenario = Scenario::load(path(name + ".yaml"), shipped());
    EXPECT_TRUE(scenario) << (scenario ? "" : scenario.error().text());
    return *std::move(scenario);
  }
  /// Plays it, into the folder `out` unless the options name another one.
  Played play(const std::string& name, PlayOptions options = {}, const Host& host = {}) const {
    if (options.out.empty()) options.out = path("out").string();
    auto played = play_scenario(options, loaded(name), host);
    EXPECT_TRUE(played) << (played ? "" : played.error().text());
    return *std::move(played);
  }
  lab::Run run(const std::string& folder = "out") const {
    auto run = Run::open(path(folder));
    EXPECT_TRUE(run) << (run ? "" : run.error().text());
    return *std::move(run);
  }

 private:
  TempFolder temp_;
};

inline const char* kQuietRules = "(defrule tick (time ?) =>)\n";

}  // namespace cxlab::lab
