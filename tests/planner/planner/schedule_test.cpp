// Times of happenings: earliest schedules and temporal networks; searches in slices.

#include <gtest/gtest.h>

#include <cmath>

#include "planner/ground/ground.h"
#include "planner/pddl/parser.h"
#include "planner/search/clock.h"
#include "planner/search/search_space.h"
#include "planner/search/simulator.h"
#include "planner/search/split.h"

namespace cxlab::planner {
namespace {

/// Two actions on one machine: `use` needs it for itself, `watch` needs it to be free all along.
GroundTask machine() {
  Expected<Domain> domain = parse_domain(R"((define (domain d) (:requirements :durative-actions)
    (:predicates (free) (used) (seen))
    (:durative-action use :parameters () :duration (= ?duration 4) :condition (at start (free))
     :effect (and (at start (not (free))) (at end (free)) (at end (used))))
    (:durative-action watch :parameters () :duration (and (>= ?duration 2) (<= ?duration 3)) :condition (over all (free)) :effect (at end (seen)))))",
                                         "domain");
  EXPECT_TRUE(domain);
  Expected<Problem> problem =
      parse_problem("(define (problem p) (:domain d) (:init (free)) (:goal (and (used) (seen))))", "problem", *domain);
  EXPECT_TRUE(problem);
  Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  EXPECT_TRUE(task);
  return std::move(*task);
}

constexpr Micros kSecond = kMicrosPerSecond;

TEST(Timeline, AnActionWaitsUntilTheFactThatItNeedsIsTrueAgain) {
  const GroundTask task = machine();
  const Touches touches(task);
  Timeline timeline(touches);
  EXPECT_EQ(timeline.append(0, 4 * kSecond), 0);
  EXPECT_EQ(timeline.append(1, 2 * kSecond), 4 * kSecond + kSeparation);
  EXPECT_EQ(timeline.cause(), 0);
  EXPECT_EQ(timeline.makespan(), 6 * kSecond + kSeparation);
}

TEST(Timeline, TheOrderOfTheSequenceIsKept) {
  const GroundTask task = machine();
  const Touches touches(task);
  Timeline timeline(touches);
  timeline.append(1, 2 * kSecond);
  EXPECT_EQ(timeline.append(0, 4 * kSecond), 2 * kSecond + kSeparation);
}

TEST(Timeline, IncreasesMayHappenTogetherAndAssignmentsNot) {
  for (const auto& [effect, apart] : {std::pair{"increase", false}, {"decrease", false}, {"assign", true}}) {
    Expected<Domain> domain = parse_domain(
        std::string("(define (domain d) (:requirements :durative-actions) (:functions (n)) (:predicates (a) (b)) ") +
            "(:durative-action one :parameters () :duration (= ?duration 4) :condition () :effect (and (at end (a)) "
            "(at end (" +
            effect + " (n) 1)))) (:durative-action two :parameters () :duration (= ?duration 4) :condition () " +
            ":effect (and (at end (b)) (at end (" + effect + " (n) 1)))))",
        "domain");
    ASSERT_TRUE(domain);
    Expected<Problem> problem = parse_problem(
        "(define (problem p) (:domain d) (:init (= (n) 0)) (:goal (and (a) (b) (> (n) 0))))", "problem", *domain);
    ASSERT_TRUE(problem);
    const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
    ASSERT_TRUE(task);
    const Touches touches(*task);
    Timeline timeline(touches);
    EXPECT_EQ(timeline.append(0, 4 * kSecond), 0) << effect;
    EXPECT_EQ(timeline.append(1, 4 * kSecond), apart ? kSeparation : 0) << effect;
  }
}

TEST(Timeline, WhatReadsAFactIsOverBeforeAnEventDeletesIt) {
  Expected<Domain> domain =
      parse_domain(R"((define (domain d) (:requirements :durative-actions) (:predicates (open) (in))
    (:durative-action enter :parameters () :duration (and (>= ?duration 1) (<= ?duration 9)) :condition (at end (open)) :effect (at end (in)))))",
                   "domain");
  ASSERT_TRUE(domain);
  Expected<Problem> problem = parse_problem(
      "(define (problem p) (:domain d) (:init (open) (at 5 (not (open)))) (:goal (in)))", "problem", *domain);
  ASSERT_TRUE(problem);
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task);
  const Touches touches(*task);
  Timeline timeline(touches);
  EXPECT_EQ(timeline.append(0, 5 * kSecond), Timeline::kNever);
  timeline.clear();
  EXPECT_EQ(timeline.append(0, 5 * kSecond - kSeparation), 0);
}

