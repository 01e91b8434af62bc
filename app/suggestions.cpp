#include "app/suggestions.h"

#include <algorithm>
#include <map>
#include <utility>

#include "scenarios/share.h"

namespace cxlab::app {

namespace {

/// By option; the commands live as long as the process.
std::map<const CLI::Option*, std::pair<Suggestions, bool>>& all() {
  static std::map<const CLI::Option*, std::pair<Suggestions, bool>> suggestions;
  return suggestions;
}

/// Shells take other characters for their own.
bool is_plain(const std::string& name) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-/.";
  return !name.empty() && name.find_first_not_of(kPlain) == std::string::npos;
}

}  // namespace

CLI::Option* suggest(CLI::Option* option, Suggestions names, bool files) {
  all()[option] = {std::move(names), files};
  return option;
}

Suggested suggested_for(const CLI::Option& option) {
  const auto known = all().find(&option);
  if (known == all().end()) return {};
  Suggested out{known->second.first(), known->second.second};
  std::erase_if(out.names, [](const std::string& name) { return !is_plain(name); });
  std::ranges::sort(out.names);
  out.names.erase(std::unique(out.names.begin(), out.names.end()), out.names.end());
  return out;
}

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const auto& [name, file] : own_scenarios()) names.push_back(name);
  return names;
}

}  // namespace cxlab::app
