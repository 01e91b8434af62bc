#include "scenarios/pddl/files.h"

#include "cx/base/file.h"
#include "cx/executive/reach.h"

namespace cxlab::pddl {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestRuleFile = 1 << 20;  // that is searched for paths

/// Calls `visit` with each regular file of that extension below a folder, at most `deepest` folders down.
template <class Visit>
void for_each_file(const fs::path& folder, const char* extension, int deepest, Visit visit) {
  std::error_code error;
  cx::for_each_entry<fs::recursive_directory_iterator>(fs::canonical(folder, error), [&](auto& entry) {
    std::error_code ignored;
    const bool is_hidden = cx::is_hidden(entry->path().filename());
    if (entry->is_directory(ignored) && (entry.depth() >= deepest || is_hidden)) entry.disable_recursion_pending();
    if (!is_hidden && entry->path().extension() == extension && entry->is_regular_file(ignored) &&
        !entry->is_symlink(ignored))
      visit(entry->path());
  });
}

}  // namespace

std::set<fs::path> files(const Scenario& scenario) {
  constexpr int kDeepest = 4, kDeepestOfAPackage = 32;
  std::set<fs::path> found;
  const auto add = [&](const fs::path& file) { found.insert(file); };
  for_each_file(scenario.resolve("."), ".pddl", kDeepest, add);

  std::set<fs::path> packages, named;
  for (const AgentSpec& agent : scenario.agents)
    for (const auto& [name, folder] : scenario.shares(agent)) packages.insert(folder);
  for (const fs::path& package : packages)
    for_each_file(package, ".clp", kDeepestOfAPackage, [&](const fs::path& rules) {
      std::error_code error;
      if (fs::file_size(rules, error) > kLargestRuleFile || error) return;
      if (const auto text = read_file(rules))
        for (const fs::path& path : cx::paths_in(*text))
          named.insert(path.extension() == ".pddl" ? path.parent_path() : path);
    });
  for (const fs::path& folder : named) {
    std::error_code error;
    const fs::path real = fs::canonical(folder, error);
    if (!error && real.has_relative_path() && !cx::is_hidden(real.filename()) && fs::is_directory(real, error))
      for_each_file(real, ".pddl", 0, add);
  }
  return found;
}

}  // namespace cxlab::pddl
