#include "lab/confine.h"

namespace cxlab::lab {

void confine(const Episode& episode, const Host& host, const Wall& more) {
  if (episode.scenario().trust_rules) return;
  Wall wall = episode.wall();
  wall.read.insert(wall.read.end(), more.read.begin(), more.read.end());
  wall.write.insert(wall.write.end(), more.write.begin(), more.write.end());
  wall.exact.insert(wall.exact.end(), more.exact.begin(), more.exact.end());
  wall.list.insert(wall.list.end(), more.list.begin(), more.list.end());
  wall.links.insert(wall.links.end(), more.links.begin(), more.links.end());
  wall.pictures = more.pictures;
  confine(host, wall);
}

void confine(const Host& host, const Wall& wall) {
  if (!kPlaysBehindWalls || !host.confine) return;
  if (const Status raised = raise_wall(wall); !raised) host.note("warning: " + raised.error().message);
}

std::optional<std::string> warning_without_wall() {
  const WallParts parts = wall_parts();
  if (parts.whole()) return std::nullopt;
  return "warning: this kernel has " + parts.text() +
         ": only cxlab checks the rules, and the kernel does not confine them as well; cxlab doctor shows more";
}

}  // namespace cxlab::lab
