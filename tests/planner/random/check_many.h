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

inline std::optional<Task> parse_task(const RandomProblem& problem) {
  Expected<Domain> domain = parse_domain(problem.domain(), "domain");
  if (!domain) {
    ADD_FAILURE() << domain.error().text();
    return std::nullopt;
  }
  Expected<Problem> parsed = parse_problem(problem.problem(), "problem", *domain);
  if (!parsed) {
    ADD_FAILURE() << parsed.error().text();
    return std::nullopt;
  }
  return Task{std::move(*domain), std::move(*parsed)};
}

inline Tally check_many(std::uint64_t seed, int count) {
  RandomStream random(seed, "random temporal problems");
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const RandomProblem problem = RandomProblem::draw(random);
    SCOPED_TRACE(problem.domain() + problem.problem());
    const std::optional<Task> parsed = parse_task(problem);
    if (!parsed) return tally;
    const Task& task = *parsed;
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
      if (oracle == OracleAnswer::kSolvable && tally.missed <= 3)
        std::printf("missed (%s):\n%s%s", answer->reason.c_str(), problem.domain().c_str(), problem.problem().c_str());
    }
  }
  return tally;
}

/// Plans that were found by the metric, beside the best that exist.
struct MetricTally {
  int compared = 0;      ///< both have a plan
  int worse = 0;         ///< the planner's is not as good as the best within the horizon
  int not_shortest = 0;  ///< the best is not the one that would be found without a metric
  int bounded = 0;
};

inline MetricTally check_metrics(std::uint64_t seed, int count, std::int64_t budget) {
  RandomStream random(seed, "random problems with metrics");
  MetricTally tally;
  for (int i = 0; i < count; ++i) {
    RandomProblem problem = RandomProblem::draw_with_metric(random);
    SCOPED_TRACE(problem.domain() + problem.problem());
    const std::optional<int> best =
        ask_oracle_for_metric(problem, {.seconds = 7, .instants = 4, .most_situations = 20'000});
    const std::optional<Task> task = parse_task(problem);
    if (!best || !task) continue;
    const Expected<PlanAnswer> answer = find_plan(*task, {.budget = budget, .anytime = true});
    if (!answer || !answer->plan) continue;
    EXPECT_EQ(answer->refused, 0) << answer->refusal;
    const Expected<Verdict> verdict = Validator(task->domain, task->problem).check(answer->plan->steps);
    EXPECT_TRUE(verdict && verdict->valid && answer->plan->metric && verdict->metric == answer->plan->metric);
    ++tally.compared;
    const double separations = 0.05 * problem.time_weight;  // the oracle counts whole seconds
    if (*answer->plan->metric > *best + separations + 1e-6) {
      if (++tally.worse <= 3)
        std::printf("metric %g, the best is %d:\n%s%s", *answer->plan->metric, *best, problem.domain().c_str(),
                    problem.problem().c_str());
    }
    if (answer->metric_bound) {
      ++tally.bounded;
      EXPECT_LE(*answer->metric_bound, *best + 1e-6);
      EXPECT_LE(*answer->metric_bound, *answer->plan->metric + 1e-6);
    }
    problem.time_weight = 1;
    problem.count_weight = 0;
    const std::optional<Task> shortest = parse_task(problem);
    const Expected<PlanAnswer> quick = find_plan(*shortest, {.budget = budget, .anytime = true});
    if (quick && quick->plan &&
        to_text(quick->plan->steps, shortest->domain, shortest->problem) !=
            to_text(answer->plan->steps, task->domain, task->problem))
      ++tally.not_shortest;
  }
  return tally;
}

}  // namespace cxlab::planner
