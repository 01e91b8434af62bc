#include <gmock/gmock.h>

#include "checker.h"

namespace cxlab::planner::numbers_test {
namespace {

using ::testing::HasSubstr;

std::string objects(int count) {
  std::string names;
  for (int i = 0; i < count; ++i) names += " o" + std::to_string(i);
  return names;
}

const char* kBattery =
    R"((:types robot) (:predicates (rested ?r - robot)) (:functions (battery ?r - robot) (work-time) (spent))
  (:durative-action work :parameters (?r - robot) :duration (= ?duration (work-time))
    :condition (and (at start (>= (battery ?r) (* 2 ?duration))) (over all (> (battery ?r) 0)))
    :effect (and (at end (decrease (battery ?r) (* 2 ?duration))) (at end (increase (spent) 1))))
  (:action charge :parameters (?r - robot) :effect (assign (battery ?r) 10))
  (:action dive :parameters (?r - robot) :effect (scale-down (battery ?r) 2))
  (:action burn :effect (increase (work-time) (spent))))";
const char* kStart =
    R"((:objects r q - robot) (:init (= (battery r) 6) (= (work-time) 2) (= (spent) 0)) (:goal (>= (spent) 1))
  (:metric minimize (+ (total-time) (* 10 (spent)))))";

TEST(ValidatorNumbers, ConditionsEffectsAndMetric) {
  const auto verdict = Checker(kBattery, kStart).check("1: (work r) [2]");
  ASSERT_TRUE(verdict);
  ASSERT_TRUE(verdict->valid) << to_text(*verdict->violation);
  EXPECT_EQ(verdict->metric, 13);
}

TEST(ValidatorNumbers, AFailingComparisonNamesBothSidesAndTheActionsThatChangeThem) {
  EXPECT_EQ(Checker(kBattery, kStart).verdict("0: (work r) [2]\n3: (work r) [2]"),
            "3.000: (work r) (line 2): a condition at start does not hold at 3.000: (>= (battery r) (* 2 ?duration)); "
            "its sides are 2 and 4\n"
            "  advice: the numbers are changed by work, charge, dive: move or add such a step");
  EXPECT_EQ(Checker(kBattery, kStart).verdict("0: (work r) [2]\n2.5: (charge r)\n3: (work r) [2]"), "valid");
}

TEST(ValidatorNumbers, ReadingAnUndefinedValueIsAViolation) {
  EXPECT_THAT(Checker(kBattery, kStart).verdict("0: (work q) [2]"), HasSubstr("its sides are without value and 4"));
  EXPECT_THAT(Checker(kBattery, kStart).verdict("0: (dive q)"),
              HasSubstr("the effect (scale-down (battery q) 2) at 0.000 has no value: it reads or changes a number "
                        "that is undefined"));
}

TEST(ValidatorNumbers, DurationIsReadInTheStateAtStart) {
  EXPECT_EQ(Checker(kBattery, kStart).verdict("0: (work r) [2]\n2.1: (burn)\n3: (charge r)\n4: (work r) [3]"), "valid");
  EXPECT_THAT(Checker(kBattery, kStart).verdict("0: (work r) [2]\n2.1: (burn)\n3: (charge r)\n4: (work r) [2]"),
              HasSubstr("the duration is 2.000, expected 3.000"));
}

TEST(ValidatorNumbers, ANumberThatGrowsBeyondAllNumbersHasNoValue) {
  const Checker checker("(:functions (x)) (:action square :effect (scale-up (x) (x)))",
                        "(:init (= (x) 10)) (:goal (> (x) 20))");
  std::string plan;
  for (int i = 1; i <= 8; ++i) plan += std::to_string(i) + ": (square)\n";
  EXPECT_EQ(checker.verdict(plan), "valid") << "1e256";
  EXPECT_THAT(checker.verdict(plan + "9: (square)"), HasSubstr("the effect (scale-up (x) (x)) at 9.000 has no value"));
}

