#pragma once
// Strategy: continue a plan under execution. A search adds the steps that are missing after it.

#include "planner/strategies/context.h"

namespace cxlab::planner {

/// For problems without events, offers what is left of `PlanOptions::warm_start`; the search for missing steps may take
/// `most_units`. True if a plan exists afterwards.
bool warm_start(PlanningContext& context, std::int64_t most_units);

}  // namespace cxlab::planner
