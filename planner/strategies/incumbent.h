#pragma once
// The best plan so far. A plan that is offered gets its times, is judged by the validator, and is published if it is
// better than all before it.

#include <chrono>
#include <limits>

#include "planner/improve/objective.h"
#include "planner/planner.h"
#include "planner/search/clock.h"
#include "planner/search/split.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

class Incumbent {
 public:
  using Clock = std::chrono::steady_clock;

  /// `began`: when the planner was called. `on_plan` may be empty.
  Incumbent(const Task& task, const GroundTask& ground, const Touches& touches, const Objective& objective,
            Budget& budget, const decltype(PlanOptions::on_plan)& on_plan, Clock::time_point began);

  /// Each returns true if the plan is the best now. The steps begin as early as they can.
  bool offer(const Concurrent& plan);
  /// The steps keep their times.
  bool offer(const std::vector<ClockStep>& steps);

  bool exists() const { return plan_.has_value(); }
  const TimedPlan& plan() const { return *plan_; }
  /// The value of the objective; infinite while no plan is known.
  double value() const { return value_; }
  Micros makespan() const { return makespan_; }
  /// The problem's metric with the sign that makes less better; not a number where it is undefined.
  double cost() const;
  /// Converts between the metric as the problem states it and the one of which less is better.
  double signed_metric(double metric) const { return task_.problem.metric->maximize ? -metric : metric; }
  /// The metric decides which plan is better, not the makespan alone.
  bool by_metric() const { return !objective_.is_makespan(); }

  /// Fills in the plan, and how many were refused.
  void report(PlanAnswer& answer) &&;

 private:
  bool offer(TimedPlan plan, Micros makespan);

  const Task& task_;
  const GroundTask& ground_;
  const Touches& touches_;
  const Objective& objective_;
  Budget& budget_;
  const decltype(PlanOptions::on_plan)& on_plan_;
  const Clock::time_point began_;
  Meter meter_;  ///< of the validator
  const Validator validator_;
  std::optional<TimedPlan> plan_;
  double value_ = std::numeric_limits<double>::infinity();
  Micros makespan_ = DurationRange::kForever;
  double first_plan_s_ = 0;
  int refused_ = 0;
  std::string refusal_;
};

}  // namespace cxlab::planner
