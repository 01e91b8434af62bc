#pragma once
// What plans are compared by: the problem's metric, or the makespan where there is none or it decides the same.

#include <optional>
#include <vector>

#include "planner/search/simulator.h"

namespace cxlab::planner {

/// Less is better. A value counts whole millionths of a second or of the metric (negated where it is to be maximized),
/// so that rounding of sums is no progress; a fraction below 1 lets the makespan decide among equal metrics.
class Objective {
 public:
  explicit Objective(const Simulator& simulator);

  bool is_makespan() const { return is_makespan_; }
  /// Infinite where the metric is undefined.
  double value(const double* numbers, Micros makespan) const {
    return is_makespan_ ? static_cast<double>(makespan)
                        : value_of(task_.metric.evaluate(numbers, 0, in_seconds(makespan)), makespan);
  }
  /// Whether the value is above `most`, without computing it where the metric is far below.
  bool exceeds(const double* numbers, Micros makespan, double most) const {
    if (is_makespan_) return static_cast<double>(makespan) > most;
    const double metric = task_.metric.evaluate(numbers, 0, in_seconds(makespan));
    return !(metric * kMillion + 2 <= most) && value_of(metric, makespan) > most;
  }
  /// The same of a metric that has been computed (negated where it is to be made large).
  static double value_of(double metric, Micros makespan);
  /// Whether more actions never make a plan better.
  bool never_falls() const { return never_falls_; }
  /// What a second counts, in units of the metric; 1 for the makespan.
  double time_weight() const { return time_weight_; }

  /// The least metric of any plan that takes at least this long; none: not known.
  std::optional<double> bound(Micros least_makespan) const;
  /// What the numbers must keep to in a plan with a metric under `metric`; none: any numbers may do.
  std::optional<GroundComparison> better_than(double metric, Micros least_makespan) const;
  /// What an action adds to the metric at its shortest, but for its time; 0 where that depends on the state.
  double change(int action) const { return changes_[action]; }
  /// Costs of actions for searches: 1, and tenths of the mean of what they add to the metric one after the other.
  std::vector<int> prices() const;

 private:
  static constexpr double kMillion = 1e6;

  double weight(int number) const;
  void look_at(const GroundEffects& effects);
  double change_of(const GroundEffects& effects, double duration_s) const;

  const GroundTask& task_;
  const std::vector<double> initial_;
  LinearForm linear_;  ///< of the metric; the duration stands for total-time
  bool is_makespan_ = true, never_falls_ = true;
  double time_weight_ = 1;
  ById<double> changes_, durations_s_;  ///< by action
};

}  // namespace cxlab::planner
