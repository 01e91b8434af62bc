#pragma once
// A domain, a problem and plans as text, for tests of the validator.

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "planner/pddl/parser.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

class Checker {
 public:
  Checker(const std::string& domain, const std::string& problem) {
    auto parsed_domain = parse_domain("(define (domain d)" + domain + ")", "d.pddl");
    EXPECT_TRUE(parsed_domain) << parsed_domain.error().text();
    task_.domain = *parsed_domain;
    auto parsed_problem = parse_problem("(define (problem p) (:domain d)" + problem + ")", "p.pddl", task_.domain);
    EXPECT_TRUE(parsed_problem) << parsed_problem.error().text();
    task_.problem = *parsed_problem;
  }

  Expected<Verdict> check(const std::string& text, ValidateOptions options = {}) const {
    auto plan = parse_plan(text, "plan", task_.domain, task_.problem);
    EXPECT_TRUE(plan) << plan.error().text();
    if (!plan) return plan.error();
    return Validator(task_.domain, task_.problem).check(*plan, options);
  }

  /// "valid", or the message and advice of the first violation.
  std::string verdict(const std::string& text, ValidateOptions options = {}) const {
    const auto verdict = check(text, options);
    if (!verdict) return verdict.error().text();
    return verdict->valid ? "valid" : to_text(*verdict->violation);
  }

  const Task& task() const { return task_; }

 private:
  Task task_;
};

}  // namespace cxlab::planner
