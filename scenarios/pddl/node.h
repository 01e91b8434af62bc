#pragma once
// A PDDL manager beside the world: `servers: [pddl_manager]` (docs/reference/pddl-manager.md).

#include "scenarios/catalogue.h"

namespace cxlab::pddl {

extern const NodeKind kNode;

}  // namespace cxlab::pddl
