#include "planner/strategies/warm_start.h"

#include "planner/improve/remainder.h"

namespace cxlab::planner {

bool warm_start(PlanningContext& context, std::int64_t most_units) {
  const Plan& plan = context.options.warm_start;
  if (plan.empty() || context.has_events()) return false;
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
  context.offer_found(remainder.without_needless(std::move(done.steps)));
  return context.best.exists();
}

}  // namespace cxlab::planner
