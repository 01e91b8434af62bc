#pragma once
// Facts that are never true together, and actions that therefore cannot happen (h2, Haslum and Geffner 2000).

#include <vector>

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// What can happen, judged by pairs of facts.
struct Possible {
  ById<char> actions;  ///< by action: its start and its end
  bool goal = true;    ///< the goal can hold
};

/// Beginnings and ends count one by one, so that overlapping plans are covered; numbers are taken to allow everything.
/// All is possible if there are derived facts or more than 1,500, or the budget ends.
Possible possible_by_pairs(const GroundTask& task, Budget& budget);

}  // namespace cxlab::planner
