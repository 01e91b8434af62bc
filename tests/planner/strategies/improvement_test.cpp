// The strategies that make a plan better, each alone.

#include <algorithm>

#include "cx/base/random.h"
#include "planner/improve/local_search.h"
#include "planner/strategies/improvement.h"
#include "planner/strategies/sequence_search.h"
#include "prepared.h"

namespace cxlab::planner {
namespace {

constexpr const char* kMatches = R"((:functions (cost)) (:predicates (unused ?m) (light) (mended ?f) (fuse ?f))
  (:durative-action strike :parameters (?m) :duration (= ?duration 5) :condition (at start (unused ?m))
   :effect (and (at start (not (unused ?m))) (at start (light)) (at end (not (light))) (at end (increase (cost) 1))))
  (:durative-action mend :parameters (?f) :duration (= ?duration 2) :condition (and (at start (fuse ?f)) (over all (light)))
   :effect (at end (mended ?f))))";
const std::string kTwoMatches =
    "(:objects m n f g) (:init (unused m) (unused n) (fuse f) (fuse g) (= (cost) 0)) (:goal (and (mended f) (mended "
    "g)))";

/// Two matches one after the other, where one is enough.
Sequence two_matches(const Prepared& problem, const SplitTask& split) {
  const auto part = [&](const char* name, bool end) {
    const auto [first, last] = split.parts[static_cast<std::size_t>(problem.action(name))];
    return SequenceStep{end ? last : first, !end && last < 0 ? 2'000'000 : 0};
  };
  return {part("(strike m)", false), part("(mend f)", false), part("(strike m)", true),
          part("(strike n)", false), part("(mend g)", false), part("(strike n)", true)};
}

TEST(Decoder, LooksAtEachEventOfAListOnce) {
  Prepared problem(R"((:predicates (day) (up) (fed))
    (:durative-action rise :parameters () :duration (= ?duration 1) :condition (at start (day)) :effect (at end (up)))
    (:durative-action eat :parameters () :duration (= ?duration 1) :condition (at start (up)) :effect (at end (fed))))",
                   "(:init (at 6 (day))) (:goal (fed))");
  Decoder decoder(problem->whole.split, problem->ground, problem->whole.space.simulator, problem->touches,
                  problem->objective);
  const SequenceStep dawn{-2, 0};
  ASSERT_TRUE(is_event(dawn));
  DecodedPlan plan;
  const Sequence list{dawn, {problem.action("(rise)"), 1'000'000}, {problem.action("(eat)"), 1'000'000}};
  ASSERT_TRUE(decoder.decode(list, 1e18, plan));
  EXPECT_EQ(plan.order.size(), 3u);
  EXPECT_EQ(decoder.take_work(), 3);
}

/// Decodes lists that differ a little from plans that were kept, and each of them with a fresh decoder, too.
void compare_with_fresh_decoders(Prepared& problem, const SplitSpace& space, const Sequence& first) {
  const auto fresh = [&] {
    return Decoder(space.split, problem->ground, space.space.simulator, problem->touches, problem->objective);
  };
  Decoder keeps = fresh();
  DecodedPlan kept, one, other;
  ASSERT_TRUE(keeps.decode(first, 1e18, kept));
  keeps.keep(kept);
  keeps.take_work();
  RandomStream random(1, "lists");
  int plans = 0, late = 0;
  for (int i = 0; i < 400; ++i) {
    Sequence list = random.chance(0.5) ? kept.order : first;
    for (auto moves = random.between(0, 2); moves > 0; --moves) {
      const auto at = [&] { return list.begin() + static_cast<std::ptrdiff_t>(random.below(list.size())); };
      if (random.chance(0.7))
        std::iter_swap(at(), at());
      else
        list.erase(at());
    }
    Decoder anew = fresh();
    const double most = random.chance(0.3) ? (random.chance(0.5) ? kept.cost : 0.6 * kept.value) : 1e18;
    const bool is_plan = keeps.decode(list, most, one);
    ASSERT_EQ(is_plan, anew.decode(list, most, other)) << "list " << i;
    ASSERT_EQ(keeps.take_work(), anew.take_work()) << "list " << i;
    ASSERT_EQ(one.order, other.order) << "list " << i;
    if (!is_plan) continue;
    ASSERT_EQ(one.times, other.times);
    ASSERT_EQ(one.causes, other.causes);
    ASSERT_EQ(one.late, other.late);
    ASSERT_EQ(one.cost, other.cost);
    ASSERT_EQ(one.lateness, other.lateness);
    ++plans;
    late += one.lateness > 0;
    keeps.keep(kept = one);
  }
  EXPECT_GT(plans, 50);
  EXPECT_EQ(late > 10, problem->has_events()) << "some lists are to come too late for them";
}

