#include <gmock/gmock.h>

#include "checker.h"

namespace cxlab::planner {
namespace {

using ::testing::HasSubstr;

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
  (:durative-action wild :parameters () :duration (= ?duration 4) :effect (increase (other) (* #t (level))))
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

TEST(ValidatorContinuous, RateThatChangesItselfIsNotSupported) {
  const Checker checker(kTank, "(:init (= (level) 0) (= (flow) 1) (= (other) 0)) (:goal (and))");
  EXPECT_EQ(checker.verdict("0: (wild) [4]"), "valid");
  const auto verdict = checker.check("0: (wild) [4]\n1: (fill) [2]");
  ASSERT_FALSE(verdict);
  EXPECT_TRUE(is(verdict.error(), Failure::kUnsupported));
  EXPECT_THAT(verdict.error().message,
              HasSubstr("the rate of 0.000: (wild) (line 1) reads a number that changes continuously itself"));
}

TEST(ValidatorContinuous, TimedValuesInterfereWithConditions) {
  const char* world =
      R"((:predicates (done)) (:functions (price)) (:action buy :precondition (<= (price) 5) :effect (done)))";
  const Checker checker(world, "(:init (= (price) 9) (at 4 (= (price) 3)) (at 8 (= (price) 9))) (:goal (done))");
  EXPECT_EQ(checker.verdict("5: (buy)"), "valid");
  EXPECT_THAT(checker.verdict("3: (buy)"), HasSubstr("its sides are 9 and 5"));
  EXPECT_THAT(checker.verdict("8: (buy)"), HasSubstr("the initial state's event at 8.000"));
}

}  // namespace
}  // namespace cxlab::planner
