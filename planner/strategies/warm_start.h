#pragma once
// Strategy: continue a plan under execution. A search adds the steps that are missing after it.

#include "planner/strategies/context.h"

namespace cxlab::planner {

/// Offers what is left of `PlanOptions::warm_start`. The search for missing steps may take `most_units`, and so may
/// bringing the steps in time for events. True if a plan exists afterwards.
bool warm_start(PlanningContext& context, std::int64_t most_units);

}  // namespace cxlab::planner
