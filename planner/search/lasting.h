#pragma once
// Conditions over all that only some achievers of a fact can keep.
//
// An action may make a fact true for its own duration only. Then it does not help an action that needs the fact for
// longer: an oven that is hot for 8 s cannot bake for 15 s. The relaxed task alone does not show that.

#include "planner/ground/task.h"

namespace cxlab::planner {

/// The task with one more fact for each such condition: its fact is true, and an achiever that lasts long enough made
/// it true. The task has the same plans and the same actions; the facts of `task` come first.
GroundTask with_lasting_facts(const GroundTask& task);

}  // namespace cxlab::planner
