#pragma once
// A makespan that no plan can beat.
//
// Critical path: every fact has an earliest time, the latest of the conditions of its quickest achiever and the time
// that this takes (temporal h-max, Haslum and Geffner 2001); the same for pairs of facts (pair_times.h). Then
// activities, sets of actions of which every plan has one (all achievers of a landmark): the times of pairs right after
// each of their actions are how far apart two activities must begin and how long the plan then continues, and no order
// of them is shorter than sequencing.h computes. Robots, machines and places that only one can have at a time need not
// be known: they show as times between beginnings. Actions that need facts that are never true together are left out.

#include "planner/ground/budget.h"
#include "planner/schedule/timeline.h"

namespace cxlab::planner {

struct LowerBound {
  Micros makespan = 0;
  /// It holds only for plans in which no two actions change the same fact at the same instant. Some validators accept
  /// that two actions end at one instant where each of them would break a condition over all of the other.
  bool assumes_order = false;
  bool complete = true;  ///< false: more than `slice` units might raise it
};

/// If the time runs out, what is known by then.
LowerBound lower_bound(const GroundTask& task, Budget& budget, std::int64_t slice);

}  // namespace cxlab::planner
