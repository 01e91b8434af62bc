#include "planner/strategies/unsolvable.h"

namespace cxlab::planner {

Conclusion prove_unsolvable(PlanningContext& context) {
  if (!context.has_events() && !context.has_durations)
    return {PlanStatus::kUnsolvable, "no order of actions reaches the goal"};
  const std::optional<GroundTask> untimed_task = untimed(context.ground, Ends::kAsBegun);
  if (!untimed_task) return kNoPlan;
  const SearchSpace space(*untimed_task, context.budget);
  const PackedState start = space.simulator.initial();
  LazySearch search(space.simulator, space.relaxed, space.landmarks, start, context.search_options(0));
  Sequence found;
  switch (search.run(context.budget, found)) {
    case SearchEnd::kExhausted:
      return {PlanStatus::kUnsolvable, "no order of happenings reaches the goal, whatever their times"};
    case SearchEnd::kBudget: return {PlanStatus::kBudget, "the budget ended before a plan was found"};
    default: return kNoPlan;
  }
}

}  // namespace cxlab::planner
