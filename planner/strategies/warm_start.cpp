#include "planner/strategies/warm_start.h"

#include <algorithm>

#include "planner/improve/remainder.h"
#include "planner/strategies/late_repair.h"

namespace cxlab::planner {

bool warm_start(PlanningContext& context, std::int64_t most_units) {
  const Plan& plan = context.options.warm_start;
  if (plan.empty()) return false;
  const SearchSpace& space = context.whole.space;
  Remainder remainder(space.simulator, context.budget);
  Remainder::Done done = remainder.of(plan);
  if (!remainder.is_goal(done)) {
    const BudgetSlice slice(context.budget, most_units);
    LazySearch search(space.simulator, space.relaxed, space.landmarks, done.state, context.search_options(0));
    Sequence rest;
    if (search.run(context.budget, rest) != SearchEnd::kFound) return false;
    done.steps.insert(done.steps.end(), rest.begin(), rest.end());
  }
  const bool waits_for_events = std::ranges::any_of(done.steps, is_event);
  const Sequence left = waits_for_events ? std::move(done.steps) : remainder.without_needless(std::move(done.steps));
  if (context.has_events()) return bring_in_time(context, left, {0, most_units});
  context.offer_found(left);
  return context.best.exists();
}

}  // namespace cxlab::planner
