#pragma once
// From a problem with variables to a ground task.

#include "cx/base/expected.h"
#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// Writes out all actions that can become applicable. Fails if there are too many (Failure::kOutOfMemory) or the budget
/// does not suffice (kOutOfBudget).
Expected<GroundTask> ground(const Task& task, Budget& budget);
inline Expected<GroundTask> ground(const Task& task) {
  Budget unlimited;
  return ground(task, unlimited);
}

/// The same without what is found by pairs of facts, and without all that comes after it.
Expected<GroundTask> ground_by_facts(const Task& task, Budget& budget);

/// Removes what cannot happen, what is always so and what nothing reads, and detects a goal out of reach.
/// `ground` has done it. Not to be used further if the budget ended.
void prune(GroundTask& task, Budget& budget);
void prune_by_facts(GroundTask& task, Budget& budget);

}  // namespace cxlab::planner
