#include "planner/ground/passes.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostAims = 8;   ///< copies of an action that last until a comparison turns
constexpr std::int64_t kCopyWork = 4;  ///< of a copy, in pieces of Work::kGround

/// Comparisons that the length of the action may turn, those of the goal and its own first.
std::vector<int> aims(const GroundTask& task, const GroundAction& action) {
  ById<char> changes(task.numbers.size(), 0);
  for (const ContinuousEffect& effect : action.continuous) changes[effect.number] = 1;
  for (const auto* effects : {&action.at_start, &action.at_end})
    for (const NumericEffect& effect : effects->numbers) changes[effect.number] = 1;
  std::vector<int> order = task.goal.comparisons;
  order.insert(order.end(), action.over_all.comparisons.begin(), action.over_all.comparisons.end());
  for (std::size_t c = 0; c < task.comparisons.size(); ++c) order.push_back(static_cast<int>(c));
  std::vector<int> found;
  for (const int c : order) {
    const LinearForm& linear = task.comparisons[c].linear;
    if (found.size() == kMostAims) break;
    if (linear.is_linear && std::ranges::find(found, c) == found.end() &&
        std::ranges::any_of(linear.weights, [&](const auto& weight) { return changes[weight.first] != 0; }))
      found.push_back(c);
  }
  return found;
}

}  // namespace

void offer_durations(GroundTask& task, Budget& budget) {
  ById<GroundAction> offered;
  for (GroundAction& action : task.actions) {
    budget.spend(Work::kGround, 1);
    if (budget.over()) return;
    bool depends = !action.continuous.empty();
    for (const auto* effects : {&action.at_start, &action.at_end})
      for (const NumericEffect& effect : effects->numbers) depends = depends || effect.value.mentions_duration();
    for (const auto* condition : {&action.start, &action.over_all, &action.end})
      for (const int c : condition->comparisons)
        depends = depends || task.comparisons[c].expression.mentions_duration();
    const bool chosen = action.durative && depends && std::ranges::none_of(action.duration, [](const auto& d) {
                          return d.comparison == Comparison::kEqual;
                        });
    if (!chosen) {
      offered.push_back(std::move(action));
      continue;
    }
    budget.spend(Work::kGround,
                 static_cast<std::int64_t>(task.comparisons.size()) + kCopyWork * static_cast<std::int64_t>(kMostAims));
    for (const int aim : aims(task, action)) {
      offered.push_back(action);
      offered.back().aim = aim;
    }
    offered.push_back(action);
    for (const double stretch : {0.125, 0.25, 0.5, 1.0}) {
      offered.push_back(action);
      offered.back().stretch = stretch;
    }
  }
  task.actions = std::move(offered);
}

}  // namespace cxlab::planner
