#include "planner/strategies/improvement.h"

#include <algorithm>

#include "planner/improve/rebuild.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kLeastRebuild = 20'000;  ///< units

RelaxedTask with_prices(const PlanningContext& context) {
  const Simulator& simulator = context.whole.space.simulator;
  return context.best.by_metric() ? RelaxedTask(simulator, context.objective.prices()) : RelaxedTask(simulator, false);
}

auto offer_to(PlanningContext& context, const SplitSpace& space) {
  return [&](const DecodedPlan& plan) {
    if (plan.value < context.best.value()) context.offer(space, plan.order);
  };
}

}  // namespace

Improvement::Improvement(PlanningContext& context)
    : context_(context),
      priced_(with_prices(context)),
      decoder_(context.whole.split, context.ground, context.whole.space.simulator, context.touches, context.objective) {
}

bool Improvement::of_list(const Sequence& list, std::uint64_t round, std::int64_t most_idle) {
  Budget& budget = context_.budget;
  LocalSearch local(decoder_, context_.whole.space.simulator, round + 1);
  if (list.empty() || !local.start(list)) return false;
  const auto offer = offer_to(context_, context_.whole);
  const std::int64_t began = budget.units();
  if (context_.best.by_metric() && local.best().lateness == 0) offer(local.best());
  local.run(budget, most_idle, offer);
  Rebuild rebuild(decoder_, priced_, round + 1);
  if (!rebuild.start(local.best().order)) return false;
  const BudgetSlice slice(budget, std::max(kLeastRebuild, budget.units() - began));
  rebuild.run(budget, most_idle, offer);
  return true;
}

void Improvement::of_parts(const SplitSpace& cut, const Sequence& list, std::uint64_t round, std::int64_t most_idle) {
  Decoder decoder(cut.split, context_.ground, cut.space.simulator, context_.touches, context_.objective);
  LocalSearch local(decoder, context_.whole.space.simulator, round + 1);
  if (local.start(list)) local.run(context_.budget, most_idle, offer_to(context_, cut));
}

BetterMetricSearch::BetterMetricSearch(PlanningContext& context, const SplitSpace& space)
    : context_(context), space_(space) {
  if (&space != &context.whole) check_.emplace(space.split, context.ground, space.space.simulator, context.touches);
}

std::optional<Sequence> BetterMetricSearch::run(const Turn& turn) {
  if (exhausted_) return std::nullopt;
  std::optional<GroundComparison> better =
      context_.objective.better_than(context_.best.cost(), context_.bound.makespan());
  exhausted_ = !better;
  if (!better || context_.budget.late()) return std::nullopt;
  GroundTask task = space_.split.task;
  task.goal.comparisons.push_back(static_cast<int>(task.comparisons.size()));
  task.comparisons.push_back(std::move(*better));
  const Simulator simulator(task);
  if (context_.budget.late()) return std::nullopt;
  const RelaxedTask relaxed(simulator, Objective(simulator).prices());
  const Landmarks none(simulator, relaxed, 0, context_.budget);
  LazySearch search(simulator, relaxed, none, simulator.initial(), context_.search_options(turn.round),
                    check_ ? &*check_ : nullptr);
  Sequence found;
  const BudgetSlice slice(context_.budget, turn.units);
  const SearchEnd end = search.run(context_.budget, found);
  exhausted_ = end == SearchEnd::kExhausted;
  return end == SearchEnd::kFound ? std::optional(std::move(found)) : std::nullopt;
}

}  // namespace cxlab::planner
