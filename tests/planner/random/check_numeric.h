#pragma once
// Plans random temporal-numeric problems and compares with what trying all small plans finds.

#include <gtest/gtest.h>

#include <chrono>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"
#include "tests/planner/random/numeric_problem.h"
#include "tests/planner/random/wide_problem.h"

namespace cxlab::planner {

struct NumericTally {
  int plans = 0, unsolvable = 0, ended = 0, out_of_budget = 0;
  int witnessed = 0;            ///< the oracle found a plan
  int missed = 0;               ///< of those, the planner found none
  int exhausted = 0;            ///< neither found a plan, and the oracle has tried everything
  std::int64_t most_units = 0;  ///< for a plan
};

inline std::string plan_text(const std::vector<WitnessStep>& plan) { return to_text(plan); }
inline std::string plan_text(const std::string& plan) { return plan; }

/// `Problem` is NumericProblem or WideProblem.
template <class Problem>
NumericTally check_numeric(std::uint64_t seed, int count, std::int64_t budget) {
  NumericTally tally;
  for (int i = 0; i < count; ++i) {
    RandomStream random(seed + static_cast<std::uint64_t>(i), "random temporal-numeric problems");
    const Problem problem = Problem::draw(random);
    SCOPED_TRACE("seed " + std::to_string(seed + static_cast<std::uint64_t>(i)) + "\n" + problem.domain() +
                 problem.problem());
    Expected<Domain> domain = parse_domain(problem.domain(), "domain");
    if (!domain) {
      ADD_FAILURE() << domain.error().text();
      return tally;
    }
    Expected<planner::Problem> parsed = parse_problem(problem.problem(), "problem", *domain);
    if (!parsed) {
      ADD_FAILURE() << parsed.error().text();
      return tally;
    }
    const Task task{*std::move(domain), *std::move(parsed)};
    const Validator validator(task.domain, task.problem);
    const Expected<PlanAnswer> answer = find_plan(task, {.budget = budget});
    if (!answer) {
      ADD_FAILURE() << answer.error().text();
      return tally;
    }
    EXPECT_EQ(answer->refused, 0) << answer->refusal;
    if (answer->plan) {
      ++tally.plans;
      tally.most_units = std::max(tally.most_units, answer->units);
      const Expected<Verdict> verdict = validator.check(answer->plan->steps);
      EXPECT_TRUE(verdict && verdict->valid) << to_text(answer->plan->steps, task.domain, task.problem);
      EXPECT_GE(answer->plan->makespan_s, answer->lower_bound_s - 1e-6);
      continue;
    }
    tally.unsolvable += answer->status == PlanStatus::kUnsolvable;
    tally.ended += answer->status == PlanStatus::kEnded;
    tally.out_of_budget += answer->status == PlanStatus::kBudget;
    const auto witness = find_witness(problem);
    tally.exhausted += !witness.plan && !witness.too_large;
    if (!witness.plan) continue;
    const std::string text = plan_text(*witness.plan);
    const auto plan = parse_plan(text, "witness", task.domain, task.problem);
    const Expected<Verdict> verdict = plan ? validator.check(*plan) : Expected<Verdict>(plan.error());
    EXPECT_TRUE(verdict && verdict->valid)
        << text << (verdict && verdict->violation ? verdict->violation->message : "");
    if (!verdict || !verdict->valid) continue;
    ++tally.witnessed;
    EXPECT_NE(answer->status, PlanStatus::kUnsolvable) << answer->reason << "\n" << text;
    ++tally.missed;
    ADD_FAILURE() << "missed, " << answer->reason << " (" << answer->units << " units):\n" << text;
  }
  return tally;
}

}  // namespace cxlab::planner
