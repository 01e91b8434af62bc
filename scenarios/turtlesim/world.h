#pragma once
// Turtles on a canvas as a world, `world: {kind: turtlesim, ...}`, and as a node beside one, `servers: [turtlesim]`
// (docs/reference/turtlesim.md).

#include "scenarios/catalogue.h"

namespace cxlab::turtlesim {

extern const WorldKind kWorld;
extern const NodeKind kNode;

}  // namespace cxlab::turtlesim
