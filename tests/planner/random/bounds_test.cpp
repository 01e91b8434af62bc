// Lower bounds of random problems against the shortest plans, found by trying everything.

#include <gtest/gtest.h>

#include "planner/bounds/lower_bound.h"
#include "planner/ground/ground.h"
#include "planner/pddl/parser.h"
#include "tests/planner/random/timed_oracle.h"

namespace cxlab::planner::bounds_test {

namespace {

struct Tally {
  int measured = 0, tight = 0;   ///< shortest plans that are known; bounds that meet them
  int assumed = 0, shorter = 0;  ///< bounds that assume an order; shorter plans that do not keep to it
};

Tally check_bounds(std::uint64_t seed, int count, RandomProblem (*draw)(RandomStream&)) {
  RandomStream random(seed, "bounds of random temporal problems");
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const RandomProblem problem = draw(random);
    SCOPED_TRACE(problem.domain() + problem.problem());
    Expected<Domain> domain = parse_domain(problem.domain(), "domain");
    Expected<Problem> parsed = parse_problem(problem.problem(), "problem", *domain);
    const Expected<GroundTask> task = ground({std::move(*domain), std::move(*parsed)});
    if (!task || task->proved_unsolvable) continue;
    Budget budget;
    const LowerBound bound = lower_bound(*task, budget, 100'000);
    const auto bound_s = bound.makespan / kMicrosPerSecond;
    const auto shortest = [&](bool may_coincide) {
      return shortest_plan_s(problem, {.seconds = 8, .most_situations = 6000, .may_coincide = may_coincide});
    };
    if (const std::optional<int> ordered = shortest(!bound.assumes_order)) {
      ++tally.measured;
      EXPECT_LE(bound_s, *ordered);
      tally.tight += bound_s == *ordered;
    }
    if (!bound.assumes_order) continue;
    ++tally.assumed;
    if (const std::optional<int> any = shortest(true)) tally.shorter += bound_s > *any;
  }
  return tally;
}

}  // namespace

TEST(BoundsOfRandomProblems, NoPlanIsShorter) {
  const Tally tally = check_bounds(1, 500, RandomProblem::draw);
  EXPECT_GT(tally.measured, 100);
  EXPECT_GT(tally.tight, tally.measured * 3 / 4);
}

TEST(BoundsOfRandomProblems, NoPlanOfAShopIsShorter) {
  const Tally tally = check_bounds(2, 200, RandomProblem::draw_shop);
  EXPECT_GT(tally.measured, 50);
  EXPECT_GT(tally.tight, tally.measured * 3 / 4);
  EXPECT_GT(tally.shorter, 0) << "of " << tally.assumed << " bounds that assume an order";
}

}  // namespace cxlab::planner::bounds_test
