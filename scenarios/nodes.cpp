#include "scenarios/nodes.h"

#include <array>

#include "scenarios/pddl/stage.h"
#include "scenarios/turtlesim/read_config.h"
#include "scenarios/turtlesim/stage.h"

namespace cxlab {

namespace {

constexpr std::array kKinds{
    NodeKind{"turtlesim", "turtles on a canvas (docs/turtlesim.md)",
             [](yaml::Map& keys, ServerSpec& spec) { turtlesim::read_config(keys, spec.turtlesim); },
             [](const ServerSpec& spec, const NodeSetup& setup, Stage& stage) {
               return turtlesim::add_turtlesim(spec.turtlesim, stage, setup.bus, setup.sink, setup.log);
             }},
    NodeKind{"pddl_manager", "keeps PDDL instances and plans (docs/pddl-manager.md)",
             [](yaml::Map& keys, ServerSpec& spec) { pddl::read_config(keys, spec.pddl); },
             [](const ServerSpec& spec, const NodeSetup& setup, Stage& stage) {
               return pddl::add_manager(spec.pddl, setup, stage);
             }},
};

}  // namespace

std::span<const NodeKind> node_kinds() { return kKinds; }

const NodeKind* find_node(std::string_view name) {
  for (const NodeKind& kind : kKinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

}  // namespace cxlab
