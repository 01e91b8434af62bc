// What an episode reaches of the machine once it plays.

#include <algorithm>
#include <cstring>

#include "cx/base/file.h"
#include "cx/executive/reach.h"
#include "scenarios/episode.h"
#include "scenarios/share.h"

namespace cxlab {

namespace {

namespace fs = std::filesystem;

/// Absolute paths that stand in a text, as in a scenario's stimuli.
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

/// PDDL files beside the scenario and in folders there, which rules name to the PDDL manager.
void add_pddl_files(const fs::path& folder, Wall& wall) {
  constexpr int kDeepest = 4, kMostEntries = 20000;
  std::error_code error;
  int seen = 0;
  for (fs::recursive_directory_iterator
           entry(fs::canonical(folder, error), fs::directory_options::skip_permission_denied, error),
       end;
       !error && entry != end && seen < kMostEntries; entry.increment(error), ++seen) {
    std::error_code ignored;
    if (entry->is_directory(ignored) && (entry.depth() >= kDeepest || cx::is_hidden(entry->path().filename())))
      entry.disable_recursion_pending();
    if (entry->path().extension() == ".pddl" && entry->is_regular_file(ignored) && !entry->is_symlink(ignored))
      wall.exact.push_back(entry->path());
  }
}

}  // namespace

Wall Episode::wall() const {
  Wall wall;
  const Share share = find_share();
  wall.read = {options_.interfaces, options_.models, share.pages, share.engines, scenario_.file};
  if (!share.prefix.empty()) wall.read.push_back(share.prefix / "lib");
  if (options_.replay) wall.read.insert(wall.read.end(), {options_.replay->inputs, options_.replay->copies});
  for (const auto& [key, file] : scenario_.world_files) wall.read.push_back(file.path);
  if (!options_.replay) add_pddl_files(scenario_.resolve("."), wall);
  std::map<std::string, PackageSpec> packages = scenario_.packages;
  for (const AgentSpec& agent : scenario_.agents) packages.insert(agent.packages.begin(), agent.packages.end());
  if (!options_.replay) {
    for (const auto& [name, package] : packages) cx::add_package(scenario_.resolve(package.folder), wall);
    for (const fs::path& path : paths_in(scenario_.text.empty() ? scenario_.to_yaml() : scenario_.text))
      if (!cx::holds_a_home(path)) wall.read.push_back(path);
  }
  for (const auto& agent : agents_) agent->add_reach(wall);
  if (!options_.run_folder.empty()) {
    const fs::path logs = options_.run_folder / "logs";
    std::error_code ignored;
    fs::create_directories(logs, ignored);
    wall.write.push_back(options_.run_folder);
    wall.links.push_back(logs);
  }
  wall.send_to = options_.sockets;
  return wall;
}

}  // namespace cxlab
