#include "scenarios/pddl_files.h"

#include <algorithm>
#include <cstring>

#include "cx/base/file.h"
#include "cx/executive/reach.h"
#include "scenarios/scenario.h"

namespace cxlab {

namespace {

namespace fs = std::filesystem;

constexpr int kMostEntries = 20000;                   // of a folder that are looked at
constexpr std::uintmax_t kLargestRuleFile = 1 << 20;  // that is searched for paths

/// Calls `visit` with each regular file of that extension below a folder, at most `deepest` folders down.
template <class Visit>
void for_each_file(const fs::path& folder, const char* extension, int deepest, Visit visit) {
  std::error_code error;
  int seen = 0;
  for (fs::recursive_directory_iterator
           entry(fs::canonical(folder, error), fs::directory_options::skip_permission_denied, error),
       end;
       !error && entry != end && seen < kMostEntries; entry.increment(error), ++seen) {
    std::error_code ignored;
    const bool is_hidden = cx::is_hidden(entry->path().filename());
    if (entry->is_directory(ignored) && (entry.depth() >= deepest || is_hidden)) entry.disable_recursion_pending();
    if (!is_hidden && entry->path().extension() == extension && entry->is_regular_file(ignored) &&
        !entry->is_symlink(ignored))
      visit(entry->path());
  }
}

}  // namespace

std::vector<fs::path> paths_in(const std::string& text) {
  constexpr const char* kEnd = " \t\r\n\"',;:()[]{}<>|";
  std::vector<fs::path> paths;
  for (std::size_t at = text.find('/'); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kEnd, at), text.size());
    if (at == 0 || std::strchr(kEnd, text[at - 1]) || text[at - 1] == '=')
      paths.emplace_back(text.substr(at, end - at));
    at = text.find('/', end);
  }
  return paths;
}

std::set<fs::path> pddl_files(const Scenario& scenario) {
  constexpr int kDeepest = 4, kDeepestOfAPackage = 32;
  std::set<fs::path> files;
  const auto add = [&](const fs::path& file) { files.insert(file); };
  for_each_file(scenario.resolve("."), ".pddl", kDeepest, add);

  std::set<fs::path> packages, named;
  for (const AgentSpec& agent : scenario.agents)
    for (const auto& [name, folder] : scenario.shares(agent)) packages.insert(folder);
  for (const fs::path& package : packages)
    for_each_file(package, ".clp", kDeepestOfAPackage, [&](const fs::path& rules) {
      std::error_code error;
      if (fs::file_size(rules, error) > kLargestRuleFile || error) return;
      if (const auto text = read_file(rules))
        for (const fs::path& path : paths_in(*text))
          named.insert(path.extension() == ".pddl" ? path.parent_path() : path);
    });
  for (const fs::path& folder : named) {
    std::error_code error;
    const fs::path real = fs::canonical(folder, error);
    if (!error && real.has_relative_path() && !cx::is_hidden(real.filename()) && fs::is_directory(real, error))
      for_each_file(real, ".pddl", 0, add);
  }
  return files;
}

}  // namespace cxlab
