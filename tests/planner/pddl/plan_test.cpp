#include "planner/pddl/plan.h"

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"

namespace cxlab::planner::plan_test {
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

/// What planners print on a day at work, cut down: each holds one jump and one step to the hall, at the times given.
struct Printed {
  const char* planner;
  const char* text;
  const char* plan;
};
constexpr const char* kTimedPlan = "0.000: (jump r1)\n1.001: (go r1 hall) [5.000]\n";
constexpr Printed kPrinted[] = {
    {"POPF", R"(Number of literals: 4
Constructing lookup tables: [10%] [100%]
b (2.000 | 5.000)b (1.000 | 5.001);;;; Solution Found
; States evaluated: 3
; Cost: 6.001
; Time 0.00
0.000: (jump r1)  [0.001]
1.001: (go r1 hall)  [5.000]

 * All goal deadlines now no later than 6.001
)",
     kTimedPlan},
    {"OPTIC, with a better plan behind the first", R"(Initial heuristic = 2.000
; Plan found with metric 9.000
; States evaluated so far: 3
; Time 0.02
0.000: (go r1 hall)  [5.000]
4.000: (jump r1)  [0.001]

Resorting to best-first search
;;;; Solution Found
; States evaluated: 9
; Cost: 6.001
0.000: (jump r1)  [0.001]
1.001: (go r1 hall)  [5.000]
)",
     kTimedPlan},
    {"LPG", R"(NUMERIC_THREATS_MODE: 0
; Command line: lpg -o d -f p -n 1
Plan computed:
   Time: (ACTION) [action Duration; action Cost]
 0.0000: (JUMP R1) [D:0.0000; C:1.0000]
 1.0010: (GO R1 HALL) [D:5.0000; C:1.0000]

Solution number: 1
Total time:      0.03
Actions:         2
)",
     kTimedPlan},
    {"TFD", R"(Found new plan:
0.00000000: (jump r1) [0.00000000]
1.00100000: (go r1 hall) [5.00000000]
Plan length: 2 step(s).
Makespan   : 6.001
)",
     kTimedPlan},
    {"ENHSP", R"(Domain parsed
Problem Solved

Found Plan:
0.0: (jump r1)
1.0: (jump r1)

Plan-Length:2
Metric (Search):2.0
)",
     "0.000: (jump r1)\n1.000: (jump r1)\n"},
    {"FF", R"(
ff: parsing domain file
domain 'D' defined
 ... done.

ff: found legal plan as follows

step    0: JUMP R1
        1: JUMP R1
        2: REACH-GOAL

time spent:    0.00 seconds instantiating 2 easy, 0 hard action templates
)",
     "0.000: (jump r1)\n1.000: (jump r1)\n"},
    {"Fast Downward", R"([t=0.001s, 9904 KB] Solution found!
[t=0.001s, 9904 KB] Actual search time: 0.001s
jump r1 (1)
jump r1 (1)
[t=0.001s, 9904 KB] Plan length: 2 step(s).
[t=0.001s, 9904 KB] Plan cost: 2
)",
     "0.000: (jump r1)\n1.000: (jump r1)\n"},
    {"sas_plan", "(jump r1 )\n(jump r1 )\n; cost = 2 (unit cost)\n", "0.000: (jump r1)\n1.000: (jump r1)\n"},
    {"UPF, sequential", "SequentialPlan:\n    jump(r1)\n    jump(r1)\n", "0.000: (jump r1)\n1.000: (jump r1)\n"},
    {"UPF, timed", "TimeTriggeredPlan:\n    0.0: jump(r1)\n    1.001: go(r1, hall) [5.0]\n", kTimedPlan},
    {"UPF's writer", "0.0: (jump r1)\n1.001: (go r1 hall)[5.0]\n", kTimedPlan},
};

TEST_F(PlanFormat, WhatOtherPlannersPrintIsRead) {
  for (const Printed& printed : kPrinted) {
    const auto plan = parse_plan(printed.text, "plan", domain_, problem_);
    ASSERT_TRUE(plan) << printed.planner << ": " << plan.error().text();
    EXPECT_EQ(to_text(*plan, domain_, problem_), printed.plan) << printed.planner;
  }
}

TEST_F(PlanFormat, StepsOfOtherPlannersAreChecked) {
  EXPECT_EQ(error_of("ff: found legal plan as follows\n\nstep    0: JMP R1\n"),
            "plan:3: found 'jmp', expected an action of d.pddl; did you mean 'jump'?");
  EXPECT_EQ(error_of(";;;; Solution Found\n; Cost: 1\n0.000: (jump r1)\n1: (jump\n"),
            "plan:4: found '1: (jump', expected TIME: (ACTION OBJECT...) [DURATION]");
  EXPECT_EQ(error_of("TimeTriggeredPlan:\n  0.0: go(r1, hall)\n"),
            "plan:2: found no duration of the durative action go, expected TIME: (ACTION OBJECT...) [DURATION]");
}

TEST_F(PlanFormat, APlannerThatFoundTheEmptyPlanFoundAPlan) {
  const auto plan = parse_plan(";;;; Solution Found\n; Cost: 0.000\n; Time 0.00\n", "plan", domain_, problem_);
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->empty());
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
}  // namespace cxlab::planner::plan_test
