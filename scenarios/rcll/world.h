#pragma once
// The world of a Logistics League game: `world: {kind: rcll, ...}` (docs/rcll.md).

#include "scenarios/catalogue.h"

namespace cxlab::rcll {

extern const WorldKind kWorld;

}  // namespace cxlab::rcll
