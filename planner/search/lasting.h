#pragma once
// Conditions over all that only some of those who make a fact true last long enough for.
//
// Where an action makes a fact true for its own duration only, what needs the fact for longer must look for another: an
// oven that is hot for 8 s is of no use to what bakes for 15. The relaxed task would not know that.

#include "planner/ground/task.h"

namespace cxlab::planner {

/// The task with a fact more for each such condition: that its fact is true and was made true by what lasts long
/// enough. It has the same plans and the same actions; the facts of `task` come first.
GroundTask with_lasting_facts(const GroundTask& task);

}  // namespace cxlab::planner