TEST(Timeline, AGoalMayEndAsSoonAsThePlanIsOver) {
  for (const auto& [ends, is_kept] : {std::pair{"4.002", true}, {"4.001001", true}, {"4.001", false}, {"4", false}}) {
    Expected<Domain> domain =
        parse_domain(R"((define (domain d) (:requirements :durative-actions) (:predicates (light) (in))
    (:durative-action enter :parameters () :duration (= ?duration 4) :condition () :effect (at end (in)))))",
                     "domain");
    ASSERT_TRUE(domain);
    Expected<Problem> problem = parse_problem("(define (problem p) (:domain d) (:init (light) (at " +
                                                  std::string(ends) + " (not (light)))) (:goal (and (in) (light))))",
                                              "problem", *domain);
    ASSERT_TRUE(problem);
    const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
    ASSERT_TRUE(task);
    const Touches touches(*task);
    Timeline timeline(touches);
    ASSERT_EQ(timeline.append(0, 4 * kSecond), 0) << ends;
    EXPECT_EQ(timeline.finish(), is_kept) << ends;
  }
}

TEST(Timeline, EachEventThatComesTooEarlyForTheGoalAddsToTheLateness) {
  Expected<Domain> domain =
      parse_domain(R"((define (domain d) (:requirements :durative-actions) (:predicates (light) (warm) (in))
    (:durative-action enter :parameters () :duration (= ?duration 4) :condition () :effect (at end (in)))))",
                   "domain");
  ASSERT_TRUE(domain);
  Expected<Problem> problem = parse_problem(
      "(define (problem p) (:domain d) (:init (light) (warm) (at 1 (not (light))) (at 3 (not (warm)))) (:goal (and "
      "(in) "
      "(light) (warm))))",
      "problem", *domain);
  ASSERT_TRUE(problem);
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task);
  const Touches touches(*task);
  Timeline timeline(touches, true);
  ASSERT_EQ(timeline.append(0, 4 * kSecond), 0);
  EXPECT_TRUE(timeline.finish());
  EXPECT_EQ(timeline.lateness(), (3 + 1) * kSecond + 2 * kSeparation);
}

/// How a search along the clock ends that takes the first plan which ends before `before`.
SearchEnd search_along_the_clock(const std::string& domain_body, const std::string& problem_body,
                                 Micros before = DurationRange::kForever) {
  Expected<Domain> domain =
      parse_domain("(define (domain d) (:requirements :adl :durative-actions :fluents)" + domain_body + ")", "domain");
  EXPECT_TRUE(domain) << domain.error().text();
  Expected<Problem> problem = parse_problem("(define (problem p) (:domain d)" + problem_body + ")", "problem", *domain);
  EXPECT_TRUE(problem) << problem.error().text();
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  EXPECT_TRUE(task);
  const Simulator simulator(*task);
  const Touches touches(*task);
  ClockSearch search(*task, simulator, touches);
  Budget budget;
  return search.run({}, before, budget, [](const std::vector<ClockStep>&) { return true; });
}

TEST(ClockSearch, WhatHeldWhenARunningActionBeganTellsStatesApart) {
  // `one` and `other` lead to the same state, but for what `burn` has seen when it began.
  const std::string one =
      "(:action one :parameters () :precondition (fresh) :effect (and (not (fresh)) (ready) (seen)))";
  const std::string other = "(:action other :parameters () :precondition (fresh) :effect (and (not (fresh)) (ready)))";
  for (const std::string& actions : {one + other, other + one})
    for (const char* seen : {"(seen)", "(not (seen))"})
      for (const bool gives : {true, false})
        EXPECT_EQ(search_along_the_clock(actions + R"((:predicates (fresh) (ready) (seen) (good) (done))
              (:durative-action burn :parameters () :duration (= ?duration 10) :condition (at start (ready))
               :effect (and (at start (not (ready))) (at end (done)) (when (at start )" +
                                             seen + ") (at end " + (gives ? "(good)" : "(not (good))") + "))))",
                                         std::string("(:init (fresh) (at 1 (seen))") + (gives ? "" : " (good)") +
                                             ") (:goal (and (done) (good)))"),
                  SearchEnd::kFound)
            << actions << seen << gives;
}

TEST(ClockSearch, APlanEndsBeforeTheGivenTime) {
  for (const Micros more : {-1, 0, 1})
    EXPECT_EQ(
        search_along_the_clock("(:predicates (a) (b)) (:action first :parameters () :precondition () :effect (a)) "
                               "(:action second :parameters () :precondition (a) :effect (b))",
                               "(:init) (:goal (b))", kSeparation + more) == SearchEnd::kFound,
        more == 1)
        << "the second action is at the separation: " << more;
}

TEST(Simulator, TheEndNeedsWhatTheBeginningDidOnlyIfASeparationIsBetween) {
  Expected<Domain> domain = parse_domain(
      R"((define (domain d) (:requirements :durative-actions :fluents) (:predicates (seen)) (:functions (lamps))
    (:durative-action look :parameters () :duration (and (>= ?duration 0) (<= ?duration 9)) :condition (at end (>= (lamps) 1))
     :effect (and (at start (increase (lamps) 1)) (at end (seen))))))",
      "domain");
  ASSERT_TRUE(domain) << domain.error().text();
  Expected<Problem> problem =
      parse_problem("(define (problem p) (:domain d) (:init (= (lamps) 0)) (:goal (seen)))", "problem", *domain);
  ASSERT_TRUE(problem) << problem.error().text();
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task);
  const Simulator simulator(*task);
  for (const Micros more : {-1, 0, 1}) {
    PackedState state = simulator.initial();
    EXPECT_EQ(simulator.apply_with(0, state.data(), kSeparation + more), more >= 0) << more;
  }
}

