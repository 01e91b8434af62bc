// The strategies that find a first plan, each alone; proofs that no plan exists.

#include "planner/strategies/clock_strategy.h"
#include "planner/strategies/happening_strategy.h"
#include "planner/strategies/late_repair.h"
#include "planner/strategies/unsolvable.h"
#include "planner/strategies/warm_start.h"
#include "prepared.h"

namespace cxlab::planner {
namespace {

constexpr Turn kTurn{0, 20'000};
/// Too short for most searches to end.
constexpr Turn kShortTurn{0, 2};

TEST(SequenceSearch, FindsASequenceOfWholeActions) {
  Prepared problem(kCups, kTwoCups);
  SequenceSearch search(*problem, Cut::kNothing);
  EXPECT_TRUE(search.run(kTurn));
  EXPECT_EQ(problem->best.plan().steps.size(), 2u);
  EXPECT_EQ(problem->best_list().size(), 2u);
  EXPECT_FALSE(problem->best_parts().cut);
}

TEST(SequenceSearch, IsExhaustedWhereOneActionNeedsAnotherToBeUnderWay) {
  Prepared problem(kMatch, kOneMatch);
  SequenceSearch search(*problem, Cut::kNothing);
  EXPECT_FALSE(search.run(kTurn));
  EXPECT_TRUE(search.exhausted());
  const std::int64_t units = problem->budget.units();
  EXPECT_FALSE(search.run({1, 20'000}));
  EXPECT_EQ(problem->budget.units(), units) << "nothing more to search";
}

TEST(SequenceSearch, ASequenceThatComesTooLateIsFoundOnlyWhereEventsDoNotCount) {
  // Work takes 4 s in the light, which is there for 3 s.
  const std::string domain = R"((:predicates (light) (done))
    (:durative-action work :parameters () :duration (= ?duration 4) :condition (over all (light)) :effect (at end (done))))";
  Prepared problem(domain, "(:init (light) (at 3 (not (light)))) (:goal (done))");
  SequenceSearch search(*problem, Cut::kNothing);
  EXPECT_FALSE(search.run(kTurn));
  const std::optional<Sequence> late = search.find(kTurn);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->size(), 1u);
  EXPECT_FALSE(problem->best.exists()) << "nothing is offered";
}

TEST(SequenceSearch, TheFirstSearchContinuesInEveryFourthRound) {
  std::string objects = "(:objects", init, goal;
  for (int i = 0; i < 12; ++i) {
    const std::string cup = " c" + std::to_string(i);
    objects += cup;
    init += " (dirty" + cup + ")";
    goal += " (clean" + cup + ")";
  }
  Prepared problem(kCups, objects + ") (:init (sink-free)" + init + ") (:goal (and" + goal + "))");
  SequenceSearch search(*problem, Cut::kNothing);
  std::uint64_t round = 0;
  while (round < 400 && !search.run({round, kShortTurn.units})) round += 4;
  EXPECT_TRUE(problem->best.exists());
  EXPECT_GT(round, 4u) << "no single turn is enough";
  SequenceSearch anew(*problem, Cut::kNothing);
  for (std::uint64_t other = 1; other < 40; other += 4) {
    const std::int64_t before = problem->budget.units();
    anew.run({other, kShortTurn.units});
    EXPECT_GT(problem->budget.units(), before);
    EXPECT_FALSE(anew.exhausted());
  }
}

TEST(SequenceSearch, APlanMayEndBeforeTheEventsThatBringAboutTheGoal) {
  // All work needs the lamp and the goal needs it out: no plan ends after the event that puts it out.
  std::string objects = "(:objects", init, goal;
  for (int i = 0; i < 6; ++i) {
    const std::string cup = " c" + std::to_string(i);
    objects += cup;
    init += " (dirty" + cup + ")";
    goal += " (clean" + cup + ")";
  }
  Prepared problem(
      R"((:predicates (lamp) (dirty ?c) (clean ?c))
    (:durative-action wash :parameters (?c) :duration (= ?duration 0.1) :condition (and (at start (dirty ?c)) (over all (lamp)))
     :effect (and (at start (not (dirty ?c))) (at end (clean ?c)))))",
      objects + ") (:init (at 2 (lamp)) (at 6 (not (lamp)))" + init + ") (:goal (and (not (lamp))" + goal + "))");
  SequenceSearch search(*problem, Cut::kNothing);
  EXPECT_TRUE(search.run(kTurn));
  EXPECT_EQ(problem->best.plan().steps.size(), 6u);
}

TEST(SequenceSearch, FindsPlansInWhichActionsOverlap) {
  for (const Cut cut : {Cut::kEnvelopes, Cut::kEverything}) {
    Prepared problem(kMatch, kOneMatch);
    SequenceSearch search(*problem, cut);
    EXPECT_TRUE(search.run(kTurn));
    EXPECT_NEAR(problem->best.plan().makespan_s, 5, 0.002);
    EXPECT_EQ(problem->best_parts().cut, search.space());
    EXPECT_EQ(problem->best_parts().list.size(), cut == Cut::kEnvelopes ? 3u : 4u)
        << "the match is struck and goes out; the mending is whole, or begins and ends";
    EXPECT_TRUE(problem->best_list().empty());
  }
}

TEST(SequenceSearch, CutsNothingWhereNoActionIsAnEnvelope) {
  Prepared problem(R"((:predicates (a) (b))
    (:durative-action make :parameters () :duration (= ?duration 2) :condition (at start (a)) :effect (at end (b))))",
                   "(:init (a)) (:goal (b))");
  SequenceSearch envelopes(*problem, Cut::kEnvelopes), everything(*problem, Cut::kEverything);
  EXPECT_FALSE(envelopes.run(kTurn));
  EXPECT_FALSE(envelopes.space());
  EXPECT_TRUE(envelopes.exhausted());
  EXPECT_TRUE(everything.run(kTurn));
}

TEST(SequenceSearch, LeavesWhatCannotBeCutWhole) {
  Prepared problem(kTank, kSeven);
  SequenceSearch everything(*problem, Cut::kEverything);
  EXPECT_FALSE(everything.space());
}

TEST(ClockStrategy, ChoosesADurationAtWhichANumberIsRight) {
  Prepared problem(kTank, kSeven);
  ClockStrategy clock(*problem);
  EXPECT_TRUE(clock.run(kTurn));
  EXPECT_NEAR(problem->best.plan().makespan_s, 3.5, 1e-6);
  EXPECT_FALSE(clock.exhausted());
  EXPECT_FALSE(clock.run({1, 20'000})) << "no plan is shorter";
}

TEST(ClockStrategy, HasNothingToDoWhereAllActionsCanBeCut) {
  Prepared problem(kMatch, kOneMatch);
  ClockStrategy clock(*problem);
  EXPECT_FALSE(clock.run(kTurn));
  EXPECT_TRUE(clock.exhausted());
}

TEST(LateRepair, MovesActionsUntilTheyComeInTime) {
  // `a` is served in time only as the first, `b` only as the first or the second.
  const std::string domain = R"((:predicates (waits ?p) (served ?p) (free) (here ?p))
    (:durative-action serve :parameters (?p) :duration (= ?duration 3)
     :condition (and (at start (waits ?p)) (at start (free)) (over all (here ?p)))
     :effect (and (at start (not (free))) (at end (free)) (at start (not (waits ?p))) (at end (served ?p)))))";
  Prepared problem(domain, R"((:objects c b a) (:init (free) (waits a) (waits b) (waits c) (here a) (here b) (here c)
    (at 4 (not (here a))) (at 8 (not (here b)))) (:goal (and (served c) (served b) (served a))))");
  SequenceSearch sequences(*problem, Cut::kNothing);
  ASSERT_TRUE(repair_late(*problem, sequences, {1, 20'000}));
  std::vector<std::string> order;
  for (const PlanStep& step : problem->best.plan().steps)
    order.push_back(problem.task().problem.objects[static_cast<std::size_t>(step.arguments[0])].name);
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_FALSE(problem->best_list().empty());
}

/// Each counter closes 3 s after the one before, and all could be served at the first one if time did not count.
TEST(LateRepair, ExchangesStepsThatComeTooLate) {
  constexpr int kPersons = 15;
  std::string persons, counters, init, goal;
  for (int i = 0; i < kPersons; ++i) {
    const std::string p = "p" + std::to_string(i), c = "c" + std::to_string(i);
    persons += " " + p;
    counters += " " + c;
    init += " (waits " + p + ") (open " + c + ") (at " + std::to_string(3.1 * (i + 1)) + " (not (open " + c + ")))";
    goal += " (served " + p + ")";
  }
  Prepared problem(
      R"((:types person counter) (:predicates (waits ?p - person) (served ?p - person) (free) (open ?c - counter))
    (:durative-action serve :parameters (?p - person ?c - counter) :duration (= ?duration 3)
     :condition (and (at start (waits ?p)) (at start (free)) (over all (open ?c)))
     :effect (and (at start (not (free))) (at end (free)) (at start (not (waits ?p))) (at end (served ?p)))))",
      "(:objects" + persons + " - person" + counters + " - counter) (:init (free)" + init + ") (:goal (and" + goal +
          "))");
  SequenceSearch sequences(*problem, Cut::kNothing);
  const std::int64_t before = problem->budget.units();
  ASSERT_TRUE(repair_late(*problem, sequences, {1, 20'000}));
  EXPECT_LT(problem->budget.units() - before, 8'000) << "random moves alone take twice as long";
}

TEST(LateRepair, GivesUpAfterItsTurns) {
  const std::string domain = R"((:predicates (light) (done))
    (:durative-action work :parameters () :duration (= ?duration 4) :condition (over all (light)) :effect (at end (done))))";
  Prepared problem(domain, "(:init (light) (at 3 (not (light)))) (:goal (done))");
  SequenceSearch sequences(*problem, Cut::kNothing);
  const std::int64_t before = problem->budget.units();
  EXPECT_FALSE(repair_late(*problem, sequences, {0, 5'000}));
  EXPECT_LT(problem->budget.units() - before, 3 * 5'000 + 1'000);
  EXPECT_FALSE(problem->budget.slice_over()) << "its slice is gone";
}

TEST(WarmStart, TakesWhatIsLeftOfAPlan) {
  Task task = parse(kCups, kTwoCups);
  const Plan plan = {{0, 0, {1}, 3, 0}, {0, 1, {0}, 5, 0}};  // sink b, hand a
  Prepared half(kCups, "(:objects a b) (:init (dirty a) (clean b) (sink-free)) (:goal (and (clean a) (clean b)))",
                {.warm_start = plan});
  EXPECT_TRUE(warm_start(*half, 10'000));
  ASSERT_EQ(half->best.plan().steps.size(), 1u);
  EXPECT_EQ(half->best.plan().steps[0].action, 1) << "by hand, as in the plan, though the sink is faster";
}

TEST(WarmStart, ASearchFillsInWhatIsMissing) {
  const Plan plan = {{0, 1, {0}, 5, 0}};  // only a
  Prepared problem(kCups, kTwoCups, {.warm_start = plan});
  EXPECT_TRUE(warm_start(*problem, 10'000));
  EXPECT_EQ(problem->best.plan().steps.size(), 2u);
  Prepared without_units(kCups, kTwoCups, {.warm_start = plan});
  EXPECT_FALSE(warm_start(*without_units, 0));
}

TEST(WarmStart, NeedsAPlan) {
  Prepared none(kCups, kTwoCups);
  EXPECT_FALSE(warm_start(*none, 10'000));
}

TEST(WarmStart, ExchangesAStepThatComesTooLate) {
  const std::string init = "(:objects a) (:init (dirty a) (sink-free) (at 4 (not (sink-free)))) (:goal (clean a))";
  Prepared in_time(kCups, init, {.warm_start = {{0, 1, {0}, 5, 0}}});
  EXPECT_TRUE(warm_start(*in_time, 10'000));
  EXPECT_EQ(in_time->best.plan().steps[0].action, 1) << "as in the plan";

  const std::string closes = "(:objects a) (:init (dirty a) (sink-free) (at 2 (not (sink-free)))) (:goal (clean a))";
  Prepared late(kCups, closes, {.warm_start = {{0, 0, {0}, 3, 0}}});
  EXPECT_TRUE(warm_start(*late, 10'000));
  EXPECT_EQ(late->best.plan().steps[0].action, 1) << "the sink is free for too short a time";
  Prepared without_units(kCups, closes, {.warm_start = {{0, 0, {0}, 3, 0}}});
  EXPECT_FALSE(warm_start(*without_units, 0));
}

TEST(ProveUnsolvable, NeedsNoSearchWithoutDurations) {
  Prepared problem(
      "(:predicates (key) (a) (b)) (:action a :parameters () :precondition (key) :effect (a)) (:action b "
      ":parameters () :precondition (key) :effect (b))",
      "(:init (key)) (:goal (and (a) (b)))");
  EXPECT_EQ(prove_unsolvable(*problem).status, PlanStatus::kUnsolvable);
}

TEST(ProveUnsolvable, LooksForAnyOrderOfHappenings) {
  // Each of two actions needs two of three tokens and keeps them.
  const std::string domain = R"((:predicates (token ?t) (a) (b))
    (:durative-action make-a :parameters (?s ?t) :duration (= ?duration 2)
     :condition (and (at start (token ?s)) (at start (token ?t)) (at start (not (= ?s ?t))))
     :effect (and (at start (not (token ?s))) (at start (not (token ?t))) (at end (a))))
    (:durative-action make-b :parameters (?s ?t) :duration (= ?duration 3)
     :condition (and (at start (token ?s)) (at start (token ?t)) (at start (not (= ?s ?t))))
     :effect (and (at start (not (token ?s))) (at start (not (token ?t))) (at end (b)))))";
  Prepared impossible(domain, "(:objects x y z) (:init (token x) (token y) (token z)) (:goal (and (a) (b)))");
  const Conclusion proof = prove_unsolvable(*impossible);
  EXPECT_EQ(proof.status, PlanStatus::kUnsolvable) << proof.reason;
  Prepared possible(domain, "(:objects w x y z) (:init (token w) (token x) (token y) (token z)) (:goal (and (a) (b)))");
  EXPECT_EQ(prove_unsolvable(*possible).status, PlanStatus::kEnded) << "an order exists: nothing is proved";
}

TEST(ProveUnsolvable, ProvesNothingWhereAnActionCannotBeCut) {
  Prepared problem(kTank, kSeven);
  EXPECT_EQ(prove_unsolvable(*problem).status, PlanStatus::kEnded);
}

/// Each of five copies at once counts when it ends, unless it began after the break: then all is lost.
constexpr const char* kHolds = R"((:predicates (open) (broken) (lost)) (:functions (count))
  (:durative-action hold :parameters () :duration (= ?duration 10)
   :condition (and (at start (open)) (at end (not (lost))))
   :effect (and (at end (increase (count) 1)) (when (CONDITION (broken)) (at end (lost)))))
  (:action break :parameters () :precondition (open) :effect (broken)))";

std::string holds(const std::string& condition) {
  std::string domain = kHolds;
  return domain.replace(domain.find("CONDITION"), 9, condition);
}

/// The proof follows a few copies only; what the others remember of their start it does not know.
TEST(HappeningStrategy, ProvesNothingWhereCopiesThatAreNotFollowedDependOnTheirBeginning) {
  for (const char* condition : {"at start", "over all"}) {
    Prepared problem(holds(condition),
                     "(:init (open) (= (count) 0) (at 5 (not (open)))) (:goal (and (>= (count) 5) (not (lost))))");
    HappeningStrategy strategy(*problem, false);
    for (std::uint64_t round = 0; round < 100 && !strategy.has_ended_proof(); ++round)
      EXPECT_FALSE(strategy.prove({round, 20'000})) << condition;
    EXPECT_TRUE(strategy.has_ended_proof()) << condition;
  }
}

/// Its end alone decides: where that is known, it is a proof.
TEST(HappeningStrategy, ProvesThatCopiesWhoseEndsLoseAllNeverCount) {
  Prepared problem(holds("at end"), "(:init (open) (broken) (= (count) 0)) (:goal (and (>= (count) 5) (not (lost))))");
  HappeningStrategy strategy(*problem, false);
  bool proved = false;
  for (std::uint64_t round = 0; round < 100 && !strategy.has_ended_proof(); ++round)
    proved = strategy.prove({round, 20'000});
  EXPECT_TRUE(proved);
}

/// 0 / 0 until the divisor is raised. The validator refuses what is done before.
TEST(HappeningStrategy, RatesAndConditionsThatAreNoNumbersRuleOutTheirActions) {
  for (const char* action :
       {":duration (= ?duration 3) :condition () :effect (and (at end (done)) (increase (x) (* #t (/ (a) (b)))))",
        ":duration (= ?duration 3) :condition (at start (>= (/ (a) (b)) 0)) :effect (at end (done))",
        ":duration (= ?duration 3) :condition (at end (not (< (/ (a) (b)) 0))) :effect (at end (done))",
        ":duration (= ?duration 3) :condition () :effect (when (at start (>= (/ (a) (b)) 0)) (at end (done)))",
        ":duration (= ?duration 3) :condition () :effect (when (over all (= (/ (a) (b)) 0)) (at end (done)))",
        ":duration (= ?duration 3) :condition () :effect (when (at end (<= (/ (a) (b)) 0)) (at end (done)))"}) {
    // What a rate changes is read by the goal, or by another way to it that leads nowhere.
    for (const char* goal : {"(and (done) (not (< (x) 0)))", "(done)"}) {
      Prepared problem(
          "(:predicates (done)) (:functions (x) (a) (b)) (:action raise :parameters () :effect (increase (b) 1)) "
          "(:action other :parameters () :precondition (>= (x) 5) :effect (done)) (:durative-action flow :parameters "
          "() " +
              std::string(action) + ")",
          "(:init (= (x) 0) (= (a) 0) (= (b) 0)) (:goal " + std::string(goal) + ")");
      HappeningStrategy strategy(*problem, false);
      for (std::uint64_t round = 0; round < 20 && !problem->best.exists(); ++round) strategy.run({round, 20'000});
      ASSERT_TRUE(problem->best.exists()) << action << goal;
      PlanAnswer answer;
      std::move(problem->best).report(answer);
      EXPECT_GE(answer.plan->steps.size(), 2u) << action << goal;
      EXPECT_EQ(answer.refused, 0) << answer.refusal;
    }
  }
}

/// Beyond, it would take long and find little.
TEST(HappeningStrategy, SearchesSmallProblemsInWhichTimesCount) {
  const auto searches = [](int lamps, const std::string& action, bool better) {
    std::string objects;
    for (int i = 0; i < lamps; ++i) objects += " l" + std::to_string(i);
    Prepared problem("(:predicates (on ?l)) " + action,
                     "(:objects" + objects + ") (:init) (:goal (exists (?l) (on ?l)))");
    EXPECT_EQ(problem->ground.actions.size(), static_cast<std::size_t>(lamps));
    HappeningStrategy strategy(*problem, better);
    const std::int64_t units = problem->budget.units();
    strategy.run(kTurn);
    return problem->budget.units() > units;
  };
  const std::string light =
      "(:durative-action light :parameters (?l) :duration (= ?duration 1) :condition () :effect (at end (on ?l)))";
  EXPECT_TRUE(searches(200, light, false));
  EXPECT_FALSE(searches(201, light, false));
  EXPECT_TRUE(searches(40, light, true));
  EXPECT_FALSE(searches(41, light, true));
  EXPECT_FALSE(searches(1, "(:action light :parameters (?l) :effect (on ?l))", false));
}

/// Water runs into a tank, which is looked at once. Whether it holds less than 3, 3 or more is chosen by the time.
TEST(HappeningStrategy, AnEffectWithAConditionOnANumberInMotionDecidesWhenItsActionIs) {
  const std::string domain =
      "(:predicates (runs) (fresh) (low) (right) (high)) (:functions (level)) (:durative-action run :parameters () "
      ":duration (= ?duration 4) :condition (at start (fresh)) :effect (and (at start (runs)) (at start (not (fresh))) "
      "(at end (not (runs))) (increase (level) (* #t 1)))) (:action look :parameters () :precondition (runs) :effect "
      "(and (when (< (level) 3) (low)) (when (= (level) 3) (right)) (when (> (level) 3) (high))))";
  for (const auto& [goal, from, to] : {std::tuple("low", 0.0, 3.0), {"right", 3.0, 3.0}, {"high", 3.0, 4.0}}) {
    Prepared problem(domain, "(:init (fresh) (= (level) 0)) (:goal (" + std::string(goal) + "))");
    HappeningStrategy strategy(*problem, false);
    for (std::uint64_t round = 0; round < 20 && !strategy.exhausted() && !problem->best.exists(); ++round)
      strategy.run({round, 20'000});
    ASSERT_TRUE(problem->best.exists()) << goal;
    const std::vector<PlanStep> steps = problem->best.plan().steps;
    ASSERT_EQ(steps.size(), 2u);
    const double time = std::abs(steps[1].start - steps[0].start);
    EXPECT_GE(time, from) << goal;
    EXPECT_LE(time, to) << goal;
  }
}

/// Water runs into a tank, one vessel is poured in soon, and the valve opens for a moment later: with one of the
/// vessels, the level is right then.
TEST(HappeningStrategy, MomentsThatDifferInANumberThatIsInMotionAreNotOne) {
  for (const auto& sizes : {std::vector{7, 6, 3, 5}, {3, 7, 6, 5}, {6, 5, 7, 3}, {5, 3, 6, 7}}) {
    std::string objects, init;
    for (const int size : sizes) {
      objects += " v" + std::to_string(size);
      init += " (= (size v" + std::to_string(size) + ") " + std::to_string(size) + ")";
    }
    Prepared problem(
        "(:predicates (early) (soon) (runs) (full ?v) (open) (shut)) (:functions (level) (size ?v)) (:durative-action "
        "run "
        ":parameters () :duration (= ?duration 4) :condition (at start (early)) :effect (and (at start (runs)) (at "
        "start "
        "(not (early))) (at end (not (runs))) (increase (level) (* #t 1)))) (:action pour :parameters (?v) "
        ":precondition (and (runs) (soon) "
        "(full ?v)) :effect (and (forall (?w) (not (full ?w))) (increase (level) (size ?v)))) (:action close "
        ":parameters () "
        ":precondition (and (open) (>= (level) 5) (<= (level) 5.4)) :effect (shut))",
        "(:objects" + objects + ") (:init (early) (soon) (= (level) 0)" + init +
            " (full v3) (full v5) (full v6) (full v7) (at 0.5 (not (early))) (at 1 (not (soon))) (at 2 (open)) (at 2.2 "
            "(not (open)))) "
            "(:goal (shut))");
    HappeningStrategy strategy(*problem, false);
    for (std::uint64_t round = 0; round < 20 && !strategy.exhausted() && !problem->best.exists(); ++round)
      strategy.run({round, 20'000});
    EXPECT_TRUE(problem->best.exists()) << init;
  }
}

TEST(HappeningStrategy, MomentsThatDifferOnlyInUnreadCostsAreOneUntilPlansAreCompared) {
  // Three tiles on a ring of four places only go round: two of them never change their order.
  Prepared ring(R"((:predicates (at ?t ?p) (empty ?p) (next ?p ?q)) (:functions (total-cost))
    (:durative-action slide :parameters (?t ?p ?q) :duration (= ?duration 1)
     :condition (and (at start (at ?t ?p)) (at start (empty ?q)) (at start (next ?p ?q)))
     :effect (and (at end (at ?t ?q)) (at end (empty ?p)) (at start (not (at ?t ?p))) (at start (not (empty ?q)))
      (at end (increase (total-cost) 1)))))",
                R"((:objects a b c n e s w) (:init (at a n) (at b e) (at c s) (empty w) (= (total-cost) 0)
     (next n e) (next e s) (next s w) (next w n) (next e n) (next s e) (next w s) (next n w))
    (:goal (and (at b n) (at a e) (at c s))) (:metric minimize (total-cost)))");
  HappeningStrategy first(*ring, false);
  EXPECT_FALSE(first.run({0, 50'000}));
  EXPECT_TRUE(first.exhausted());

  // Equally long ways to the same place, in any order: the last one may be the cheapest.
  for (const auto& costs : {std::vector{9, 4, 1}, {9, 1, 4}, {4, 9, 1}, {4, 1, 9}, {1, 9, 4}, {1, 4, 9}}) {
    std::string ways = "(:functions (cost)) (:predicates (home) (there) (done))\n";
    for (const int cost : costs)
      ways += "(:durative-action go-" + std::to_string(cost) +
              " :parameters () :duration (= ?duration 2) :condition (at start (home)) :effect (and (at start (not "
              "(home))) (at end (there)) (at end (increase (cost) " +
              std::to_string(cost) + "))))\n";
    Prepared trip(ways + "(:action look :parameters () :precondition (there) :effect (done))",
                  "(:init (home) (= (cost) 0)) (:goal (done)) (:metric minimize (cost))");
    ASSERT_TRUE(trip->offer(trip->whole, trip.list({"(go-9)", "(look)"})));
    HappeningStrategy better(*trip, true);
    for (std::uint64_t round = 0; round < 20 && !better.exhausted(); ++round) better.run({round, 20'000});
    EXPECT_TRUE(better.exhausted());
    EXPECT_EQ(trip->best.cost(), 1) << ways;
  }
}

}  // namespace
}  // namespace cxlab::planner
