#include "scenarios/catalogue.h"

#include <algorithm>

#include "scenarios/begin.h"

namespace cxlab {

constinit const WorldKind kEmptyWorld{.name = "none", .what = "nothing: agents and nodes on the bus alone"};

constinit const SectionKind kBegin = [] {
  SectionKind kind = section_of<Begin>("begin");
  kind.elsewhere = "this world is not about the middle of anything";
  return kind;
}();

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

std::vector<const SectionKind*> Catalogue::sections() const {
  std::vector<const SectionKind*> out;
  const auto add = [&out](const auto& kinds) {
    for (const auto* kind : kinds)
      for (const SectionKind* section : kind->reads)
        if (std::ranges::find(out, section) == out.end()) out.push_back(section);
  };
  add(worlds);
  add(nodes);
  return out;
}

}  // namespace cxlab
