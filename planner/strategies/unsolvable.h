#pragma once
// Strategy: when every search has ended without a plan, try to prove that no plan exists.

#include "planner/strategies/context.h"

namespace cxlab::planner {

struct Conclusion {
  PlanStatus status = PlanStatus::kEnded;
  std::string reason;
};

/// Everything was tried, without a plan or a proof.
inline const Conclusion kNoPlan{PlanStatus::kEnded, "no plan was found by any search; that none exists is not proved"};

/// Looks whether any order of happenings reaches the goal, whatever their times; takes all that is left of the budget.
/// Without durations and events the searches were the proof.
Conclusion prove_unsolvable(PlanningContext& context);

}  // namespace cxlab::planner
