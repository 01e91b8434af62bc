#include "planner/pddl/plan.h"

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"

namespace cxlab::planner {
namespace {

constexpr const char* kDomain =
    "(define (domain d) (:types robot place)\n(:predicates (at ?r - robot ?p - place))\n"
    "(:durative-action go :parameters (?r - robot ?p - place) :duration (= ?duration 5) :effect (at end (at ?r ?p)))\n"
    "(:action jump :parameters (?r - robot) :effect (and)))";

class PlanFormat : public ::testing::Test {
 protected:
  Domain domain_ = *parse_domain(kDomain, "d.pddl");
  Problem problem_ =
      *parse_problem("(define (problem p) (:domain d) (:objects r1 - robot hall - place))", "p.pddl", domain_);

  std::string error_of(const std::string& text) {
    const auto plan = parse_plan(text, "plan", domain_, problem_);
    return plan ? "no error" : plan.error().text();
  }
};

TEST_F(PlanFormat, IsReadAndWritten) {
  const auto plan =
      parse_plan("; a comment\n\n5.5: (JUMP r1)\n0.000: (go R1 hall) [5.000] ; first\n1:(go r1 hall)[D:5.0; C:0.1]\n",
                 "plan", domain_, problem_);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_EQ(to_text(*plan, domain_, problem_),
            "0.000: (go r1 hall) [5.000]\n1.000: (go r1 hall) [5.000]\n5.500: (jump r1)\n");
  EXPECT_EQ(makespan(*plan), 6);
  EXPECT_EQ(plan->at(1).line, 4);
}

TEST_F(PlanFormat, LinesWithoutTimeAreSteps) {
  const auto plan = parse_plan("(jump r1)\n(jump r1)\n", "plan", domain_, problem_);
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_EQ(plan->at(1).start, 1);
}

TEST_F(PlanFormat, ErrorsNameLineAndDeclaration) {
  EXPECT_EQ(error_of("\n0: (jmp r1)"), "plan:2: found 'jmp', expected an action of d.pddl; did you mean 'jump'?");
  EXPECT_EQ(error_of("0: (jump)"), "plan:1: found 0 arguments of jump, expected 1; declared at d.pddl:4");
  EXPECT_EQ(error_of("0: (jump hall)"),
            "plan:1: found 'hall' for argument 1 of jump, expected an object for ?r - robot; declared at d.pddl:4");
  EXPECT_EQ(error_of("0: (jump r2)"), "plan:1: found 'r2', expected an object of p.pddl; did you mean 'r1'?");
  EXPECT_EQ(error_of("0: (go r1 hall)"),
            "plan:1: found no duration of the durative action go, expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("x: (jump r1)"), "plan:1: found 'x:' for the time, expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("10 (jump r1)"), "plan:1: found '10' for the time, expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("nothing"), "plan:1: found 'nothing', expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("0: ()"), "plan:1: found an empty action, expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("0: (go r1 hall) [x]"), "plan:1: found '[x]', expected a duration such as [5.000]");
}

}  // namespace
}  // namespace cxlab::planner
