// The search along the clock: numbers that change continuously, ends that depend on their beginning, durations that
// decide effects.

#include <gtest/gtest.h>

#include "answers.h"

namespace cxlab::planner::clock_test {
namespace {

TEST(Clock, ADurationIsChosenSoThatTheGoalIsMetExactly) {
  const std::string domain = R"((:functions (level)) (:predicates (idle))
    (:durative-action fill :parameters () :duration (and (>= ?duration 1) (<= ?duration 10)) :condition (at start (idle))
     :effect (and (at start (not (idle))) (at end (idle)) (increase (level) (* #t 2)))))";
  const PlanAnswer exact = answer(parse(domain, "(:init (idle) (= (level) 0)) (:goal (= (level) 7))"));
  ASSERT_TRUE(exact.plan);
  EXPECT_NEAR(exact.plan->makespan_s, 3.5, 1e-6);
  const PlanAnswer band =
      answer(parse(domain, "(:init (idle) (= (level) 0)) (:goal (and (>= (level) 6.9) (<= (level) 7.1)))"));
  ASSERT_TRUE(band.plan);
  EXPECT_NEAR(band.plan->makespan_s, 3.45, 1e-6);
}

TEST(Clock, ADurationIsChosenForAnEffectThatReadsIt) {
  const PlanAnswer found = answer(parse(R"((:functions (charge)) (:predicates (fired))
    (:durative-action load :parameters () :duration (and (>= ?duration 1) (<= ?duration 20)) :condition (at start (= (charge) 0))
     :effect (at end (assign (charge) (* 3 ?duration))))
    (:action fire :parameters () :precondition (>= (charge) 30) :effect (fired)))",
                                        "(:init (= (charge) 0)) (:goal (fired))"),
                                  {.budget = 50'000, .anytime = true});
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 10.001, 0.002);
}

constexpr const char* kOven = R"((:functions (heat)) (:predicates (cold) (burning) (baked))
  (:durative-action burn :parameters () :duration (= ?duration 20) :condition (at start (cold))
   :effect (and (at start (not (cold))) (at start (burning)) (at end (not (burning))) (increase (heat) (* #t 10))))
  (:durative-action bake :parameters () :duration (= ?duration 5) :condition (and (over all (burning)) (over all (>= (heat) 180)) (at end (<= (heat) 230)))
   :effect (at end (baked))))";

TEST(Clock, WaitsUntilANumberIsHighEnough) {
  const PlanAnswer found = answer(parse(kOven, "(:init (cold) (= (heat) 40)) (:goal (baked))"));
  ASSERT_TRUE(found.plan);
  ASSERT_EQ(found.plan->steps.size(), 2u);
  EXPECT_GE(found.plan->steps[1].start, 14.0);
  EXPECT_LE(found.plan->steps[1].start + 5, 19.0 + 1e-6);
}

TEST(Clock, WaitsAMicrosecondMoreWhereANumberMustBeGreater) {
  const auto begin_of = [](const std::string& comparison) {
    const PlanAnswer found = answer(parse(R"((:functions (heat)) (:predicates (cold) (burning) (baked))
      (:durative-action burn :parameters () :duration (= ?duration 20) :condition (at start (cold))
       :effect (and (at start (not (cold))) (at start (burning)) (at end (not (burning))) (increase (heat) (* #t 10))))
      (:durative-action bake :parameters () :duration (= ?duration 5)
       :condition (and (over all (burning)) (at start ()" +
                                              comparison + R"( (heat) 180))) :effect (at end (baked))))",
                                          "(:init (cold) (= (heat) 40)) (:goal (baked))"));
    EXPECT_TRUE(found.plan) << comparison;
    return found.plan ? found.plan->steps.back().start : 0;
  };
  EXPECT_NEAR(begin_of(">="), 14, 1e-9);
  EXPECT_NEAR(begin_of(">"), 14.000001, 1e-9);
}

TEST(Clock, ProvesThatANumberIsReachedTooLate) {
  EXPECT_EQ(answer(parse(kOven, "(:init (cold) (= (heat) 20)) (:goal (baked))")).status, PlanStatus::kUnsolvable);
}

TEST(Clock, AConditionalEffectComesIfItsConditionHeldAllTheTime) {
  const auto status = [](const std::string& until) {
    return answer(parse(R"((:functions (heat)) (:predicates (cold) (open) (dry))
      (:durative-action burn :parameters () :duration (= ?duration 10) :condition (at start (cold))
       :effect (and (at start (not (cold))) (increase (heat) (* #t 1)) (when (over all (open)) (at end (dry))))))",
                        "(:init (cold) (= (heat) 0) (open) (at 0.5 (not (open))) (at 1 (open)) (at " + until +
                            " (not (open)))) (:goal (and (dry) (>= (heat) 10)))"))
        .status;
  };
  EXPECT_EQ(status("12"), PlanStatus::kPlan) << "it begins after 1";
  EXPECT_EQ(status("10.5"), PlanStatus::kUnsolvable) << "it is open for 9.5 s at most";
}

TEST(Clock, AStartThatReadsTheDurationHasTheDurationOfTheEnd) {
  const auto status = [](const std::string& goal) {
    return answer(parse(R"((:functions (paid) (level)) (:predicates (idle))
      (:durative-action fill :parameters () :duration (and (>= ?duration 2) (<= ?duration 9)) :condition (at start (idle))
       :effect (and (at start (not (idle))) (at start (increase (paid) ?duration)) (increase (level) (* #t 1)))))",
                        "(:init (idle) (= (paid) 0) (= (level) 0)) (:goal (and " + goal + "))"))
        .status;
  };
  EXPECT_EQ(status("(= (level) 2) (= (paid) 2)"), PlanStatus::kPlan);
  EXPECT_NE(status("(= (level) 5) (= (paid) 2)"), PlanStatus::kPlan);
}

TEST(Clock, OneFillsWhileAnotherDrains) {
  const PlanAnswer found = answer(parse(R"((:functions (tank)) (:predicates (a) (b) (drained) (filled))
    (:durative-action drain :parameters () :duration (= ?duration 8) :condition (and (at start (a)) (over all (>= (tank) 0)))
     :effect (and (at start (not (a))) (decrease (tank) (* #t 2)) (at end (drained))))
    (:durative-action fill :parameters () :duration (= ?duration 8) :condition (and (at start (b)) (over all (<= (tank) 10)))
     :effect (and (at start (not (b))) (increase (tank) (* #t 2)) (at end (filled)))))",
                                        "(:init (a) (b) (= (tank) 5)) (:goal (and (drained) (filled)))"));
  ASSERT_TRUE(found.plan);
  EXPECT_LE(found.plan->makespan_s, 13.0);
}

TEST(Clock, ADurationIsChosenWhileAnotherActionNeedsIt) {
  const PlanAnswer found = answer(parse(R"((:functions (battery)) (:predicates (ready) (plug) (done))
    (:durative-action work :parameters () :duration (= ?duration 10) :condition (and (at start (ready)) (over all (>= (battery) 0)))
     :effect (and (at start (not (ready))) (at end (done)) (decrease (battery) (* #t 3))))
    (:durative-action charge :parameters () :duration (and (>= ?duration 1) (<= ?duration 20)) :condition (and (at start (plug)) (over all (<= (battery) 22)))
     :effect (and (at start (not (plug))) (at end (plug)) (increase (battery) (* #t 2)))))",
                                        "(:init (ready) (plug) (= (battery) 20)) (:goal (done))"));
  ASSERT_TRUE(found.plan);
}

TEST(Clock, OrderingsOfAPlanWithFixedTimesFixThem) {
  const PlanAnswer found = answer(parse(kOven, "(:init (cold) (= (heat) 40)) (:goal (baked))"));
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(static_cast<double>(found.plan->latest[2]), found.plan->steps[1].start * kMicrosPerSecond, 0.5);
}

TEST(Clock, SameBudgetSamePlan) {
  const Task task = parse(kOven, "(:init (cold) (= (heat) 40)) (:goal (baked))");
  const PlanAnswer once = answer(task, {.budget = 50'000, .anytime = true}),
                   again = answer(task, {.budget = 50'000, .anytime = true});
  ASSERT_TRUE(once.plan && again.plan);
  EXPECT_EQ(to_text(once.plan->steps, task.domain, task.problem),
            to_text(again.plan->steps, task.domain, task.problem));
  EXPECT_EQ(once.units, again.units);
}

}  // namespace
}  // namespace cxlab::planner::clock_test