TEST(ValidatorNumbers, TheMetricCountsTheTimeOfThePlanNotOfLaterEvents) {
  const Checker checker("(:predicates (lit) (day)) (:action light :effect (lit))",
                        "(:init (at 9 (day))) (:goal (lit)) (:metric minimize (total-time))");
  const auto verdict = checker.check("2: (light)");
  ASSERT_TRUE(verdict && verdict->valid);
  EXPECT_EQ(verdict->metric, 2);
}

TEST(ValidatorNumbers, IncreasesCommuteAssignmentsDoNot) {
  const char* world = R"((:functions (x)) (:action up :effect (increase (x) 2)) (:action down :effect (decrease (x) 1))
    (:action set :effect (assign (x) 7)))";
  const Checker checker(world, "(:init (= (x) 0)) (:goal (= (x) 1))");
  EXPECT_EQ(checker.verdict("1: (up)\n1: (down)"), "valid");
  EXPECT_THAT(checker.verdict("1: (up)\n1: (set)"), HasSubstr("both use (x)"));
  EXPECT_THAT(checker.verdict("1: (set)\n1: (set)"), HasSubstr("both use (x)"));
}

const char* kTank = R"((:predicates (full) (checked)) (:functions (level) (flow) (other))
  (:durative-action fill :parameters () :duration (<= ?duration 10) :effect (and (increase (level) (* #t (flow))) (at end (full))))
  (:durative-action drain :parameters () :duration (<= ?duration 10) :condition (over all (>= (level) 1)) :effect (decrease (level) (* #t 1)))
  (:durative-action guard :parameters () :duration (= ?duration 4) :condition (over all (<= (level) 6)) :effect (at end (checked)))
  (:durative-action area :parameters () :duration (= ?duration 4) :condition (over all (<= (* (level) (other)) 4)) :effect (at end (checked)))
  (:durative-action swap :parameters () :duration (= ?duration 4) :effect (and (increase (level) #t) (decrease (other) #t)))
  (:action faster :effect (increase (flow) 1)))";

TEST(ValidatorContinuous, LinearChangeIsFollowedThroughHappenings) {
  const Checker checker(kTank, "(:init (= (level) 0) (= (flow) 1) (= (other) 0)) (:goal (= (level) 12))");
  EXPECT_EQ(checker.verdict("0: (fill) [10]\n8: (faster)"), "valid") << "8 at rate 1, then 2 at rate 2";
  EXPECT_EQ(checker.verdict("0: (fill) [10]\n6: (faster)\n8: (drain) [2]"), "valid") << "6 + 2 * 2 + 2 * (2 - 1)";
  EXPECT_THAT(checker.verdict("0: (fill) [10]\n7: (faster)"), HasSubstr("(= (level) 12); its sides are 13 and 12"));
}

TEST(ValidatorContinuous, OverAllIsCheckedAtTheCrossing) {
  const Checker checker(kTank, "(:init (= (level) 3) (= (flow) 1) (= (other) 0)) (:goal (checked))");
  EXPECT_EQ(
      checker.verdict("0: (fill) [4]\n0: (guard) [4]"),
      "0.000: (guard) (line 2): a condition over all does not hold at 3.500: (<= (level) 6); its sides are 6.5 and 6\n"
      "  advice: the numbers are changed by fill, drain, swap: move or add such a step");
  EXPECT_EQ(checker.verdict("0: (fill) [3]\n0: (guard) [4]"), "valid") << "6 is reached, not passed";
  const Checker low(kTank, "(:init (= (level) 3) (= (flow) 1) (= (other) 0)) (:goal (and))");
  EXPECT_EQ(low.verdict("0: (drain) [2]"), "valid");
  EXPECT_THAT(low.verdict("0: (drain) [2.1]"), HasSubstr("does not hold at 2.050"));
}

TEST(ValidatorContinuous, ProductOfTwoChangingNumbersIsCheckedBetweenItsRoots) {
  // level = t, other = 4 - t: the product has its maximum 4 at t = 2.
  const Checker touches(kTank, "(:init (= (level) 0) (= (flow) 1) (= (other) 4)) (:goal (checked))");
  EXPECT_EQ(touches.verdict("0: (swap) [4]\n0: (area) [4]"), "valid");
  const Checker passes(kTank, "(:init (= (level) 0) (= (flow) 1) (= (other) 4.01)) (:goal (checked))");
  EXPECT_THAT(passes.verdict("0: (swap) [4]\n0: (area) [4]"), HasSubstr("a condition over all does not hold at 2.005"))
      << "above 4 only around t = 2";
}

TEST(ValidatorContinuous, AnEffectThatIsDroppedInTheMiddleLeavesTheNumbersOfTheEnd) {
  const Checker checker(R"((:predicates (low)) (:functions (level))
    (:durative-action fill :parameters () :duration (= ?duration 4) :condition (at end (<= (level) 4))
      :effect (and (increase (level) (* #t 1)) (when (over all (< (level) 1)) (at end (low))))))",
                        "(:init (= (level) 0)) (:goal (and (= (level) 4) (not (low))))");
  EXPECT_EQ(checker.verdict("0: (fill) [4]"), "valid");
}

TEST(ValidatorContinuous, TimedValuesInterfereWithConditions) {
  const char* world =
      R"((:predicates (done)) (:functions (price)) (:action buy :precondition (<= (price) 5) :effect (done)))";
  const Checker checker(world, "(:init (= (price) 9) (at 4 (= (price) 3)) (at 8 (= (price) 9))) (:goal (done))");
  EXPECT_EQ(checker.verdict("5: (buy)"), "valid");
  EXPECT_THAT(checker.verdict("3: (buy)"), HasSubstr("its sides are 9 and 5"));
  EXPECT_THAT(checker.verdict("8: (buy)"), HasSubstr("the initial state's event at 8.000"));
}

TEST(ValidatorContinuous, ManyPiecesAddUpExactly) {
  const Checker checker(R"((:predicates (done)) (:functions (level))
    (:durative-action drain :parameters () :duration (= ?duration 1) :condition (over all (>= (level) 0))
      :effect (decrease (level) (* #t 0.1)))
    (:action look :precondition (= (level) 0) :effect (done)))",
                        "(:init (= (level) 1)) (:goal (done))");
  std::string plan;
  for (int i = 0; i < 10; ++i) plan += std::to_string(i) + ".0" + std::to_string(i) + ": (drain) [1]\n";
  EXPECT_EQ(checker.verdict(plan + "11: (look)"), "valid") << "ten tenths of 1";
}

TEST(ValidatorContinuous, AConditionThatNothingChangesIsExactBesideOthersThatChange) {
  const char* world = R"((:predicates (done)) (:functions (level) (now) (due))
    (:durative-action fill :parameters () :duration (= ?duration 4) :effect (increase (level) (* #t 1)))
    (:durative-action work :parameters () :duration (= ?duration 4)
      :condition (over all (and (< (now) (due)) (or (<= (level) 2) (< (now) (due))))) :effect (at end (done))))";
  const Checker open(world, "(:init (= (level) 0) (= (now) 1700000000) (= (due) 1700000001)) (:goal (done))");
  EXPECT_EQ(open.verdict("0: (fill) [4]\n0: (work) [4]"), "valid");
  const Checker shut(world, "(:init (= (level) 0) (= (now) 1700000001) (= (due) 1700000001)) (:goal (done))");
  EXPECT_THAT(shut.verdict("0: (fill) [4]\n0: (work) [4]"), HasSubstr("a condition over all does not hold"));
}

TEST(ValidatorContinuous, SumsThatNothingChangesAreThoseOfDecimalNumbersBesideOthersThatChange) {
  const auto checker = [](const char* sum) {
    return Checker(R"((:predicates (done)) (:functions (level) (a) (b) (c))
    (:durative-action fill :parameters () :duration (= ?duration 4) :effect (increase (level) (* #t 1)))
    (:durative-action work :parameters () :duration (= ?duration 4)
      :condition (over all (and (= (+ (a) (b)) (c)) (<= (level) 9))) :effect (at end (done))))",
                   "(:init (= (level) 0) (= (a) 0.1) (= (b) 0.2) (= (c) " + std::string(sum) + ")) (:goal (done))");
  };
  EXPECT_EQ(checker("0.3").verdict("0: (fill) [4]\n0: (work) [4]"), "valid");
  EXPECT_THAT(checker("0.3000001").verdict("0: (fill) [4]\n0: (work) [4]"),
              HasSubstr("a condition over all does not hold"));
}

TEST(ValidatorContinuous, LargeNumbersCrossWhereTheyCross) {
  const char* world = R"((:predicates (done)) (:functions (clock) (due))
    (:durative-action tick :parameters () :duration (= ?duration 4) :effect (increase (clock) (* #t 1)))
    (:durative-action work :parameters () :duration (= ?duration 2) :condition (over all (< (clock) (due)))
      :effect (at end (done))))";
  const auto verdict = [&](const std::string& due) {
    return Checker(world, "(:init (= (clock) 1700000000) (= (due) " + due + ")) (:goal (done))")
        .verdict("0: (tick) [4]\n0: (work) [2]");
  };
  EXPECT_EQ(verdict("1700000002"), "valid") << "reached at the end, which is not in the open interval";
  EXPECT_THAT(verdict("1700000001.999"), HasSubstr("a condition over all does not hold at 1.999"));
}

TEST(ValidatorContinuous, DerivedFactsFollowTheNumbers) {
  const char* world = R"((:predicates (hot) (done)) (:functions (heat)) (:derived (hot) (> (heat) 3))
    (:durative-action warm :parameters () :duration (= ?duration 5) :effect (increase (heat) (* #t 1)))
    (:action touch :precondition (hot) :effect (done))
    (:durative-action stay :parameters () :duration (= ?duration 2) :condition (over all (not (hot))) :effect (at end (done))))";
  const Checker checker(world, "(:init (= (heat) 0)) (:goal (done))");
  EXPECT_EQ(checker.verdict("0: (warm) [5]\n4: (touch)"), "valid");
  EXPECT_THAT(checker.verdict("0: (warm) [5]\n2.5: (touch)"), HasSubstr("a condition does not hold at 2.500: (hot)"));
  EXPECT_EQ(checker.verdict("0: (warm) [5]\n1: (stay) [2]"), "valid");
  EXPECT_THAT(checker.verdict("0: (warm) [5]\n2: (stay) [2]"), HasSubstr("a condition over all does not hold"));
}

TEST(ValidatorContinuous, ABreakIsFoundForEachObjectOfAQuantifierAndOfARule) {
  // The numbers pass 3 in the second half of the step: nowhere but at the crossing and beyond is the condition broken.
  for (const char* over_all : {"(forall (?z - zone) (<= (heat ?z) 3))", "(not (exists (?z - zone) (hot ?z)))"}) {
    const Checker checker(
        std::string("(:types zone) (:predicates (hot ?z - zone) (done)) (:functions (heat ?z - zone))\n"
                    "(:derived (hot ?z - zone) (> (heat ?z) 3))\n"
                    "(:durative-action warm :parameters (?z - zone) :duration (= ?duration 5)"
                    " :effect (increase (heat ?z) (* #t 1)))\n"
                    "(:durative-action stay :parameters () :duration (= ?duration 2)"
                    " :condition (over all ") +
            over_all + ") :effect (at end (done)))",
        "(:objects a b c - zone) (:init (= (heat a) 0) (= (heat b) 0) (= (heat c) 0)) (:goal (done))");
    for (const char* zone : {"a", "b", "c"}) {
      const auto verdict = [&](const std::string& stay) {
        return checker.verdict("0: (warm " + std::string(zone) + ") [5]\n" + stay + ": (stay) [2]");
      };
      EXPECT_EQ(verdict("1"), "valid") << over_all << zone;
      EXPECT_THAT(verdict("1.5"), HasSubstr("a condition over all does not hold")) << over_all << zone;
    }
  }
}

TEST(ValidatorTimes, UnixTimesAreTimes) {
  const Checker checker("(:predicates (open) (done)) (:action go :precondition (open) :effect (done))",
                        "(:init (at 1700000000 (open)) (at 1700000010 (not (open)))) (:goal (done))");
  EXPECT_EQ(checker.verdict("1700000000.001: (go)"), "valid");
  EXPECT_EQ(checker.verdict("1700000009.999: (go)"), "valid");
  EXPECT_THAT(checker.verdict("1700000000.0009: (go)"), HasSubstr("0.0009 s apart"));
  EXPECT_THAT(checker.verdict("9000000000: (go)"), HasSubstr("found a time that is not below 9000000000 s"));
  EXPECT_THAT(checker.verdict("-9000000000: (go)"), HasSubstr("found a time that is not below 9000000000 s"));
  const Checker lasting(
      "(:predicates (done)) (:durative-action go :parameters () :duration (>= ?duration 1) :effect (at end (done)))",
      "(:init) (:goal (done))");
  EXPECT_EQ(lasting.verdict("1: (go) [8999999998]"), "valid");
  EXPECT_THAT(lasting.verdict("1: (go) [8999999999]"), HasSubstr("found a time that is not below 9000000000 s"));
  EXPECT_THAT(lasting.verdict("9000000000: (go) [1]"), HasSubstr("found a time that is not below 9000000000 s"));
}

TEST(ValidatorTimes, NothingIsAskedOverAllOfWhatTakesNoTime) {
  const Checker checker(R"((:predicates (p) (done))
    (:durative-action z :parameters () :duration (>= ?duration 0) :condition (over all (p)) :effect (at end (done))))",
                        "(:init) (:goal (done))");
  EXPECT_EQ(checker.verdict("0: (z) [0]"), "valid");
  EXPECT_THAT(checker.verdict("0: (z) [0.001]"), HasSubstr("a condition over all does not hold"));
}

TEST(ValidatorQuantifiers, AreMetered) {
  const Task task = Checker(
                        "(:predicates (p ?a ?b ?c ?d ?e ?f) (done)) (:action go"
                        " :precondition (not (exists (?a ?b ?c ?d ?e ?f) (p ?a ?b ?c ?d ?e ?f))) :effect (done))",
                        "(:objects" + objects(60) + ") (:init) (:goal (done))")
                        .task();
  const Plan plan = *parse_plan("0: (go)", "plan", task.domain, task.problem);
  Meter meter(100'000);
  const auto verdict = Validator(task.domain, task.problem, &meter).check(plan);
  ASSERT_FALSE(verdict);
  EXPECT_TRUE(is(verdict.error(), Failure::kOutOfBudget));
  EXPECT_TRUE(meter.over());
}

TEST(ValidatorTimes, WhatHappensAt0IsAnEvent) {
  const Checker checker(
      "(:predicates (p) (done)) (:functions (x)) (:action go :precondition (p) :effect (done))"
      " (:action buy :precondition (<= (x) 3) :effect (done))",
      "(:init (= (x) 9) (at 0 (p)) (at 0 (= (x) 3))) (:goal (done))");
  EXPECT_THAT(checker.verdict("0: (go)"), HasSubstr("a condition does not hold at 0.000: (p)"));
  EXPECT_EQ(checker.verdict("0.001: (go)"), "valid");
  EXPECT_THAT(checker.verdict("0: (buy)"), HasSubstr("its sides are 9 and 3"));
  EXPECT_EQ(checker.verdict("0.001: (buy)"), "valid");
}

TEST(ValidatorTimes, EventsNeedNoDistanceFromEachOther) {
  const Checker checker("(:predicates (p) (q) (done)) (:action go :precondition (q) :effect (done))",
                        "(:init (at 1 (p)) (at 1.0002 (not (p))) (at 1.0004 (p)) (at 1 (q))) (:goal (and (done) (p)))");
  EXPECT_EQ(checker.verdict("2: (go)"), "valid");
}

}  // namespace
}  // namespace cxlab::planner::numbers_test