constexpr const char* kWalls =
    R"((:functions (points)) (:predicates (lit) (brush ?b) (free ?b) (wall ?w) (dry ?w) (painted ?w) (day))
  (:durative-action paint :parameters (?w ?b) :duration (= ?duration 3)
   :condition (and (at start (brush ?b)) (at start (free ?b)) (at start (dry ?w)) (over all (day)))
   :effect (and (at start (not (free ?b))) (at end (free ?b)) (at end (painted ?w)) (at end (increase (points) 1))))
  (:durative-action dry :parameters (?w) :duration (= ?duration 2) :condition (at start (wall ?w)) :effect (at end (dry ?w)))
  (:durative-action strip :parameters (?w) :duration (= ?duration 1) :condition (at start (painted ?w)) :effect (at end (not (painted ?w))))
  (:durative-action wash :parameters (?b) :duration (= ?duration 1) :condition (at start (free ?b)) :effect (and (at start (not (free ?b))) (at end (free ?b)))))";

TEST(Decoder, GivesTheSameForWhatAListHasInCommonWithThePlanKept) {
  const std::string walls =
      "(:objects a b u v w x) (:init (brush a) (brush b) (free a) (free b) (wall u) (wall v) (wall w) (wall x) (lit) "
      "(= (points) 0) (at 2 (day)) (at 7 (not (lit))) (at 8 (not (day))) (at 20 (lit))) (:goal (and (lit) (painted u) "
      "(painted v) (painted w) (painted x)))";
  const std::vector<std::string> steps{"(dry u)",     "(wash a)",  "(dry v)",     "next event", "(paint u a)",
                                       "(paint v b)", "(dry w)",   "(paint w a)", "(dry x)",    "(wash b)",
                                       "(paint x b)", "(strip u)", "(paint u a)"};
  for (const char* metric : {"", "(:metric minimize (* 2 (total-time)))", "(:metric maximize (points))"}) {
    Prepared problem(kWalls, walls + metric);
    compare_with_fresh_decoders(problem, problem->whole, problem.list(steps));
  }
}

TEST(Decoder, GivesTheSameWhereActionsAreCut) {
  Prepared problem(kMatches, kTwoMatches);
  SequenceSearch cut(*problem, Cut::kEnvelopes);
  ASSERT_TRUE(cut.space());
  compare_with_fresh_decoders(problem, *cut.space(), two_matches(problem, cut.space()->split));
}

TEST(Improvement, OfAListMovesAndExchangesItsActions) {
  Prepared problem(kCups, kTwoCups);
  const Sequence list = problem.list({"(sink a)", "(sink b)"});
  ASSERT_TRUE(problem->offer(problem->whole, list));
  Improvement improve(*problem);
  EXPECT_TRUE(improve.of_list(list, 0, 200));
  EXPECT_EQ(problem->best.makespan(), 5'000'000) << "one at the sink, one by hand";
  EXPECT_EQ(problem->best_list().size(), 2u);
}

TEST(Improvement, OfWhatIsNoPlanFails) {
  Prepared problem(kCups, kTwoCups);
  Improvement improve(*problem);
  EXPECT_FALSE(improve.of_list({}, 0, 200));
  EXPECT_FALSE(improve.of_list(problem.list({"(sink a)"}), 0, 200));
  EXPECT_FALSE(problem->best.exists());
}

TEST(Improvement, OfPartsStrikesOneMatchForBothFuses) {
  Prepared problem(kMatches, kTwoMatches);
  SequenceSearch cut(*problem, Cut::kEnvelopes);
  ASSERT_TRUE(cut.space());
  ASSERT_TRUE(problem->offer(*cut.space(), two_matches(problem, cut.space()->split)));
  EXPECT_GT(problem->best.plan().makespan_s, 10);
  Improvement(*problem).of_parts(*cut.space(), problem->best_parts().list, 0, 500);
  EXPECT_LT(problem->best.plan().makespan_s, 5.01);
  EXPECT_EQ(problem->best_parts().cut, cut.space());
}

/// Each job is worked on by each machine, in an order of its own.
struct JobShop {
  explicit JobShop(std::uint64_t seed) {
    constexpr int kJobs = 8, kMachines = 4;
    RandomStream random(seed, "job shop");
    const auto name = [](const char* what, int i) { return what + std::to_string(i); };
    std::string jobs, machines, stages, init, goal;
    int load[kMachines] = {};
    for (int m = 0; m < kMachines; ++m) {
      machines += ' ' + name("m", m);
      init += " (free " + name("m", m) + ")";
    }
    for (int s = 0; s <= kMachines; ++s) stages += ' ' + name("s", s);
    for (int s = 0; s < kMachines; ++s) init += " (next " + name("s", s) + ' ' + name("s", s + 1) + ")";
    for (int j = 0; j < kJobs; ++j) {
      jobs += ' ' + name("j", j);
      init += " (at " + name("j", j) + " s0)";
      goal += " (at " + name("j", j) + ' ' + name("s", kMachines) + ")";
      std::vector<int> order{0, 1, 2, 3};
      for (int s = 0; s < kMachines; ++s) {
        std::swap(order[static_cast<std::size_t>(s)],
                  order[static_cast<std::size_t>(random.between(s, kMachines - 1))]);
        const int m = order[static_cast<std::size_t>(s)], time = static_cast<int>(random.between(1, 20));
        load[m] += time;
        init += " (visits " + name("j", j) + ' ' + name("s", s) + ' ' + name("m", m) + ") (= (time " + name("j", j) +
                ' ' + name("m", m) + ") " + std::to_string(time) + ")";
        steps.push_back("(work " + name("j", j) + ' ' + name("m", m) + ' ' + name("s", s) + ' ' + name("s", s + 1) +
                        ")");
      }
    }
    least = *std::ranges::max_element(load);
    problem = "(:objects" + jobs + " - job" + machines + " - machine" + stages + " - stage) (:init" + init +
              ") (:goal (and" + goal + "))";
  }

