#include "scenarios/share.h"

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "cx/base/file.h"

namespace cxlab {

namespace fs = std::filesystem;

namespace {

/// The prefix, seen from <prefix>/bin/<program>, <prefix>/lib/cxlab/<library>; empty where there is no share/cxlab.
fs::path prefix_of(const fs::path& file) {
  std::error_code ignored;
  const fs::path above = fs::canonical(file, ignored).parent_path().parent_path();
  for (const fs::path& prefix : {above, above.parent_path()})
    if (!prefix.empty() && fs::is_directory(prefix / "share/cxlab/interfaces", ignored)) return prefix;
  return {};
}

fs::path installed_prefix() {
  Dl_info here{};
  if (dladdr(reinterpret_cast<const void*>(&find_share), &here) && here.dli_fname)
    if (fs::path prefix = prefix_of(here.dli_fname); !prefix.empty()) return prefix;
  return prefix_of("/proc/self/exe");
}

bool is_package(const fs::path& folder) {
  std::error_code ignored;
  for (const char* sign : {"package.xml", "cxlab_plugins.yaml", "msg", "srv", "action", "clips", "params", "pddl"})
    if (fs::exists(folder / sign, ignored)) return true;
  return false;
}

}  // namespace

Share find_share() {
  const auto in = [](const fs::path& share, const fs::path& prefix) {
    return Share{share / "interfaces", share / "models",  share / "packages", share / "scenarios",
                 share / "docs",       share / "engines", share / "pages",    prefix};
  };
  static const fs::path prefix = installed_prefix();
  if (const char* named = std::getenv("CXLAB_SHARE")) return in(named, prefix);
  if (!prefix.empty()) return in(prefix / "share/cxlab", prefix);
  const fs::path source = CXLAB_SOURCE_DIR;
  return Share{source / "cx/interfaces", source / "models",          source / "cx/packages", source / "scenarios",
               source / "docs",          source / "planner/engines", source / "lab/pages",   {}};
}

std::optional<fs::path> nearest_package(fs::path folder) {
  for (; folder.has_relative_path(); folder = folder.parent_path())
    if (is_file(folder / "package.xml")) return folder;
  return std::nullopt;
}

std::string package_name(const fs::path& folder) {
  if (auto text = read_file(folder / "package.xml")) {
    const std::size_t begin = text->find("<name>"), end = text->find("</name>");
    if (begin != std::string::npos && end != std::string::npos && begin < end)
      return text->substr(begin + 6, end - begin - 6);
  }
  return folder.filename().string();
}

Expected<std::map<std::string, std::string>> packages_below(const std::vector<std::string>& prefixes) {
  std::map<std::string, std::string> packages;
  for (const std::string& prefix : prefixes) {
    std::error_code error, ignored;
    const fs::path root = fs::absolute(prefix).lexically_normal();
    const auto add = [&](const fs::path& folder) {
      if (is_package(folder)) packages.emplace(folder.filename().string(), folder.string());
      return is_package(folder);
    };
    for (const auto& entry : fs::directory_iterator(root / "share", error)) add(entry.path());
    if (!error) continue;
    bool found = false;
    for (const auto& entry : fs::directory_iterator(root, ignored))
      found = add(entry.path() / "share" / entry.path().filename()) || found;
    if (!found) return input_error("prefix " + prefix + ": cannot read its folder share: " + error.message());
  }
  return packages;
}

std::map<std::string, std::string> own_packages() {
  std::map<std::string, std::string> packages;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(find_share().packages, ignored))
    if (is_package(entry.path()))
      packages.emplace(entry.path().filename().string(), fs::absolute(entry.path()).lexically_normal().string());
  return packages;
}

std::map<std::string, fs::path> own_scenarios() {
  std::map<std::string, fs::path> scenarios;
  const fs::path root = find_share().scenarios;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(root, ignored)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("schema:"))
        scenarios[entry.path().lexically_relative(root).replace_extension().generic_string()] = entry.path();
  }
  return scenarios;
}

Expected<fs::path> own_scenario(const std::string& name) {
  const std::map<std::string, fs::path> own = own_scenarios();
  if (const auto known = own.find(name); known != own.end()) return known->second;
  std::vector<std::string> names;
  for (const auto& [known, file] : own) names.push_back(known);
  const std::string near = did_you_mean(
      fs::path(name).extension() == ".yaml" ? fs::path(name).replace_extension().generic_string() : name, names);
  return input_error("there is no such file, and no scenario of that name" +
                         (near.empty() ? "; cxlab list scenarios shows the names" : near),
                     name);
}

Expected<fs::path> find_scenario(const std::string& file_or_name) {
  std::error_code ignored;
  const bool folder = fs::is_directory(file_or_name, ignored);
  if (fs::exists(file_or_name, ignored) && !folder) return fs::path(file_or_name);
  auto own = own_scenario(file_or_name);
  if (!own && folder) return input_error("is a folder, expected a scenario (YAML)", file_or_name);
  return own;
}

std::vector<std::string> default_prefixes() {
  std::vector<std::string> prefixes;
  if (const char* named = std::getenv("CXLAB_PREFIX_PATH")) {
    std::stringstream list(named);
    for (std::string prefix; std::getline(list, prefix, ':');)
      if (!prefix.empty()) prefixes.push_back(prefix);
  }
  if (const fs::path own = find_share().prefix; !own.empty()) prefixes.push_back(own.string());
  return prefixes;
}

}  // namespace cxlab
