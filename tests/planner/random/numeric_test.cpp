// No false proof, and a plan wherever trying all plans of up to three steps finds one.

#include "tests/planner/random/check_numeric.h"

namespace cxlab::planner {

constexpr std::int64_t kTwoSeconds = 2'000'000;  ///< units

TEST(RandomNumericProblems, AreSolvedWhereTryingAllSmallPlansSolvesThemAndNoneIsDenied) {
  const NumericTally tally = check_numeric<NumericProblem>(1, 100, kTwoSeconds);
  EXPECT_GT(tally.plans, 20);
  EXPECT_GT(tally.unsolvable, 35);
  EXPECT_GT(tally.exhausted, 35) << "where the planner finds nothing, the oracle has tried all";
  EXPECT_EQ(tally.missed, 0);
}

TEST(RandomNumericProblems, OfMoreKindsAreSolvedAndNoneIsDenied) {
  const NumericTally tally = check_numeric<WideProblem>(420, 60, 200'000);
  EXPECT_GT(tally.plans, 12);
  EXPECT_GT(tally.unsolvable, 25);
  EXPECT_GT(tally.exhausted, 22) << "where the planner finds nothing, the oracle has tried all";
  EXPECT_EQ(tally.missed, 0);
}

/// a0 lasts 2 s, needs (f0) over all and makes (f1); a1 lasts `light` seconds and makes (f0) for as long.
NumericProblem with_light(int light) {
  NumericProblem problem;
  problem.facts = 2;
  problem.numbers = 0;
  problem.initial = {0, 0};
  problem.actions.resize(2);
  problem.actions[0].least = problem.actions[0].most = 2;
  problem.actions[0].over_all.facts = {{0, true}};
  problem.actions[0].at_end.facts = {{1, true}};
  problem.actions[1].least = problem.actions[1].most = light;
  problem.actions[1].at_start.facts = {{0, true}};
  problem.actions[1].at_end.facts = {{0, false}};
  problem.goal.facts = {{1, true}};
  return problem;
}

TEST(NumericOracle, FindsPlansThatNeedOverlap) {
  EXPECT_TRUE(find_witness(with_light(3)).plan);
  const WitnessAnswer none = find_witness(with_light(1), {.steps = 2});
  EXPECT_FALSE(none.plan);
  EXPECT_FALSE(none.too_large);
}

TEST(NumericOracle, FollowsNumbersAndEvents) {
  NumericProblem problem;
  problem.facts = 1;
  problem.numbers = 1;
  problem.initial = {0};
  problem.values = {0};
  problem.actions.resize(1);
  NumericAction& fill = problem.actions[0];
  fill.duration = NumericAction::Duration::kChosen;
  fill.least = 1;
  fill.most = 4;
  fill.rates = {{0, 2}};
  fill.end.facts = {{0, true}};
  problem.goal.numbers = {{0, "=", 6}};
  problem.events = {{3, false, {0, true}, 0, 0}};
  const WitnessAnswer found = find_witness(problem, {.steps = 1});
  ASSERT_TRUE(found.plan);
  ASSERT_EQ(found.plan->size(), 1u);
  EXPECT_EQ(found.plan->front().duration, 3000);
  EXPECT_GT(found.plan->front().start, 0) << "(f0) is true after 3 s";
  problem.goal.numbers = {{0, "=", 7}};
  EXPECT_FALSE(find_witness(problem, {.steps = 1}).plan) << "3.5 s is not on the grid";
}

}  // namespace cxlab::planner