TEST(Numbers, ZeroHasOneForm) {
  for (const auto& [kind, by] : {std::pair{NumericEffect::Kind::kScale, -1.0},
                                 {NumericEffect::Kind::kDivide, -1.0},
                                 {NumericEffect::Kind::kAssign, -0.0},
                                 {NumericEffect::Kind::kIncrease, -0.0}}) {
    double number = kind == NumericEffect::Kind::kIncrease ? -0.0 : 0.0;
    change(number, kind, by);
    EXPECT_EQ(number, 0);
    EXPECT_FALSE(std::signbit(number)) << static_cast<int>(kind) << ": equal states have equal bits";
  }
}

TEST(Stn, AgreesWithTheTimeline) {
  const GroundTask task = machine();
  const Touches touches(task);
  Stn stn(touches);
  for (const int action : {0, 1})
    stn.finish(stn.begin(action, {(action == 0 ? 4 : 2) * kSecond, (action == 0 ? 4 : 3) * kSecond}));
  ASSERT_TRUE(stn.solve(kSeparation));
  EXPECT_EQ(stn.start(1), 4 * kSecond + kSeparation);
  EXPECT_EQ(stn.makespan(), 6 * kSecond + kSeparation);
  ASSERT_EQ(stn.orderings().size(), 3u);  // two durations, and the end of `use` before the start of `watch`
}

TEST(Stn, ALongChainAgreesWithTheTimelineAndNeedsFewDistances) {
  const GroundTask task = machine();
  const Touches touches(task);
  Stn stn(touches);
  Timeline timeline(touches);
  std::vector<Micros> starts;
  for (int i = 0; i < 60; ++i) {
    const int action = i % 5 == 4 || i % 7 == 3;  // now and then two or more watch in turn
    const Micros duration = (action == 0 ? 4 : 2) * kSecond;
    stn.finish(stn.begin(action, {duration, (action == 0 ? 4 : 3) * kSecond}));
    starts.push_back(timeline.append(action, duration));
  }
  ASSERT_TRUE(stn.solve(kSeparation));
  for (int i = 0; i < 60; ++i) EXPECT_EQ(stn.start(i), starts.at(static_cast<std::size_t>(i))) << i;
  EXPECT_LT(stn.distances(), 400u);  // of 5,576 pairs that conflict
}

TEST(Stn, ARunningActionNeedNotKeepClearOfItself) {
  Expected<Domain> domain = parse_domain(R"((define (domain d) (:requirements :durative-actions)
    (:predicates (free) (used) (open) (done))
    (:durative-action blink :parameters () :duration (>= ?duration 0.0005) :condition (at start (free))
     :effect (and (at start (not (free))) (at end (free)) (at end (used))))
    (:durative-action shut :parameters () :duration (= ?duration 1) :condition (over all (open))
     :effect (and (at end (not (open))) (at end (done))))))",
                                         "domain");
  ASSERT_TRUE(domain);
  Expected<Problem> problem = parse_problem(
      "(define (problem p) (:domain d) (:init (free) (open)) (:goal (and (used) (done))))", "problem", *domain);
  ASSERT_TRUE(problem);
  Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task);
  ASSERT_EQ(task->actions.size(), 2u);
  const Touches touches(*task);
  for (const auto& [action, lasts] : {std::pair{0, Micros{500}}, {1, kSecond}}) {
    Stn stn(touches);
    const int step = stn.begin(action, {lasts, lasts});
    EXPECT_TRUE(stn.solve(kSeparation)) << action;
    stn.finish(step);
    ASSERT_TRUE(stn.solve(kSeparation)) << action;
    EXPECT_EQ(stn.makespan(), lasts);
  }
}

