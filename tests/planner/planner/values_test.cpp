// Numbers that no validator accepts are not offered: the searches go on to a plan without them.

#include <gtest/gtest.h>

#include "answers.h"

namespace cxlab::planner {
namespace {

/// The names of the steps of the plan.
std::string steps(const std::string& domain, const std::string& problem) {
  const Task task = parse(domain, problem);
  const PlanAnswer found = answer(task);
  if (!found.plan) return found.reason;
  std::string names;
  for (const PlanStep& step : found.plan->steps)
    names += (names.empty() ? "" : " ") + task.domain.actions[static_cast<std::size_t>(step.action)].name;
  return names;
}

TEST(Values, AnActionThatDividesByZeroWaitsForAnotherDivisor) {
  EXPECT_EQ(steps(R"((:predicates (done)) (:functions (x) (y))
    (:action divide :parameters () :effect (and (assign (y) (/ 1 (x))) (done)))
    (:action count :parameters () :effect (increase (x) 1)))",
                  "(:init (= (x) 0) (= (y) 0)) (:goal (done))"),
            "count divide");
}

TEST(Values, AnActionThatMakesANumberTooLargeWaitsForASmallerOne) {
  const char* init = "(:init (= (x) 1e200)) (:goal ";
  EXPECT_EQ(steps(R"((:predicates (done)) (:functions (x))
    (:action square :parameters () :effect (and (assign (x) (* (x) (x))) (done)))
    (:action shrink :parameters () :effect (assign (x) 2)))",
                  init + std::string("(done))")),
            "shrink square");
  EXPECT_EQ(steps(R"((:predicates (done)) (:functions (x))
    (:action grow :parameters () :effect (and (scale-up (x) 1e200) (done)))
    (:action shrink :parameters () :effect (assign (x) 2)))",
                  init + std::string("(and (done) (> (x) 0)))")),
            "shrink grow");
}

TEST(Values, AConditionThatComputesANumberTooLargeDoesNotHold) {
  EXPECT_EQ(steps(R"((:predicates (done)) (:functions (x))
    (:action take :parameters () :precondition (< (/ 1 (* (x) (x))) 0.5) :effect (done))
    (:action shrink :parameters () :effect (assign (x) 2)))",
                  "(:init (= (x) 1e200)) (:goal (done))"),
            "shrink take");
}

TEST(Values, AnActionWhoseRateDividesByZeroIsInNoPlan) {
  const PlanAnswer found = answer(parse(R"((:predicates (done)) (:functions (x) (a) (b))
    (:action up :parameters () :effect (increase (a) 1))
    (:durative-action flow :parameters () :duration (= ?duration 3) :condition ()
     :effect (and (at end (done)) (increase (x) (* #t (/ (a) (b)))))))",
                                        "(:init (= (x) 0) (= (a) 0) (= (b) 0)) "
                                        "(:goal (and (done) (or (>= (x) 0) (< (x) 0))))"),
                                  {.budget = 20'000});
  EXPECT_FALSE(found.plan);
}

TEST(Values, AnActionWhoseOwnEffectLeavesItNoDurationWaitsForAnother) {
  // Lamps burn out; each item needs one that is lit, so beginnings and ends of lighting are steps of their own.
  EXPECT_EQ(steps(R"((:predicates (free) (lit) (fresh)) (:functions (least) (count))
    (:durative-action light :parameters () :duration (and (>= ?duration (least)) (<= ?duration 3)) :condition (at start (free))
     :effect (and (at start (not (free))) (at end (free)) (at start (lit)) (at end (not (lit))) (at start (fresh))
      (at start (assign (least) 5))))
    (:durative-action use :parameters () :duration (= ?duration 2) :condition (and (over all (lit)) (at start (fresh)))
     :effect (and (at start (not (fresh))) (at end (increase (count) 1))))
    (:action reset :parameters () :precondition (free) :effect (assign (least) 1)))",
                  "(:init (free) (= (least) 1) (= (count) 0)) (:goal (>= (count) 2))"),
            "light use reset light use");
}

}  // namespace
}  // namespace cxlab::planner
