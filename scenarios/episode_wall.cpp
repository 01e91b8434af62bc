// What an episode reaches of the machine once it plays.

#include "cx/executive/reach.h"
#include "scenarios/episode.h"
#include "scenarios/pddl_files.h"
#include "scenarios/share.h"

namespace cxlab {

namespace fs = std::filesystem;

Wall Episode::wall() const {
  Wall wall;
  const Share share = find_share();
  wall.read = {options_.interfaces, options_.models, share.pages, share.engines, scenario_.file};
  if (!share.prefix.empty()) wall.read.push_back(share.prefix / "lib");
  if (options_.replay) wall.read.insert(wall.read.end(), {options_.replay->inputs, options_.replay->copies});
  for (const auto& [key, file] : scenario_.world_files) wall.read.push_back(file.path);
  std::map<std::string, PackageSpec> packages = scenario_.packages;
  for (const AgentSpec& agent : scenario_.agents) packages.insert(agent.packages.begin(), agent.packages.end());
  if (!options_.replay) {
    for (const fs::path& file : pddl_files(scenario_)) wall.exact.push_back(file);
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