  static constexpr const char* kDomain = R"((:types job machine stage) (:functions (time ?j - job ?m - machine))
    (:predicates (free ?m - machine) (at ?j - job ?s - stage) (next ?s ?t - stage) (visits ?j - job ?s - stage ?m - machine))
    (:durative-action work :parameters (?j - job ?m - machine ?s ?t - stage) :duration (= ?duration (time ?j ?m))
     :condition (and (at start (at ?j ?s)) (at start (visits ?j ?s ?m)) (at start (next ?s ?t)) (at start (free ?m)))
     :effect (and (at start (not (free ?m))) (at end (free ?m)) (at start (not (at ?j ?s))) (at end (at ?j ?t)))))";
  std::string problem;
  std::vector<std::string> steps;  ///< one job after the other
  int least = 0;                   ///< s that the busiest machine works
};

TEST(LocalSearch, TakesJobShopsCloseToTheWorkOfTheirBusiestMachine) {
  double least = 0, began = 0, best = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const JobShop shop(seed);
    Prepared problem(JobShop::kDomain, shop.problem);
    Decoder decoder(problem->whole.split, problem->ground, problem->whole.space.simulator, problem->touches,
                    problem->objective);
    LocalSearch search(decoder, problem->whole.space.simulator, seed);
    ASSERT_TRUE(search.start(problem.list(shop.steps)));
    least += shop.least;
    began += in_seconds(search.best().makespan);
    Budget budget;
    search.run(budget, 2000, [](const DecodedPlan&) {});
    EXPECT_GE(in_seconds(search.best().makespan), shop.least) << seed;
    best += in_seconds(search.best().makespan);
  }
  EXPECT_GT(began, 2 * least);
  EXPECT_LT(best, 1.04 * least);
}

TEST(BetterMetricSearch, FindsPartsWithABetterMetric) {
  Prepared problem(kMatches, kTwoMatches + "(:metric minimize (cost))");
  SequenceSearch cut(*problem, Cut::kEnvelopes);
  ASSERT_TRUE(cut.space());
  ASSERT_TRUE(problem->offer(*cut.space(), two_matches(problem, cut.space()->split)));
  BetterMetricSearch search(*problem, *cut.space());
  const std::optional<Sequence> found = search.run({1, 50'000});
  ASSERT_TRUE(found);
  ASSERT_TRUE(problem->offer(*cut.space(), *found));
  EXPECT_EQ(problem->best.cost(), 1);
}

constexpr const char* kTrip = R"((:functions (fuel)) (:predicates (home) (there))
  (:durative-action fly :parameters () :duration (= ?duration 1) :condition (at start (home)) :effect (and (at end (there)) (at end (increase (fuel) 9))))
  (:durative-action drive :parameters () :duration (= ?duration 5) :condition (at start (home)) :effect (and (at end (there)) (at end (increase (fuel) 4))))
  (:durative-action walk :parameters () :duration (= ?duration 60) :condition (at start (home)) :effect (at end (there))))";

TEST(BetterMetricSearch, FindsListsWithABetterMetricUntilNoneIsLeft) {
  Prepared problem(kTrip, "(:init (home) (= (fuel) 0)) (:goal (there)) (:metric minimize (fuel))");
  ASSERT_TRUE(problem->offer(problem->whole, problem.list({"(fly)"})));
  BetterMetricSearch search(*problem, problem->whole);
  std::vector<double> costs;
  for (std::uint64_t round = 0; round < 5 && !search.exhausted(); ++round) {
    const std::optional<Sequence> found = search.run({round, 10'000});
    if (found && problem->offer(problem->whole, *found)) costs.push_back(problem->best.cost());
  }
  EXPECT_TRUE(search.exhausted());
  ASSERT_FALSE(costs.empty());
  EXPECT_EQ(costs.back(), 0) << "walking takes no fuel";
}

TEST(BetterMetricSearch, HasNothingToDoWhereTimeAloneCounts) {
  Prepared problem(kTrip, "(:init (home) (= (fuel) 0)) (:goal (there))");
  ASSERT_TRUE(problem->offer(problem->whole, problem.list({"(drive)"})));
  BetterMetricSearch search(*problem, problem->whole);
  EXPECT_FALSE(search.run({0, 10'000}));
  EXPECT_TRUE(search.exhausted());
}

}  // namespace
}  // namespace cxlab::planner
