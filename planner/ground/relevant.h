#pragma once
// Which actions can help towards the goal at all, judged by predicates alone.

#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// By action: whether it adds a predicate that is asked for, deletes one whose absence is asked for, or changes a
/// number that is read or must have a value first, counting what the goal and actions that are relevant themselves ask
/// for.
std::vector<char> relevant_actions(const Task& task);

}  // namespace cxlab::planner
