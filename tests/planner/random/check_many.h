#pragma once
// Plans many random problems and compares with the validator and the oracle.

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"
#include "tests/planner/random/timed_oracle.h"

namespace cxlab::planner {

struct Tally {
  int plans = 0, unsolvable = 0, ended = 0, missed = 0;
};

inline Tally check_many(std::uint64_t seed, int count) {
  RandomStream random(seed, "random temporal problems");
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const RandomProblem problem = RandomProblem::draw(random);
    SCOPED_TRACE(problem.domain() + problem.problem());
    Expected<Domain> domain = parse_domain(problem.domain(), "domain");
    if (!domain) {
      ADD_FAILURE() << domain.error().text();
      return tally;
    }
    Expected<Problem> parsed = parse_problem(problem.problem(), "problem", *domain);
    if (!parsed) {
      ADD_FAILURE() << parsed.error().text();
      return tally;
    }
    const Task task{std::move(*domain), std::move(*parsed)};
    PlanOptions options;
    options.budget = 1'000'000;
    const Expected<PlanAnswer> answer = find_plan(task, options);
    if (!answer) {
      ADD_FAILURE() << answer.error().text();
      return tally;
    }
    EXPECT_EQ(answer->refused, 0) << answer->refusal;
    if (answer->plan) {
      ++tally.plans;
      const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(answer->plan->steps);
      EXPECT_TRUE(verdict && verdict->valid) << to_text(answer->plan->steps, task.domain, task.problem);
      EXPECT_GE(answer->plan->makespan_s, answer->lower_bound_s - 1e-6);
      continue;
    }
    const OracleAnswer oracle = ask_oracle(problem);
    if (answer->status == PlanStatus::kUnsolvable) {
      ++tally.unsolvable;
      EXPECT_NE(oracle, OracleAnswer::kSolvable) << answer->reason;
    } else {
      ++tally.ended;
      tally.missed += oracle == OracleAnswer::kSolvable;
      if (oracle == OracleAnswer::kSolvable && tally.missed <= 3) std::printf("missed (%s):\n%s%s", answer->reason.c_str(), problem.domain().c_str(), problem.problem().c_str());
    }
  }
  return tally;
}

}  // namespace cxlab::planner
