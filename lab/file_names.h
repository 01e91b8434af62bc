#pragma once
// Names of files that mean the same in another checkout or on another machine. A file of a package is named from the
// package, a file that comes with cxlab from cxlab's folder, and any other from the folder of the scenario.

#include <filesystem>
#include <map>
#include <string>

#include "scenarios/scenario.h"

namespace cxlab::lab {

/// The path of a file from a folder; absolute where both have nothing in common but the root of all files.
std::string name_from(const std::filesystem::path& folder, const std::filesystem::path& file);

class FileNames {
 public:
  /// `scenario` is the file; its packages are known with `use_packages`.
  explicit FileNames(const std::filesystem::path& scenario);
  /// Knows the packages of the scenario's agents and the installed packages from now on.
  void use_packages(const Scenario& scenario);

  /// "package://my_agent/clips/rules.clp", "cxlab://models/field.xml", "params/agent.yaml"; absolute where the file has
  /// no folder in common with the scenario.
  std::string name_of(const std::filesystem::path& file) const;
  /// Where the file of that name lies here; empty if there is no such package.
  std::filesystem::path path_of(const std::string& name) const;

 private:
  std::filesystem::path home_;
  std::map<std::string, std::filesystem::path> roots_;  ///< by the beginning of names: "package://my_agent/"
};

}  // namespace cxlab::lab
