#pragma once
// From a problem with variables to a ground task.

#include <cstddef>

#include "cx/base/expected.h"
#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

struct GroundOptions {
  std::size_t most_actions = 1'000'000;  ///< beyond it the problem does not fit into memory
};

/// Writes out all actions that can become applicable. Fails if there are too many (Failure::kOutOfMemory) or the budget
/// does not suffice (kOutOfBudget).
Expected<GroundTask> ground(const Task& task, Budget& budget, const GroundOptions& options = {});
inline Expected<GroundTask> ground(const Task& task) {
  Budget unlimited;
  return ground(task, unlimited);
}

/// Removes what cannot happen, what is always so and what nothing reads, and detects a goal out of reach.
/// `ground` has done it. Not to be used further if the budget ended.
void prune(GroundTask& task, Budget& budget);

}  // namespace cxlab::planner
