#pragma once
// What no plan can be better than: a lower bound that is raised in ever longer slices of the budget.

#include "planner/strategies/incumbent.h"

namespace cxlab::planner {

class BestPossible {
 public:
  BestPossible(const GroundTask& ground, const Objective& objective, Budget& budget)
      : ground_(ground), objective_(objective), budget_(budget) {}

  /// Computes the bound again, for longer than the last time.
  void raise();
  /// Whether some bound of the makespan would prove that no plan has a better metric.
  bool may_prove(const Incumbent& best) const { return proves(best, objective_.bound(best.makespan())); }
  /// The first slice is as long as what was spent so far, within limits; for callers who want no better plan.
  void keep_first_slice_short();
  /// Whether so much has been spent elsewhere that it is the bound's turn.
  bool is_due() const;
  /// Whether no plan is better than this one by more than what separates happenings.
  bool proves(const Incumbent& best) const;

  /// No plan is shorter.
  Micros makespan() const { return makespan_; }
  /// The bound leaves out plans in which two actions change the same fact at the same instant.
  bool assumes_order() const { return assumes_order_; }
  /// Fills in the bounds.
  void report(const Incumbent& best, PlanAnswer& answer) const;

 private:
  /// Whether a plan of this metric is the best if none is shorter than `makespan`.
  bool proves(const Incumbent& best, std::optional<double> cost) const;

  static constexpr std::int64_t kFirstSlice = 30'000;

  const GroundTask& ground_;
  const Objective& objective_;
  Budget& budget_;
  Micros makespan_ = 0;
  bool assumes_order_ = false;
  std::optional<double> cost_;  ///< of the metric with the sign that makes less better
  std::int64_t slice_ = kFirstSlice;
};

}  // namespace cxlab::planner
