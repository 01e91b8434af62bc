#include "planner/improve/rebuild.h"

#include <algorithm>
#include <limits>

namespace cxlab::planner {

namespace {

constexpr std::size_t kRebuildHistory = 20;
constexpr std::int64_t kSearchUnits = 30'000;  ///< a gap that takes longer to fill is not filled

}  // namespace

Rebuild::Rebuild(Decoder& decoder, const RelaxedTask& relaxed, std::uint64_t seed)
    : decoder_(decoder), relaxed_(relaxed), random_(seed, "planner rebuild") {}

bool Rebuild::start(const Sequence& plan) {
  if (!decoder_.decode(plan, std::numeric_limits<double>::infinity(), current_)) return false;
  best_ = current_;
  history_.assign(kRebuildHistory, current_.cost);
  return true;
}

void Rebuild::run(Budget& budget, std::int64_t most_idle, const LocalSearch::OnBetter& on_better) {
  const Simulator& simulator = decoder_.simulator();
  const Landmarks none(simulator, relaxed_, 0, budget);
  DecodedPlan tried;
  Sequence kept, filled;
  PackedState state;
  for (std::int64_t idle = 0; idle < most_idle && !current_.order.empty(); ++idle) {
    const Sequence rest = without_some();
    const bool advanced = decoder_.advance(rest, kept, state);
    budget.spend(Work::kSchedule, decoder_.take_work() + 10);
    if (budget.slice_over()) return;
    if (!advanced) continue;
    LazyOptions options;
    options.seed = random_.next() | 1;
    options.cost_noise = random_.chance(0.7) ? 3.0 : 0.5;
    SearchEnd end = SearchEnd::kBudget;
    {
      const BudgetSlice slice(budget, kSearchUnits);
      end = LazySearch(simulator, relaxed_, none, state, options).run(budget, filled);
    }
    if (end != SearchEnd::kFound) {
      if (budget.slice_over()) return;
      continue;
    }
    kept.insert(kept.end(), filled.begin(), filled.end());
    double& late = history_[static_cast<std::size_t>(tries_++) % history_.size()];
    const double threshold = std::max(late, current_.cost);
    const bool accepted = decoder_.decode(kept, threshold, tried) && tried.cost <= threshold;
    budget.spend(Work::kSchedule, decoder_.take_work() + 10);
    if (accepted) {
      current_ = tried;
      if (current_.aim() < best_.aim()) {
        best_ = current_;
        idle = 0;
        if (best_.lateness == 0) on_better(best_);
      }
    }
    if (current_.cost < late) late = current_.cost;
  }
}

/// The current plan without the actions of some goal, of some object, or of some stretch.
Sequence Rebuild::without_some() {
  const GroundTask& task = decoder_.original();
  const std::size_t size = current_.order.size();
  std::vector<char> out(size, 0);
  const auto an_action = [&]() -> const GroundAction* {
    const SequenceStep& step = current_.order[random_.below(size)];
    return is_event(step) ? nullptr : &task.actions[step.action];
  };
  const double kind = random_.uniform();
  if (kind < 0.4 && !task.goal.facts.empty()) {
    for (std::uint64_t times = 1 + random_.below(3); times > 0; --times) {
      const std::vector<char> own = belongs_to_goal(task.goal.facts[random_.below(task.goal.facts.size())]);
      for (std::size_t i = 0; i < size; ++i) out[i] |= own[i];
    }
  } else if (kind < 0.75) {
    const GroundAction* action = an_action();
    if (action && !action->arguments.empty()) {
      const ObjectId object = action->arguments[random_.below(action->arguments.size())];
      for (std::size_t i = 0; i < size; ++i)
        if (!is_event(current_.order[i])) {
          const auto& arguments = task.actions[current_.order[i].action].arguments;
          out[i] = std::ranges::find(arguments, object) != arguments.end() && (random_.chance(0.9));
        }
    }
  } else {
    const std::size_t length = 1 + random_.below(std::max<std::size_t>(2, size / 2)), from = random_.below(size);
    for (std::size_t i = from; i < std::min(size, from + length); ++i) out[i] = !is_event(current_.order[i]);
  }
  Sequence rest;
  for (std::size_t i = 0; i < size; ++i)
    if (!out[i]) rest.push_back(current_.order[i]);
  return rest;
}

/// Steps that only this goal needs.
std::vector<char> Rebuild::belongs_to_goal(int goal_fact) const {
  const Simulator& simulator = decoder_.simulator();
  const std::size_t size = current_.order.size();
  // needed[i]: whether the goal (1) or another one (2) needs what step i provides, by last providers.
  ById<int> provider(simulator.task().facts.size(), -1);
  std::vector<std::vector<int>> needs(size);
  for (std::size_t i = 0; i < size; ++i) {
    if (is_event(current_.order[i])) continue;
    const int action = current_.order[i].action;
    for (const int f : simulator.whole_condition(action).facts)
      if (provider[f] >= 0) needs[i].push_back(provider[f]);
    for (const int f : simulator.whole_effects(action).add) provider[f] = static_cast<int>(i);
  }
  ById<char> mine(size, 0), others(size, 0);
  for (const int f : simulator.task().goal.facts)
    if (provider[f] >= 0) (f == goal_fact ? mine : others)[provider[f]] = 1;
  for (std::size_t i = size; i-- > 0;)
    for (const int before : needs[i]) {
      mine[before] |= mine[i];
      others[before] |= others[i];
    }
  for (std::size_t i = 0; i < size; ++i) mine[i] = mine[i] && !others[i];
  return mine;
}

}  // namespace cxlab::planner
