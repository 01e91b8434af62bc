#pragma once
// The trainer of an agent beside the world: `servers: [cx_rl_node]` (docs/how-to/train-over-cx-rl.md).

#include "scenarios/catalogue.h"

namespace cxlab::rl {

extern const NodeKind kNode;

}  // namespace cxlab::rl
