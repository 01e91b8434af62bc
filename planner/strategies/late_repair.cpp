#include "planner/strategies/late_repair.h"

#include <utility>

#include "planner/improve/rebuild.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kMostIdleMoves = 1000;
constexpr std::int64_t kMostIdleRebuilds = 100;

}  // namespace

bool bring_in_time(PlanningContext& context, Sequence list, const Turn& turn) {
  Budget& budget = context.budget;
  const SplitSpace& whole = context.whole;
  Decoder decoder(whole.split, context.ground, whole.space.simulator, context.touches, context.objective);
  const RelaxedTask timed(whole.space.simulator, false);
  const std::int64_t until = budget.units() + turn.units;
  BudgetSlice slice(budget, turn.units);
  const auto in_time = [&](const DecodedPlan& plan) {
    if (!context.best.exists() && context.offer(whole, plan.order)) slice.end();
  };
  std::int64_t spent = -1;
  for (std::uint64_t round = 0; !context.best.exists() && budget.units() < until && !budget.over(); ++round) {
    if (std::exchange(spent, budget.units()) == budget.units()) break;  // no list has a move
    LocalSearch local(decoder, whole.space.simulator, turn.round + round);
    local.exchange_late_steps();
    if (!local.start(list)) break;
    if (local.best().lateness == 0) in_time(local.best());
    local.run(budget, kMostIdleMoves, in_time);
    Rebuild rebuild(decoder, timed, turn.round + round);
    if (context.best.exists() || !rebuild.start(local.best().order)) break;
    rebuild.run(budget, kMostIdleRebuilds, in_time);
    list = rebuild.best().order;
  }
  return context.best.exists();
}

bool repair_late(PlanningContext& context, SequenceSearch& sequences, const Turn& turn) {
  std::optional<Sequence> list = sequences.find(turn);
  return list && bring_in_time(context, *std::move(list), {turn.round, 2 * turn.units});
}

}  // namespace cxlab::planner
