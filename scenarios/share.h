#pragma once
// Where data lies: what comes with cxlab, and packages that are installed below a prefix.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

struct Share {
  std::filesystem::path interfaces;  ///< packages of interface definitions
  std::filesystem::path models;      ///< MJCF
  std::filesystem::path packages;    ///< share folders of packages of rules
  std::filesystem::path scenarios;
  std::filesystem::path docs;
  std::filesystem::path engines;  ///< scripts that run other planners
  std::filesystem::path pages;    ///< templates of reports
  std::filesystem::path prefix;   ///< that cxlab is installed below; empty in a source tree
};

/// $CXLAB_SHARE, else share/cxlab of the prefix that this library or program is installed below, else the source tree
/// that it was built from.
Share find_share();

/// The packages below <prefix>/share, by name: folders with a package.xml, a manifest of plugins, interface
/// definitions, rules, configurations or PDDL files. The first prefix that has a package wins. A prefix that is not
/// there is an error.
Expected<std::map<std::string, std::string>> packages_below(const std::vector<std::string>& prefixes);

/// The nearest folder with a package.xml, from this absolute path upwards. The root of the file system is no package.
std::optional<std::filesystem::path> nearest_package(std::filesystem::path folder);

/// <name> of the package.xml in a folder, else the folder's name.
std::string package_name(const std::filesystem::path& folder);

/// The packages that come with cxlab: folders of `Share::packages`, by name.
std::map<std::string, std::string> own_packages();

/// The scenarios that come with cxlab: files by name, "rcll/game".
std::map<std::string, std::filesystem::path> own_scenarios();
/// The scenario that comes with cxlab under that name; the error names the nearest.
Expected<std::filesystem::path> own_scenario(const std::string& name);
/// The file of that path, else the scenario that comes with cxlab under that name.
Expected<std::filesystem::path> find_scenario(const std::string& file_or_name);

/// The prefixes that are looked through without being named: those in $CXLAB_PREFIX_PATH (separated by ':'), then the
/// one that cxlab is installed below.
std::vector<std::string> default_prefixes();

}  // namespace cxlab
