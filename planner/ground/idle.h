#pragma once
// What validators keep apart although no plan depends on it.

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// Fills in GroundAction::idle and TimedEvent::idle of a pruned task. Incomplete if the budget ends.
void find_idle(const Task& task, GroundTask& ground, Budget& budget);

}  // namespace cxlab::planner
