#include "scenarios/catalogue.h"

namespace cxlab {

constinit const WorldKind kEmptyWorld{.name = "none", .what = "nothing: agents and nodes on the bus alone"};

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
