#include "planner/strategies/clock_strategy.h"

#include <algorithm>

namespace cxlab::planner {

bool ClockStrategy::is_needed() const {
  return std::ranges::any_of(context_.ground.actions, [this](const GroundAction& action) {
    return action.durative && !can_be_cut(context_.ground, action);
  });
}

bool ClockStrategy::run(const Turn& turn) {
  if (exhausted_ || context_.budget.late()) return false;
  if (!search_ && !is_needed()) {
    exhausted_ = true;
    return false;
  }
  if (!search_)
    search_ = std::make_unique<ClockSearch>(context_.ground, context_.whole.space.simulator, context_.touches);
  const Micros before = context_.best.by_metric() ? DurationRange::kForever : context_.best.makespan();
  const BudgetSlice slice(context_.budget, turn.units);
  const SearchEnd end =
      search_->run(context_.search_options(turn.round), before, context_.budget,
                   [this](const std::vector<ClockStep>& steps) { return context_.best.offer(steps); });
  exhausted_ = end == SearchEnd::kExhausted;
  return end == SearchEnd::kFound;
}

}  // namespace cxlab::planner
