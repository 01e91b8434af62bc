#pragma once
// Plans in the format of PDDL 2.1: `0.000: (action a b) [5.000]`.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "planner/pddl/model.h"

namespace cxlab::planner {

struct PlanStep {
  double start = 0;  ///< s
  ActionId action = -1;
  std::vector<ObjectId> arguments;
  double duration = 0;  ///< s; 0 for instantaneous actions
  int line = 0;         ///< where it was read; 0 = not from a file
};

/// Steps in any order.
using Plan = ById<PlanStep>;

/// Reads a plan. Accepted beside the format: comments, blank lines, `[D:5.0; C:1.0]` for the duration, no space where
/// none is needed. Lines without a time are steps of a sequential plan, at 0, 1, 2 ... Where the text is all that a
/// planner printed (POPF, OPTIC, FF, LPG, Fast Downward, TFD, ENHSP, the Unified Planning Framework), its last plan is
/// read. Errors: names that are not known, wrong number or type of arguments, a durative action without a duration.
Expected<Plan> parse_plan(std::string_view text, const std::string& file, const Domain& domain, const Problem& problem);

/// One line a step, by start.
std::string to_text(const Plan& plan, const Domain& domain, const Problem& problem);
/// `(action a b)`
std::string step_text(const PlanStep& step, const Domain& domain, const Problem& problem);

/// End of the last step, s; 0 for the empty plan.
double makespan(const Plan& plan);

}  // namespace cxlab::planner
