#pragma once
// Facts that are never true together, and actions that therefore cannot happen (h2, Haslum and Geffner 2000).

#include "planner/ground/task.h"

namespace cxlab::planner {

/// By action: whether its start and its end can happen, as far as pairs of facts tell. Beginnings and ends count one by
/// one, so that overlapping plans are covered; numbers are taken to allow everything. All if there are derived facts or
/// more than `most_facts`.
std::vector<char> possible_actions(const GroundTask& task, std::size_t most_facts = 1500);

}  // namespace cxlab::planner
