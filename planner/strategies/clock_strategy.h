#pragma once
// Strategy: search along the clock, for problems with actions that cannot be cut: their numbers change all along, or
// their end remembers their beginning.

#include "planner/search/clock.h"
#include "planner/strategies/context.h"

namespace cxlab::planner {

class ClockStrategy {
 public:
  explicit ClockStrategy(PlanningContext& context) : context_(context) {}

  /// Looks for a plan that is better than the best one and offers it. True if it found one.
  bool run(const Turn& turn);
  /// Nothing is left that `run` could find: also where all actions can be cut.
  bool exhausted() const { return exhausted_; }

 private:
  bool is_needed() const;

  PlanningContext& context_;
  std::unique_ptr<ClockSearch> search_;
  bool exhausted_ = false;
};

}  // namespace cxlab::planner
