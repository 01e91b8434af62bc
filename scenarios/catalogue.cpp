#include "scenarios/catalogue.h"

namespace cxlab {

constinit const WorldKind kEmptyWorld{.name = "none", .what = "nothing: agents and nodes on the bus alone"};

std::string games_path(const WorldKind& world) {
  return world.games_key.empty() ? std::string() : "world." + std::string(world.games_key);
}

const WorldKind* Catalogue::find_world(std::string_view name) const {
  for (const WorldKind* kind : worlds)
    if (kind->name == name) return kind;
  return name == kEmptyWorld.name ? &kEmptyWorld : nullptr;
}

const NodeKind* Catalogue::find_node(std::string_view name) const {
  for (const NodeKind* kind : nodes)
    if (kind->name == name) return kind;
  return nullptr;
}

}  // namespace cxlab
