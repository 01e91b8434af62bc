#include "planner/search/loose.h"

#include <algorithm>

#include "planner/search/split.h"

namespace cxlab::planner {

LooseEstimate::LooseEstimate(const GroundTask& task)
    : task_(task), loose_(loosened(task, true)), simulator_(loose_), relaxed_(simulator_, true) {
  int fact = static_cast<int>(task.facts.size());
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    origins_.push_back(static_cast<int>(a));
    if (action.durative) origins_.push_back(static_cast<int>(a));
    is_running_.push_back(action.durative ? fact++ : -1);
  }
}

int LooseEstimate::evaluate(RelaxedHeuristic& heuristic, const Word* state, const double* numbers_now, int next_event,
                            std::span<const Running> running) {
  state_.assign(static_cast<std::size_t>(simulator_.words()), 0);
  std::copy_n(state, task_.words(), state_.begin());
  for (const Running& each : running) {
    set(state_.data(), is_running_[each.action]);
    for (const int f : task_.actions[each.action].at_end.add) set(state_.data(), f);
  }
  double* numbers = reinterpret_cast<double*>(state_.data() + loose_.words());
  std::copy_n(numbers_now, task_.numbers.size(), numbers);
  preferred_.assign(task_.actions.size(), 0);
  const auto evaluate_now = [&] {
    const int found = heuristic.evaluate(state_.data(), next_event);
    for (const int action : heuristic.preferred())
      if (action >= 0) preferred_[origins_[action]] = 1;
    return found;
  };
  int best = evaluate_now();
  bool projected = false;
  for (const Running& each : running) {
    if (!each.left) continue;
    const GroundAction& action = task_.actions[each.action];
    const double left = in_seconds(*each.left), length = in_seconds(each.length);
    for (const ContinuousEffect& effect : action.continuous) {
      numbers[effect.number] += effect.rate.evaluate(numbers, length) * left;
      projected = true;
    }
    for (const NumericEffect& effect : action.at_end.numbers) {
      change(numbers[effect.number], effect.kind, effect.value.evaluate(numbers, length));
      projected = true;
    }
  }
  if (projected) best = std::min(best, evaluate_now());
  return best;
}

}  // namespace cxlab::planner
