#pragma once
// The trainer of an agent beside the world: `servers: [cx_rl_node]` (docs/rl.md).

#include "scenarios/catalogue.h"

namespace cxlab::rl {

extern const NodeKind kNode;

}  // namespace cxlab::rl
