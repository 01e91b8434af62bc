#pragma once
// The remaining steps of a plan under execution, judged by the state alone: the caller need not know how far the plan
// has come.

#include <span>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/pddl/plan.h"
#include "planner/search/lazy_search.h"

namespace cxlab::planner {

/// For problems without events: steps are done one after the other, whatever their times.
class Remainder {
 public:
  struct Done {
    Sequence steps;
    PackedState state;  ///< after them
    int left_out = 0;   ///< steps that could not be done
    int score() const { return static_cast<int>(steps.size()) - left_out; }
  };

  Remainder(const Simulator& simulator, Budget& budget) : simulator_(simulator), budget_(budget) {}

  /// The shortest final part of the plan that leads to the goal. If none does, the part of which most can be done.
  Done of(const Plan& plan);
  /// Leaves out steps without which the others lead to the goal, with what cannot be done without them.
  Sequence without_needless(Sequence steps);
  bool is_goal(const Done& done) const { return simulator_.is_goal(done.state.data()); }

 private:
  using OneOf = std::vector<int>;  ///< ground actions, each a way to do the same step

  std::vector<OneOf> ways_of(const Plan& plan);
  /// Does one step after the other; those that cannot be done are left out.
  Done do_in_order(std::span<const OneOf> steps, PackedState from);

  const Simulator& simulator_;
  Budget& budget_;
};

}  // namespace cxlab::planner
