// The best plan so far: what is accepted, what is published, how far it is from the best possible one.

#include "prepared.h"

namespace cxlab::planner {
namespace {

TEST(Incumbent, PublishesOnlyPlansThatAreShorter) {
  std::vector<double> published;
  Prepared problem(kCups, kTwoCups,
                   {.on_plan = [&](const TimedPlan& plan, std::int64_t) { published.push_back(plan.makespan_s); }});
  EXPECT_TRUE(problem->offer(problem->whole, problem.list({"(sink a)", "(sink b)"})));
  EXPECT_NEAR(problem->best.plan().makespan_s, 6.001, 1e-3);
  EXPECT_FALSE(problem->offer(problem->whole, problem.list({"(sink b)", "(sink a)"}))) << "as long as the first";
  EXPECT_TRUE(problem->offer(problem->whole, problem.list({"(sink a)", "(hand b)"})));
  EXPECT_FALSE(problem->offer(problem->whole, problem.list({"(sink a)", "(sink b)"})));
  ASSERT_EQ(published.size(), 2u);
  EXPECT_NEAR(published[0], 6.001, 1e-3);
  EXPECT_EQ(published[1], 5.0);
  EXPECT_EQ(problem->best.makespan(), 5'000'000);
  EXPECT_EQ(problem->best_list(), problem.list({"(sink a)", "(hand b)"}));
}

TEST(Incumbent, StepsBeginAsEarlyAsTheyCanAndKnowTheirLatestTimes) {
  Prepared problem(kCups, kTwoCups);
  ASSERT_TRUE(problem->offer(problem->whole, problem.list({"(sink a)", "(hand b)"})));
  const TimedPlan& plan = problem->best.plan();
  ASSERT_EQ(plan.steps.size(), 2u);
  EXPECT_EQ(plan.steps[0].start, 0);
  EXPECT_EQ(plan.steps[1].start, 0);
  const std::size_t sink = plan.steps[0].duration == 3 ? 0 : 1;
  EXPECT_EQ(plan.latest[2 * sink], 2'000'000) << "the sink may start two seconds later";
  EXPECT_EQ(plan.latest[2 * sink + 1], 5'000'000);
  EXPECT_EQ(plan.latest[2 * (1 - sink)], 0);
}

TEST(Incumbent, RefusesWhatTheValidatorRefuses) {
  Prepared problem(kCups, kTwoCups);
  Sequence list = problem.list({"(sink a)"});  // b stays dirty
  EXPECT_FALSE(problem->offer(problem->whole, list));
  EXPECT_FALSE(problem->best.exists());
  EXPECT_FALSE(problem->best.offer(std::vector<ClockStep>{{problem.action("(sink a)"), 0, 3'000'000},
                                                          {problem.action("(sink b)"), 1'000'000, 4'000'000}}))
      << "both at the sink";
  PlanAnswer answer;
  std::move(problem->best).report(answer);
  EXPECT_EQ(answer.refused, 2);
  EXPECT_NE(answer.refusal.find("sink-free"), std::string::npos) << answer.refusal;
}

TEST(Incumbent, KeepsTheTimesOfStepsThatHaveSome) {
  Prepared problem(kCups, kTwoCups);
  ASSERT_TRUE(problem->best.offer(std::vector<ClockStep>{{problem.action("(hand b)"), 500'000, 5'500'000},
                                                         {problem.action("(sink a)"), 1'000'000, 4'000'000}}));
  const TimedPlan& plan = problem->best.plan();
  EXPECT_EQ(plan.steps[0].start, 0.5);
  EXPECT_EQ(plan.steps[1].start, 1.0);
  EXPECT_EQ(plan.makespan_s, 5.5);
  EXPECT_EQ(plan.latest, (std::vector<Micros>{500'000, 5'500'000, 1'000'000, 4'000'000}));
}

TEST(Incumbent, AMetricDecidesAndTheMakespanAmongEquals) {
  const std::string domain = R"((:functions (water)) (:predicates (clean ?c) (cup ?c))
    (:durative-action soak :parameters (?c) :duration (= ?duration 9) :condition (at start (cup ?c)) :effect (and (at end (clean ?c)) (at end (increase (water) 1))))
    (:durative-action rinse :parameters (?c) :duration (= ?duration 2) :condition (at start (cup ?c)) :effect (and (at end (clean ?c)) (at end (increase (water) 4))))
    (:durative-action wipe :parameters (?c) :duration (= ?duration 1) :condition (at start (cup ?c)) :effect (and (at end (clean ?c)) (at end (increase (water) 4)))))";
  for (const bool maximize : {false, true}) {
    Prepared problem(domain, std::string("(:objects a) (:init (cup a) (= (water) 0)) (:goal (clean a)) (:metric ") +
                                 (maximize ? "maximize (- 0 (water)))" : "minimize (water))"));
    ASSERT_TRUE(problem->best.by_metric());
    EXPECT_TRUE(problem->offer(problem->whole, problem.list({"(rinse a)"})));
    EXPECT_TRUE(problem->offer(problem->whole, problem.list({"(wipe a)"}))) << "as much water, but shorter";
    EXPECT_FALSE(problem->offer(problem->whole, problem.list({"(rinse a)"})));
    EXPECT_TRUE(problem->offer(problem->whole, problem.list({"(soak a)"}))) << "longer, but less water";
    EXPECT_EQ(problem->best.cost(), 1);
    EXPECT_EQ(problem->best.plan().metric, maximize ? -1 : 1);
  }
}

TEST(BestPossible, ProvesAPlanThatIsAsShortAsTheBound) {
  Prepared problem(kCups, "(:objects a) (:init (dirty a) (sink-free)) (:goal (clean a))");
  ASSERT_TRUE(problem->offer(problem->whole, problem.list({"(hand a)"})));
  EXPECT_FALSE(problem->bound.proves(problem->best));
  problem->bound.raise();
  EXPECT_EQ(problem->bound.makespan(), 3'000'000);
  EXPECT_FALSE(problem->bound.proves(problem->best)) << "5 s";
  ASSERT_TRUE(problem->offer(problem->whole, problem.list({"(sink a)"})));
  EXPECT_TRUE(problem->bound.proves(problem->best)) << "3 s";
  EXPECT_FALSE(problem->bound.is_due()) << "it is complete";
}

TEST(BestPossible, IsDueWhenFiveTimesItsSliceHasBeenSpent) {
  Prepared problem(kCups, kTwoCups);
  problem->bound.keep_first_slice_short();  // of 2,000 units, for less has been spent
  EXPECT_FALSE(problem->bound.is_due());
  problem->budget.spend(Work::kNode, 5'000 - problem->budget.units() / 2);
  EXPECT_FALSE(problem->bound.is_due()) << problem->budget.units();
  problem->budget.spend(Work::kNode, 1);
  EXPECT_TRUE(problem->bound.is_due()) << problem->budget.units();
}

}  // namespace
}  // namespace cxlab::planner
