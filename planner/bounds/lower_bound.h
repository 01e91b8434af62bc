#pragma once
// A makespan that no plan can beat.
//
// Critical path: every fact has an earliest time, the latest of the conditions of its quickest achiever and the time
// that this takes (temporal h-max, Haslum and Geffner 2001). Resources: what needs the same key exclusively cannot
// overlap, so the work that every plan must do with it adds up, after the earliest time at which it can begin. Actions that
// need facts that are never true together are left out.

#include "planner/schedule/timeline.h"
#include "planner/search/budget.h"

namespace cxlab::planner {

Micros lower_bound(const GroundTask& task, Budget& budget);

}  // namespace cxlab::planner
