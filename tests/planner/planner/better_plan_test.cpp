// Plans that get better, by their makespan or a metric, and those under execution.

#include <gtest/gtest.h>

#include <limits>

#include "answers.h"

namespace cxlab::planner {
namespace {

constexpr const char* kJobs =
    R"((:types job machine - object) (:predicates (waits ?j - job) (at ?j - job ?m - machine) (free ?m - machine) (done ?j - job))
  (:durative-action load :parameters (?j - job ?m - machine) :duration (= ?duration 2) :condition (and (at start (waits ?j)) (at start (free ?m)))
   :effect (and (at start (not (waits ?j))) (at start (not (free ?m))) (at end (at ?j ?m))))
  (:durative-action work :parameters (?j - job ?m - machine) :duration (= ?duration 5) :condition (at start (at ?j ?m))
   :effect (and (at start (not (at ?j ?m))) (at end (free ?m)) (at end (done ?j)))))";
constexpr const char* kSixJobs = R"((:objects j1 j2 j3 j4 j5 j6 - job m1 m2 m3 - machine)
  (:init (waits j1) (waits j2) (waits j3) (waits j4) (waits j5) (waits j6) (free m1) (free m2) (free m3))
  (:goal (forall (?j - job) (done ?j))))";

TEST(FindPlan, ImprovesUntilTheBudgetEnds) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanAnswer found = answer(task, {.budget = 500'000, .anytime = true});
  ASSERT_TRUE(found.plan);
  EXPECT_NEAR(found.plan->makespan_s, 14.0, 0.02);  // two rounds on three machines
  EXPECT_LE(found.lower_bound_s, found.plan->makespan_s);
}

TEST(FindPlan, SameBudgetSamePlan) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanOptions options{.budget = 200'000, .anytime = true};
  const PlanAnswer once = answer(task, options), again = answer(task, options);
  ASSERT_TRUE(once.plan && again.plan);
  EXPECT_EQ(to_text(once.plan->steps, task.domain, task.problem),
            to_text(again.plan->steps, task.domain, task.problem));
  EXPECT_EQ(once.units, again.units);
}

TEST(FindPlan, EveryReportedPlanIsBetterThanTheLast) {
  const Task task = parse(kJobs, kSixJobs);
  std::vector<double> reported;
  PlanOptions options{.budget = 300'000, .anytime = true};
  options.on_plan = [&](const TimedPlan& plan, std::int64_t) { reported.push_back(plan.makespan_s); };
  const PlanAnswer found = answer(task, options);
  ASSERT_FALSE(reported.empty());
  EXPECT_TRUE(std::ranges::is_sorted(reported, std::greater_equal<>{}));
  EXPECT_EQ(reported.back(), found.plan->makespan_s);
}

TEST(FindPlan, EndsWhenNoBetterPlanComesForAsLongAsItsPatience) {
  const Task task = parse(kJobs, kSixJobs);
  const auto improve = [&](std::optional<std::int64_t> patience) {
    std::int64_t last = 0;
    PlanOptions options{.budget = 300'000, .anytime = true, .patience = patience};
    options.on_plan = [&](const TimedPlan&, std::int64_t units) { last = units; };
    return std::pair(answer(task, options), last);
  };
  const auto [without, best_at] = improve({});
  ASSERT_GT(without.units, 290'000) << "the problem has no proof that ends it sooner";
  const auto [patient, last] = improve(best_at);
  EXPECT_EQ(patient.plan->makespan_s, without.plan->makespan_s);
  EXPECT_EQ(last, best_at);
  EXPECT_NEAR(static_cast<double>(patient.units), static_cast<double>(2 * best_at), 3000.0);
  const auto [hasty, first] = improve(1);
  EXPECT_GE(hasty.units, first);
  EXPECT_LE(hasty.units, first + 3000);
  EXPECT_LT(first, best_at) << "it ends at the first plan, not before";
  EXPECT_EQ(improve(std::numeric_limits<std::int64_t>::max()).first.units, without.units);
}

TEST(FindPlan, AListOfWholeActionsIsImprovedByAnActionWhileANumberChanges) {
  // The search over orders of happenings leaves out problems of so many actions, and what fills the tank cannot be cut.
  std::string cans = "(:objects", init = "(:init (chance) (idle) (= (level) 0)";
  for (int i = 0; i < 50; ++i) {
    const std::string can = " can" + std::to_string(i);
    cans += can;
    init += " (there" + can + ") (= (way" + can + ") " + std::to_string(20 + i) + ")";
  }
  const Task task = parse(R"((:predicates (full) (chance) (idle) (there ?can)) (:functions (level) (way ?can))
    (:durative-action carry :parameters (?can) :duration (= ?duration (way ?can)) :condition (and (at start (chance)) (at start (there ?can)))
     :effect (and (at start (not (chance))) (at end (full))))
    (:durative-action fill :parameters () :duration (= ?duration 3) :condition (at start (idle))
     :effect (and (at start (not (idle))) (at end (idle)) (increase (level) (* #t 1)) (at end (assign (level) 0))))
    (:durative-action close :parameters () :duration (= ?duration 1) :condition (at start (>= (level) 1.5)) :effect (at end (full))))",
                          cans + ") " + init + ") (:goal (full))");
  std::vector<double> makespans;
  PlanOptions options{.budget = 100'000, .anytime = true};
  options.on_plan = [&](const TimedPlan& plan, std::int64_t) { makespans.push_back(plan.makespan_s); };
  const PlanAnswer found = answer(task, options);
  ASSERT_EQ(makespans.size(), 2u);
  EXPECT_NEAR(makespans.front(), 20, 0.01) << "one can is carried";
  EXPECT_NEAR(makespans.back(), 3, 0.01) << to_text(found.plan->steps, task.domain, task.problem);
}

TEST(FindPlan, PlansShiftedWithinThePartialOrderAreValid) {
  const Task task = parse(kJobs, kSixJobs);
  const PlanAnswer found = answer(task, {.budget = 200'000, .anytime = true});
  ASSERT_TRUE(found.plan);
  Plan late = found.plan->steps;
  for (std::size_t i = 0; i < late.size(); ++i)
    late[i].start = static_cast<double>(found.plan->latest[2 * i]) / kMicrosPerSecond;
  const Expected<Verdict> verdict = Validator(task.domain, task.problem).check(late);
  EXPECT_TRUE(verdict && verdict->valid) << (verdict ? verdict->violation->message : verdict.error().text());
}

TEST(FindPlan, ContinuesAPlanUnderExecution) {
  const Task before = parse(kJobs, kSixJobs);
  const PlanAnswer first = answer(before);
  ASSERT_TRUE(first.plan);
  const Task now = parse(kJobs, R"((:objects j1 j2 j3 j4 j5 j6 - job m1 m2 m3 - machine)
    (:init (waits j2) (waits j3) (waits j4) (waits j5) (waits j6) (at j1 m1) (free m2) (free m3)) (:goal (forall (?j - job) (done ?j))))");
  const PlanAnswer second = answer(now, {.budget = 200'000, .warm_start = first.plan->steps});
  ASSERT_TRUE(second.plan);
  EXPECT_EQ(second.plan->steps.size(), 11u);
}

constexpr const char* kErrands = R"((:types place) (:predicates (at ?p - place) (shop ?p - place) (bought ?p - place))
  (:durative-action go :parameters (?from ?to - place) :duration (= ?duration 5)
    :condition (at start (at ?from)) :effect (and (at start (not (at ?from))) (at end (at ?to))))
  (:durative-action buy :parameters (?p - place) :duration (= ?duration 1)
    :condition (and (over all (at ?p)) (at start (shop ?p))) :effect (at end (bought ?p))))";

TEST(FindPlan, OfAWarmStartOnlyWhatIsLeftIsKept) {
  const std::string objects = "(:objects home s1 s2 - place) (:init (shop s1) (shop s2) ";
  const std::string goal = ") (:goal (and (bought s1) (bought s2) (at home)))";
  const auto steps_of = [&](const std::string& now, const Plan& warm) {
    const Task task = parse(kErrands, (objects + now + goal).c_str());
    const PlanAnswer found = answer(task, {.warm_start = warm});
    EXPECT_TRUE(found.plan);
    std::string text;
    for (const PlanStep& step : found.plan->steps) text += step_text(step, task.domain, task.problem);
    return text;
  };
  const auto step = [](ActionId action, std::vector<ObjectId> arguments) {
    return PlanStep{0, action, std::move(arguments), 1};
  };
  const Plan plan = {step(0, {0, 1}), step(1, {1}), step(0, {1, 0}), step(0, {0, 2}), step(1, {2}), step(0, {2, 0})};
  EXPECT_EQ(steps_of("(at home)", plan), "(go home s1)(buy s1)(go s1 home)(go home s2)(buy s2)(go s2 home)")
      << "the plan stays as it was";
  EXPECT_EQ(steps_of("(at home) (bought s1)", plan), "(go home s2)(buy s2)(go s2 home)")
      << "what was done could be done again";
  EXPECT_EQ(steps_of("(at s1) (bought s2)", plan), "(buy s1)(go s1 home)") << "a step was done by somebody else";
  EXPECT_EQ(steps_of("(at home) (bought s1) (bought s2)", plan), "");
}

/// Parcels by air, quick and dear, or by road, slow and cheap; several go at once.
constexpr const char* kParcels = R"((:predicates (waits ?p) (there ?p)) (:functions (total-cost) (fuel-used))
  (:durative-action fly :parameters (?p) :duration (= ?duration 2) :condition (at start (waits ?p))
   :effect (and (at start (not (waits ?p))) (at end (there ?p)) (at end (increase (total-cost) 9)) (at end (increase (fuel-used) 6))))
  (:durative-action drive :parameters (?p) :duration (= ?duration 7) :condition (at start (waits ?p))
   :effect (and (at start (not (waits ?p))) (at end (there ?p)) (at end (increase (total-cost) 2)) (at end (increase (fuel-used) 1)))))";

PlanAnswer send_parcels(const std::string& metric) {
  return answer(parse(kParcels,
                      "(:objects a b c) (:init (waits a) (waits b) (waits c) (= (total-cost) 0) (= (fuel-used) 0)) "
                      "(:goal (and (there a) (there b) (there c)))" +
                          metric),
                {.budget = 300'000, .anytime = true});
}

TEST(Metric, WithoutOneTheShortestPlanIsTheBest) {
  const PlanAnswer found = send_parcels("");
  EXPECT_FALSE(found.by_metric);
  EXPECT_NEAR(found.plan->makespan_s, 2.0, 0.01);
}

TEST(Metric, CostAloneTakesTheSlowWay) {
  const PlanAnswer found = send_parcels("(:metric minimize (total-cost))");
  EXPECT_TRUE(found.by_metric);
  EXPECT_DOUBLE_EQ(found.plan->metric.value(), 6.0);
  EXPECT_NEAR(found.plan->makespan_s, 7.0, 0.01);  // the shortest of the cheapest
}

TEST(Metric, WeighsTimeAndFuelTogether) {
  // All by road: 2 * 7 + 3 = 17; all by air: 2 * 2 + 18 = 22; one by air changes fuel only.
  EXPECT_NEAR(send_parcels("(:metric minimize (+ (* 2 (total-time)) (fuel-used)))").plan->metric.value(), 17.0, 0.01);
  // All by air: 4 * 2 + 18 = 26; all by road: 4 * 7 + 3 = 31.
  EXPECT_NEAR(send_parcels("(:metric minimize (+ (* 4 (total-time)) (fuel-used)))").plan->metric.value(), 26.0, 0.01);
}

TEST(Metric, TheBoundIsThatOfTheMakespanTimesItsWeight) {
  const PlanAnswer found = send_parcels("(:metric minimize (+ (* 4 (total-time)) (fuel-used)))");
  ASSERT_TRUE(found.metric_bound);
  EXPECT_DOUBLE_EQ(*found.metric_bound, 4 * found.lower_bound_s);
  EXPECT_GT(*found.metric_bound, 0.0);
  const PlanAnswer unweighted = send_parcels("(:metric minimize (- (fuel-used) (total-time)))");
  EXPECT_FALSE(unweighted.metric_bound);  // waiting makes it better without end
}

TEST(Metric, ABoundThatCanProveNothingNeedNotBeComputed) {
  const auto bound_with = [](const std::string& cost_of_work, bool bound) {
    std::string jobs = std::string(kJobs) + "(:functions (cost))";
    const std::string done = "(at end (done ?j))";
    jobs.insert(jobs.find(done), "(at end (increase (cost) " + cost_of_work + ")) ");
    const Task task = parse(jobs,
                            "(:objects j1 j2 - job m - machine) (:init (waits j1) (waits j2) (free m) (= (cost) 0)) "
                            "(:goal (and (done j1) (done j2))) (:metric minimize (+ (cost) (total-time)))");
    return answer(task, {.budget = 300'000, .anytime = true, .bound = bound}).lower_bound_s;
  };
  EXPECT_EQ(bound_with("0", false), 14) << "it proves that no plan is better";
  EXPECT_EQ(bound_with("1", false), 0);
  EXPECT_EQ(bound_with("1", true), 14) << "for who wants to see it";
}

TEST(Metric, AMultipleOfTheMakespanIsTheMakespan) {
  const PlanAnswer found = send_parcels("(:metric minimize (+ (* 3 (total-time)) 5))");
  EXPECT_FALSE(found.by_metric);
  EXPECT_NEAR(found.plan->metric.value(), 3 * found.plan->makespan_s + 5, 1e-9);
  EXPECT_NEAR(found.metric_bound.value(), 11.0, 1e-9);
}

TEST(Metric, AMaximizedNumberGrowsBeyondTheGoal) {
  const Task task = parse(R"((:predicates (ripe ?t) (home) (basket)) (:functions (apples))
    (:durative-action pick :parameters (?t) :duration (= ?duration 1) :condition (and (at start (ripe ?t)) (at start (basket)))
     :effect (and (at start (not (ripe ?t))) (at end (increase (apples) 3))))
    (:durative-action sell :parameters () :duration (= ?duration 1) :condition (at start (basket))
     :effect (and (at start (not (basket))) (at end (increase (apples) 4)))))",
                          "(:objects x y z) (:init (ripe x) (ripe y) (ripe z) (basket) (home) (= (apples) 0)) (:goal "
                          "(home)) (:metric maximize (apples))");
  const PlanAnswer found = answer(task, {.budget = 300'000, .anytime = true});
  EXPECT_DOUBLE_EQ(found.plan->metric.value(), 13.0);  // three trees, then the basket is sold
  EXPECT_FALSE(found.metric_bound);
}

TEST(Metric, TheSameBudgetGivesTheSamePlan) {
  const std::string metric = "(:metric minimize (+ (* 2 (total-time)) (fuel-used)))";
  const PlanAnswer first = send_parcels(metric), second = send_parcels(metric);
  EXPECT_EQ(first.units, second.units);
  ASSERT_EQ(first.plan->steps.size(), second.plan->steps.size());
  for (std::size_t i = 0; i < first.plan->steps.size(); ++i) {
    EXPECT_EQ(first.plan->steps[i].arguments, second.plan->steps[i].arguments);
    EXPECT_EQ(first.plan->steps[i].start, second.plan->steps[i].start);
  }
}

}  // namespace
}  // namespace cxlab::planner
