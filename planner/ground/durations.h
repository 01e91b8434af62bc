#pragma once
// Durations that may be chosen.

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// Where effects depend on a duration that may be chosen, the action is there with several. Incomplete if the budget
/// ends.
void offer_durations(GroundTask& task, Budget& budget);

}  // namespace cxlab::planner
