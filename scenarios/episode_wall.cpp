// The parts of the machine that an episode reaches while it plays.

#include "cx/executive/reach.h"
#include "scenarios/episode.h"
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
  wall.exact = stage_->readable;
  if (!options_.replay) {
    if (agents_.empty())  // else each agent adds what it sees
      for (const auto& [name, folder] : scenario_.shares({})) cx::add_package(folder, wall);
    for (const fs::path& path : cx::paths_in(scenario_.text.empty() ? scenario_.to_yaml() : scenario_.text))
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
  wall.send_to = options_.spec.sockets;
  return wall;
}

}  // namespace cxlab
