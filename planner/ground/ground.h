#pragma once
// From a problem with variables to a ground task.

#include <cstddef>

#include "cx/base/expected.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

struct GroundOptions {
  std::size_t most_actions = 1'000'000;  ///< beyond it the problem does not fit into memory
};

/// Writes out all actions that can become applicable. Fails (kResource, code "memory") if there are too many.
Expected<GroundTask> ground(const Task& task, const GroundOptions& options = {});

/// Removes what cannot happen, what is always so and what nobody asks, and finds the goal out of reach if it is.
/// `ground` has done it.
void prune(GroundTask& task);

}  // namespace cxlab::planner
