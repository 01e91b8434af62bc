#include "planner/validator/robustness.h"

#include "checker.h"

namespace cxlab::planner::robustness_test {
namespace {

const char* kWorld = R"((:predicates (light) (seen))
  (:durative-action burn :parameters () :duration (= ?duration 10) :effect (and (at start (light)) (at end (not (light)))))
  (:durative-action look :parameters () :duration (= ?duration 4) :condition (over all (light)) :effect (at end (seen))))";

Robustness of(const std::string& text, double limit) {
  const Checker checker(kWorld, "(:goal (seen))");
  const auto plan = parse_plan(text, "plan", checker.task().domain, checker.task().problem);
  const Validator validator(checker.task().domain, checker.task().problem);
  const auto found = robustness(validator, *plan, {}, limit);
  EXPECT_TRUE(found);
  return *found;
}

TEST(Robustness, IsHalfOfTheSlackWhenBothStepsMove) {
  const Robustness found =
      of("0: (burn) [10]\n3: (look) [4]", 8);  // the light goes out 3 s after the look, burn cannot begin earlier
  EXPECT_NEAR(found.holds, 1.5, 0.01) << "look 1.5 later, burn 1.5 later";
  EXPECT_NEAR(found.breaks, found.holds, 0.01);
  ASSERT_TRUE(found.violation);
  EXPECT_EQ(found.violation->kind, Violation::Kind::kCondition);
}

TEST(Robustness, PlanWithoutSlackHasNone) { EXPECT_LT(of("0: (burn) [10]\n0.001: (look) [4]", 8).breaks, 0.01); }

TEST(Robustness, LimitIsReachedWhenNothingBreaks) {
  const Robustness found = of("5: (burn) [10]\n8: (look) [4]", 0.5);
  EXPECT_EQ(found.holds, 0.5);
  EXPECT_EQ(found.breaks, 0);
  EXPECT_FALSE(found.violation);
}

TEST(Robustness, EachStepMovesForwardsAndBackwards) {
  const Checker checker(kWorld, "(:init (at 5 (light)) (at 10 (not (light)))) (:goal (seen))");
  const Validator validator(checker.task().domain, checker.task().problem);
  for (const char* text : {"5.1: (look) [4]", "5.9: (look) [4]"}) {
    const auto plan = parse_plan(text, "plan", checker.task().domain, checker.task().problem);
    EXPECT_NEAR(robustness(validator, *plan, {}, 3, 1, 0)->breaks, 0.1, 0.001) << text << ", without random draws";
  }
}

TEST(Robustness, IsTheSameEachTime) {
  EXPECT_EQ(of("0: (burn) [10]\n3: (look) [4]", 8).holds, of("0: (burn) [10]\n3: (look) [4]", 8).holds);
}

}  // namespace
}  // namespace cxlab::planner::robustness_test
