#pragma once
// Strategy: what is left of a plan under execution. A search fills in what is missing behind it.

#include "planner/strategies/context.h"

namespace cxlab::planner {

/// Takes `PlanOptions::warm_start` for problems without events and offers what it gives; a search behind it may take
/// `most_units`. True if a plan exists afterwards.
bool warm_start(PlanningContext& context, std::int64_t most_units);

}  // namespace cxlab::planner
