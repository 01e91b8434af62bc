#include "tests/planner/random/check_many.h"
#include "tests/planner/random/check_numeric.h"
#include "tests/planner/random/check_planted.h"

namespace cxlab::planner {

static void expect_plans_and_no_miss(const NumericTally& tally) {
  std::printf("plans %d (at most %lld units), proved unsolvable %d, ended %d, out of budget %d, missed %d\n",
              tally.plans, static_cast<long long>(tally.most_units), tally.unsolvable, tally.ended, tally.out_of_budget,
              tally.missed);
  EXPECT_GT(tally.plans, 1'000);
  EXPECT_EQ(tally.missed, 0);
}

TEST(RandomProblems, TenThousandProblems) {
  const Tally tally = check_many(2, 10'000);
  std::printf("plans %d, proved unsolvable %d, no answer %d, of which the oracle solves %d\n", tally.plans,
              tally.unsolvable, tally.ended, tally.missed);
  EXPECT_GT(tally.plans, 2000);
  EXPECT_LT(tally.missed, 10);
}

TEST(RandomProblems, FiveThousandWithNumbersLinearChangeAndTimedValues) {
  expect_plans_and_no_miss(check_numeric<NumericProblem>(100'000, 5'000, 2'000'000));
}

TEST(RandomProblems, FiveThousandOfMoreKinds) {
  expect_plans_and_no_miss(check_numeric<WideProblem>(100'000, 5'000, 2'000'000));
}

TEST(RandomProblems, TwentyThousandWithTinyAndHugeConstants) {
  const PlantedTally tally = check_planted(2, 20'000, 5'000);
  std::printf("with an accepted plan %d, solved %d\n", tally.accepted, tally.solved);
  EXPECT_GT(tally.accepted, 14'000);
  EXPECT_GT(tally.solved, tally.accepted * 9 / 10);
}

TEST(RandomProblems, TwoThousandMetrics) {
  const MetricTally tally = check_metrics(2, 2'000, 300'000);
  std::printf("compared %d, worse %d, other than the shortest %d, bounded %d\n", tally.compared, tally.worse,
              tally.not_shortest, tally.bounded);
  EXPECT_GT(tally.compared, 400);
  EXPECT_LT(50 * tally.worse,
            tally.compared);  // improvement proves nothing: 6 of 599 were not the best when this was written
}

}  // namespace cxlab::planner
