#pragma once
// A makespan that no plan can beat.
//
// Critical path: every fact has an earliest time. It is the latest time of the conditions of its quickest achiever,
// plus the time that this achiever takes (temporal h-max, Haslum and Geffner 2001). Pairs of facts have such times too
// (pair_times.h). An activity is a set of actions of which every plan has one: all achievers of a landmark. The times
// of pairs right after each of these actions tell how far apart two activities must begin, and how long the plan then
// continues. No order of activities is shorter than sequencing.h computes. The bound need not know which robots,
// machines and places only one action can use at a time: they show as times between beginnings. Actions that need facts
// that are never true together are left out.

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
