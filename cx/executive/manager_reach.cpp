// The files that rules of an environment manager reach: its configuration, packages, and files that the configuration
// names.

#include <yaml-cpp/yaml.h>

#include <set>
#include <string>
#include <vector>

#include "cx/base/file.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/plugin_library.h"
#include "cx/executive/reach.h"

namespace cxlab::cx {

namespace fs = std::filesystem;

namespace {

void add_texts(const YAML::Node& node, std::set<std::string>& texts) {
  if (node.IsScalar()) texts.insert(node.Scalar());
  for (const auto& item : node)
    if (node.IsMap())
      add_texts(item.second, texts);
    else
      add_texts(item, texts);
}

std::set<std::string> texts_of(const std::string& yaml) {
  std::set<std::string> texts;
  try {
    add_texts(YAML::Load(yaml), texts);
  } catch (const YAML::Exception&) {  // the reader of the file reports it
  }
  return texts;
}

/// Classes of the plugins that environments list.
std::set<std::string> classes_of(const Parameters& parameters) {
  std::set<std::string> classes;
  std::vector<std::string> environments;
  if (!parameters.read("environments", environments)) return classes;
  for (const std::string& environment : environments) {
    std::vector<std::string> plugins;
    if (!parameters.read(environment + ".plugins", plugins)) continue;
    for (const std::string& plugin : plugins) {
      std::string name;
      if (parameters.read(plugin + ".plugin", name)) classes.insert(name);
    }
  }
  return classes;
}

}  // namespace

void EnvironmentManager::read_configured() {
  if (const auto text = read_file(options_.config)) configured_ = texts_of(*text);
  for (const GivenParameter& given : options_.params) configured_.merge(texts_of(given.value));
  configured_.insert(options_.native_classes.begin(), options_.native_classes.end());
}

bool EnvironmentManager::may_load(const PluginType& type) const {
  return !type.library || options_.trust_rules || configured_.contains(type.name);
}

void EnvironmentManager::add_reach(Wall& wall) const {
  wall.read.push_back(options_.config);
  if (!options_.outside_copies.empty()) wall.read.push_back(options_.outside_copies);
  const fs::path& folder = options_.run_folder.empty() ? options_.rules_folder : options_.run_folder;
  if (!folder.empty()) wall.write.push_back(folder);
  for (const fs::path& package : files_.folders()) add_package(package, wall);
  for (const auto& [file, other] : options_.instead) wall.read.push_back(other);

  // What stands in the configuration: absolute, or in a package, where it may be a link.
  for (const std::string& text : configured_) {
    const fs::path named = fs::path(text).lexically_normal();
    if (text.empty() || named.empty() || *named.begin() == "..") continue;
    std::vector<fs::path> places;
    if (named.is_absolute()) places.push_back(named);
    for (const auto& [name, package] : options_.packages) {
      if (auto found = files_.resolve(text, {name})) places.push_back(found->path);
      if (!named.is_absolute()) places.push_back(package.folder / named);
    }
    for (const fs::path& place : places) {
      if (path_exists(place) && !holds_a_home(place)) wall.read.push_back(place);
    }
  }

  // Libraries are opened now, as long as all that they need can be read.
  const std::set<std::string> used = classes_of(parameters_);
  for (const PluginType& type : options_.plugin_types) {
    if (!type.library || !configured_.contains(type.name)) continue;
    const fs::path library = library_file(type);
    if (library.empty() || (!folder.empty() && really_below(library, folder))) continue;
    wall.read.push_back(library);
    if (used.contains(type.name) && options_.programs) open_early(type);
  }
}

}  // namespace cxlab::cx
