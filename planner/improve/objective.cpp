#include "planner/improve/objective.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cxlab::planner {

namespace {

constexpr double kRounding = 1e-14;  ///< of sums of doubles

LinearForm form_of(GroundExpression metric) {
  for (auto& step : metric.steps)
    if (step.kind == GroundExpression::Kind::kTotalTime) step.kind = GroundExpression::Kind::kDuration;
  return linear_form(metric);
}

}  // namespace

Objective::Objective(const Simulator& simulator)
    : task_(simulator.task()), initial_(task_.initial_numbers), changes_(task_.actions.size(), 0.0) {
  if (task_.metric.steps.empty()) return;
  linear_ = form_of(task_.metric);
  is_makespan_ = linear_.is_linear && linear_.weights.empty() && linear_.duration_weight > 0;
  if (is_makespan_) return;
  time_weight_ = linear_.duration_weight;
  never_falls_ = linear_.is_linear && time_weight_ >= 0;
  const PackedState initial = simulator.initial();
  for (std::size_t a = 0; a < task_.actions.size(); ++a) {
    const GroundAction& action = task_.actions[a];
    for_each_effects(action, [this](const GroundEffects& effects) { look_at(effects); });
    for (const ContinuousEffect& effect : action.continuous)
      if (weight(effect.number) != 0) never_falls_ = false;
    const std::optional<DurationRange> range =
        action.durative ? simulator.durations(static_cast<int>(a), initial.data()) : DurationRange{};
    const double duration_s = range ? in_seconds(range->least) : 0;
    durations_s_.push_back(duration_s);
    changes_[a] = change_of(action.at_start, duration_s) + change_of(action.at_end, duration_s);
  }
  for (const TimedEvent& event : task_.events) look_at(event.effects);
}

double Objective::weight(int number) const {
  if (!linear_.is_linear) return 0;
  const auto found = std::ranges::find(linear_.weights, number, &std::pair<int, double>::first);
  return found == linear_.weights.end() ? 0 : found->second;
}

void Objective::look_at(const GroundEffects& effects) {
  for (const NumericEffect& effect : effects.numbers) {
    const double w = weight(effect.number);
    if (w == 0) continue;
    const LinearForm by = linear_form(effect.value);
    const bool known = effect.kind == NumericEffect::Kind::kIncrease && by.is_linear && by.weights.empty();
    if (!known || !(w * by.constant >= 0) || !(w * by.duration_weight >= 0)) never_falls_ = false;
  }
}

double Objective::change_of(const GroundEffects& effects, double duration_s) const {
  double sum = 0;
  for (const NumericEffect& effect : effects.numbers) {
    const LinearForm by = linear_form(effect.value);
    if (effect.kind == NumericEffect::Kind::kIncrease && by.is_linear && by.weights.empty())
      sum += weight(effect.number) * (by.constant + by.duration_weight * duration_s);
  }
  return sum;
}

double Objective::value_of(double metric, Micros makespan) {
  if (!std::isfinite(metric)) return std::numeric_limits<double>::infinity();
  return std::round(metric * kMillion) + in_seconds(makespan) / (1 + in_seconds(makespan));
}

std::optional<double> Objective::bound(Micros least_makespan) const {
  if (is_makespan_)
    return task_.metric.steps.empty() ? in_seconds(least_makespan)
                                      : linear_.constant + linear_.duration_weight * in_seconds(least_makespan);
  const double least = task_.metric.evaluate(initial_.data(), 0, in_seconds(least_makespan));
  if (!never_falls_ || !std::isfinite(least)) return std::nullopt;
  return least;
}

std::optional<GroundComparison> Objective::better_than(double metric, Micros least_makespan) const {
  if (is_makespan_ || !linear_.is_linear || linear_.weights.empty() || time_weight_ < 0 || !std::isfinite(metric))
    return std::nullopt;
  const auto bound = GroundExpression::constant(metric - std::max(1 / kMillion, kRounding * std::abs(metric)));
  GroundExpression best;
  for (const auto& step : task_.metric.steps) {
    if (step.kind == GroundExpression::Kind::kTotalTime)
      best.steps.push_back({GroundExpression::Kind::kConstant, -1, in_seconds(least_makespan)});
    else
      best.steps.push_back(step);
  }
  return GroundComparison::of(GroundComparison::Kind::kNotNegative, bound, best);
}

std::vector<int> Objective::prices() const {
  std::vector<double> costs;
  double sum = 0;
  for (std::size_t a = 0; a < changes_.size(); ++a) {
    costs.push_back(std::max(0.0, changes_[a] + std::max(0.0, time_weight_) * durations_s_[a]));
    sum += costs.back();
  }
  const double mean = sum / std::max<double>(1, static_cast<double>(costs.size()));
  std::vector<int> prices;
  for (const double cost : costs)
    prices.push_back(1 + (mean > 0 ? static_cast<int>(std::min(10 * cost / mean, 100.0)) : 0));
  return prices;
}

}  // namespace cxlab::planner
