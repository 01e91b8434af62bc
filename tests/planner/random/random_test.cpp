#include "tests/planner/random/check_many.h"
#include "tests/planner/random/check_planted.h"

namespace cxlab::planner {

TEST(RandomProblems, PlansAreValidAndUnsolvableProblemsHaveNoPlan) {
  const Tally tally = check_many(1, 300);
  EXPECT_GT(tally.plans, 60);
  EXPECT_GT(tally.unsolvable, 30);
  EXPECT_EQ(tally.missed, 0) << "the oracle found plans where the planner ended without an answer";
}

TEST(RandomProblems, MetricsAreAsGoodAsThoseOfAnExhaustiveSearch) {
  const MetricTally tally = check_metrics(1, 120, 100'000);
  EXPECT_GT(tally.compared, 10);
  EXPECT_GT(tally.not_shortest, 1);
  EXPECT_GT(tally.bounded, 3);
  EXPECT_EQ(tally.worse, 0);
}

TEST(RandomProblems, NoneWithAPlanOfTinyAndHugeConstantsIsCalledUnsolvable) {
  const PlantedTally tally = check_planted(1, 1'000, 5'000);
  EXPECT_GT(tally.accepted, 700);
  EXPECT_GT(tally.solved, tally.accepted * 9 / 10);
}

TEST(RandomProblems, TheOracleFindsPlansThatNeedOverlap) {
  RandomProblem problem;
  problem.facts = 2;
  problem.initial = {0, 0};
  problem.actions = {{3, {}, {}, {}, {{0, true}}, {{0, false}}, -1, 0},
                     {1, {}, {{0, true}}, {}, {}, {{1, true}}, -1, 0}};
  problem.goal = {{1, true}};
  EXPECT_EQ(ask_oracle(problem), OracleAnswer::kSolvable);
  problem.actions[0].duration = 1;
  problem.actions[1].duration = 2;
  EXPECT_EQ(ask_oracle(problem), OracleAnswer::kNoPlanInHorizon);
}

}  // namespace cxlab::planner
