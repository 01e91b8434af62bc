#pragma once
// An oracle that tries everything to see whether a random problem has a plan; its simulation shares nothing with the
// planner.
//
// Time is counted in whole seconds and, within a second, in instants that are one epsilon apart. At every instant any
// set of actions may start; what is due ends, and events happen. All reachable situations up to a horizon are visited.

#include <optional>

#include "tests/planner/random/random_problem.h"

namespace cxlab::planner {

enum class OracleAnswer { kSolvable, kNoPlanInHorizon, kTooLarge };

struct OracleLimits {
  int seconds = 9;
  int instants = 4;  ///< of a second
  std::size_t most_situations = 200'000;
  bool may_coincide = true;  ///< two happenings of one instant may change the same fact in the same way
};

OracleAnswer ask_oracle(const RandomProblem& problem, const OracleLimits& limits = {});

/// The least metric of all plans within the horizon, with time in whole seconds; none if there is no plan or too much
/// to visit.
std::optional<int> ask_oracle_for_metric(const RandomProblem& problem, const OracleLimits& limits = {});

/// Whole seconds of the shortest plan; what separates its happenings is taken for nothing as long as it is under a
/// second in all. None if there is no plan in the horizon or too much to visit.
std::optional<int> shortest_plan_s(const RandomProblem& problem, const OracleLimits& limits = {});

}  // namespace cxlab::planner
