// Times of happenings: earliest schedules and temporal networks.

#include <gtest/gtest.h>

#include "planner/ground/ground.h"
#include "planner/pddl/parser.h"
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
  Expected<Problem> problem = parse_problem("(define (problem p) (:domain d) (:init (free)) (:goal (and (used) (seen))))", "problem", *domain);
  EXPECT_TRUE(problem);
  Expected<GroundTask> task = ground({std::move(*domain), std::move(*problem)});
  EXPECT_TRUE(task);
  return std::move(*task);
}

constexpr Micros kSecond = kMicrosPerSecond;

TEST(Timeline, WhatNeedsAFactWaitsUntilItIsBack) {
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

TEST(Stn, AgreesWithTheTimeline) {
  const GroundTask task = machine();
  const Touches touches(task);
  Stn stn(touches);
  for (const int action : {0, 1}) stn.finish(stn.begin(action, {(action == 0 ? 4 : 2) * kSecond, (action == 0 ? 4 : 3) * kSecond}));
  ASSERT_TRUE(stn.solve(kSeparation));
  EXPECT_EQ(stn.start(1), 4 * kSecond + kSeparation);
  EXPECT_EQ(stn.makespan(), 6 * kSecond + kSeparation);
  ASSERT_EQ(stn.orderings().size(), 3u);  // two durations, and the end of `use` before the start of `watch`
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