TEST(LazySearch, AStateIsAnotherOneAfterItsEvents) {
  // The door is open at the beginning and once again later: only then is there time to go in.
  Expected<Domain> domain =
      parse_domain(R"((define (domain d) (:requirements :durative-actions) (:predicates (open) (in))
    (:durative-action enter :parameters () :duration (= ?duration 20) :condition (over all (open)) :effect (at end (in)))))",
                   "domain");
  ASSERT_TRUE(domain);
  Expected<Problem> problem =
      parse_problem("(define (problem p) (:domain d) (:init (open) (at 5 (not (open))) (at 10 (open))) (:goal (in)))",
                    "problem", *domain);
  ASSERT_TRUE(problem);
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task);
  Budget budget;
  const SearchSpace space(*task, budget);
  const Touches touches(*task);
  EventCheck check(touches);
  LazySearch search(space.simulator, space.relaxed, space.landmarks, space.simulator.initial(), {}, &check);
  Sequence found;
  ASSERT_EQ(search.run(budget, found), SearchEnd::kFound);
  ASSERT_EQ(found.size(), 3);
  EXPECT_TRUE(is_event(found[0]) && is_event(found[1]) && !is_event(found[2]));
}

TEST(LazySearch, ContinuesWhereItsLastSliceEnded) {
  // Five tiles on a board of two by three, two of them the wrong way round: all of 360 states are looked at.
  Expected<Domain> domain = parse_domain(R"((define (domain d) (:predicates (at ?t ?p) (empty ?p) (next ?p ?q))
    (:action slide :parameters (?t ?p ?q) :precondition (and (at ?t ?p) (empty ?q) (next ?p ?q))
     :effect (and (at ?t ?q) (empty ?p) (not (at ?t ?p)) (not (empty ?q))))))",
                                         "domain");
  ASSERT_TRUE(domain);
  Expected<Problem> problem = parse_problem(R"((define (problem p) (:domain d) (:objects a b c d e p1 p2 p3 p4 p5 p6)
    (:init (at a p1) (at b p2) (at c p3) (at d p4) (at e p5) (empty p6)
     (next p1 p2) (next p2 p1) (next p2 p3) (next p3 p2) (next p4 p5) (next p5 p4) (next p5 p6) (next p6 p5)
     (next p1 p4) (next p4 p1) (next p2 p5) (next p5 p2) (next p3 p6) (next p6 p3))
    (:goal (and (at b p1) (at a p2) (at c p3) (at d p4) (at e p5)))))",
                                            "problem", *domain);
  ASSERT_TRUE(problem);
  const Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  ASSERT_TRUE(task && !task->proved_unsolvable);
  Budget making, whole, sliced;
  const SearchSpace space(*task, making);
  Sequence found;
  const auto make = [&] {
    return LazySearch(space.simulator, space.relaxed, space.landmarks, space.simulator.initial(), {});
  };
  LazySearch at_once = make(), in_slices = make();
  ASSERT_EQ(at_once.run(whole, found), SearchEnd::kExhausted);
  int slices = 0;
  for (SearchEnd end = SearchEnd::kBudget; end == SearchEnd::kBudget && slices < 20; ++slices) {
    const BudgetSlice slice(sliced, whole.units() / 10);
    end = in_slices.run(sliced, found);
  }
  EXPECT_GT(slices, 5);
  EXPECT_LT(slices, 20);
  EXPECT_EQ(sliced.units(), whole.units());
}

TEST(Split, PartsOfAnActionRunOnce) {
  const GroundTask task = machine();
  const SplitTask cut = split(task, {1, 0});
  ASSERT_EQ(cut.task.actions.size(), 3u);
  const Simulator simulator(cut.task);
  PackedState state = simulator.initial();
  Micros duration = 0;
  EXPECT_FALSE(simulator.apply(1, state.data(), duration)) << "ends before it has begun";
  EXPECT_TRUE(simulator.apply(0, state.data(), duration));
  EXPECT_FALSE(simulator.apply(0, state.data(), duration)) << "begins twice";
  EXPECT_TRUE(simulator.apply(1, state.data(), duration));
}

}  // namespace
}  // namespace cxlab::planner
