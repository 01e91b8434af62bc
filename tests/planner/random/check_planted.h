#pragma once
// Plans problems that have a plan, which the validator accepts: none may be called unsolvable.

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"
#include "tests/planner/random/constants.h"

namespace cxlab::planner {

struct PlantedTally {
  int accepted = 0;  ///< of the plans that were planted; the validator counts in its own way, so that some are not
  int solved = 0;    ///< of the problems with an accepted plan
};

inline PlantedTally check_planted(std::uint64_t seed, int count, std::int64_t budget) {
  RandomStream random(seed, "random problems with tiny and huge constants");
  PlantedTally tally;
  for (int i = 0; i < count; ++i) {
    const PlantedProblem drawn = PlantedProblem::draw(random);
    SCOPED_TRACE(drawn.domain + drawn.problem + drawn.plan);
    Expected<Domain> domain = parse_domain(drawn.domain, "domain");
    if (!domain) {
      ADD_FAILURE() << domain.error().text();
      return tally;
    }
    Expected<Problem> problem = parse_problem(drawn.problem, "problem", *domain);
    if (!problem) {
      ADD_FAILURE() << problem.error().text();
      return tally;
    }
    const Task task{*std::move(domain), *std::move(problem)};
    const auto planted = parse_plan(drawn.plan, "plan", task.domain, task.problem);
    if (!planted) {
      ADD_FAILURE() << planted.error().text();
      return tally;
    }
    const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(*planted);
    if (!verdict || !verdict->valid) continue;
    ++tally.accepted;
    PlanOptions options;
    options.budget = budget;
    const Expected<PlanAnswer> answer = find_plan(task, options);
    if (!answer) {
      ADD_FAILURE() << answer.error().text();
      return tally;
    }
    EXPECT_NE(answer->status, PlanStatus::kUnsolvable) << answer->reason;
    if (!answer->plan) continue;
    ++tally.solved;
    const Expected<Verdict> own = Validator(task.domain, task.problem).check(answer->plan->steps);
    EXPECT_TRUE(own && own->valid) << to_text(answer->plan->steps, task.domain, task.problem);
    EXPECT_GE(answer->plan->makespan_s, answer->lower_bound_s - 1e-6);
  }
  return tally;
}

}  // namespace cxlab::planner
