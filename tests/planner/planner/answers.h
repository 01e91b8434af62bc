#pragma once
// Small problems from text, and the planner's answer to them.

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

inline Task parse(const std::string& domain_body, const std::string& problem_body) {
  Expected<Domain> domain = parse_domain(
      "(define (domain d) (:requirements :adl :durative-actions :fluents :timed-initial-literals :derived-predicates "
      ":continuous-effects :duration-inequalities)\n" +
          domain_body + ")",
      "domain.pddl");
  EXPECT_TRUE(domain) << domain.error().text();
  Expected<Problem> problem =
      parse_problem("(define (problem p) (:domain d)\n" + problem_body + ")", "problem.pddl", *domain);
  EXPECT_TRUE(problem) << problem.error().text();
  return {std::move(*domain), std::move(*problem)};
}

/// The answer; the validator has judged its plan again.
inline PlanAnswer answer(const Task& task, PlanOptions options = {.budget = 2'000'000}) {
  Expected<PlanAnswer> found = find_plan(task, options);
  EXPECT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->refused, 0) << found->refusal;
  if (found->plan) {
    const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(found->plan->steps);
    EXPECT_TRUE(verdict && verdict->valid) << to_text(found->plan->steps, task.domain, task.problem);
  }
  return std::move(*found);
}

}  // namespace cxlab::planner
