#include "sim/traffic/traffic.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cx/base/random.h"

namespace cxlab::sim::traffic_test {
namespace {

constexpr SimTime kTick{20'000'000};
constexpr RobotId kRobot1{0}, kRobot2{1}, kRobot3{2};

FloorPlan open_floor(std::vector<Pose2> robots) {
  FloorPlan plan;
  for (std::size_t i = 0; i < robots.size(); ++i) plan.robots.push_back({"robot" + std::to_string(i + 1), robots[i]});
  return plan;
}

/// Robots that are always exactly where their motion says.
class Drivers {
 public:
  explicit Drivers(const FloorPlan& plan) : traffic(plan), size_(static_cast<int>(plan.robots.size())) {
    for (const RobotStart& start : plan.robots) poses_.push_back(start.pose_in_world);
  }

  void tick() {
    now += kTick;
    traffic.settle(now);
    for (int i = 0; i < size_; ++i) {
      const auto id = static_cast<RobotId>(i);
      if (traffic.motion(id)) poses_[static_cast<std::size_t>(i)] = traffic.motion(id)->at(now);
      traffic.observe(id, pose(id), now);
    }
    traffic.plan(now);
    for (int i = 0; i < size_; ++i) {
      const auto id = static_cast<RobotId>(i);
      least_clearance = std::min(least_clearance, traffic.clearance(pose(id).position()));
      for (int k = 0; k < i; ++k)
        least_distance =
            std::min(least_distance, distance(pose(id).position(), pose(static_cast<RobotId>(k)).position()));
    }
  }
  /// Until the condition holds; the seconds it took, or more than `limit`.
  template <class Condition>
  double until(Condition condition, double limit = 120) {
    const SimTime begin = now;
    while (!condition() && now - begin <= from_seconds(limit)) tick();
    return to_seconds(now - begin);
  }
  const Pose2& pose(RobotId id) const { return poses_[static_cast<std::size_t>(id)]; }
  void push(RobotId id, const Pose2& to) { poses_[static_cast<std::size_t>(id)] = to; }

  Traffic traffic;
  SimTime now{};
  double least_distance = 100, least_clearance = 100;

 private:
  int size_;
  std::vector<Pose2> poses_;
};

TEST(Traffic, AFreeDriveIsStraightAndFast) {
  Drivers floor(open_floor({{-6, 4, 0}}));
  floor.traffic.request(kRobot1, {6, 4, std::numbers::pi / 2}, {}, floor.now);
  const double took = floor.until([&] { return floor.traffic.arrived(kRobot1); });
  EXPECT_LT(took, 12 / DriveLimits{}.speed + 2);
  EXPECT_NEAR(floor.pose(kRobot1).x, 6, 1e-9);
  EXPECT_NEAR(floor.pose(kRobot1).yaw, std::numbers::pi / 2, 1e-9);
}

TEST(Traffic, ASlowRobotTakesLongerAlsoWhenItWasUnderWay) {
  Drivers floor(open_floor({{-6, 4, 0}}));
  floor.traffic.set_speed(kRobot1, 0.5, floor.now);
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  const auto arrived = [&] { return floor.traffic.arrived(kRobot1); };
  const double whole = 6 / DriveLimits{}.speed;
  EXPECT_NEAR(floor.until(arrived), 2 * whole, 3);
  floor.traffic.set_speed(kRobot1, 1, floor.now);
  floor.traffic.request(kRobot1, {6, 4, 0}, {}, floor.now);
  EXPECT_GT(floor.until([&] { return floor.pose(kRobot1).x > 3; }), whole / 2);
  floor.traffic.set_speed(kRobot1, 0.25, floor.now);
  EXPECT_NEAR(floor.until(arrived), 4 * whole / 2, 6);
}

TEST(Traffic, AHaltedRobotStandsAndGoesOnLater) {
  Drivers floor(open_floor({{-6, 4, 0}}));
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  (void)floor.until([&] { return floor.pose(kRobot1).x > -3; });
  floor.traffic.set_speed(kRobot1, 0, floor.now);
  (void)floor.until([] { return false; }, 3);
  const double stands_at = floor.pose(kRobot1).x;
  EXPECT_LT(stands_at, -2);
  (void)floor.until([] { return false; }, 20);
  EXPECT_EQ(floor.pose(kRobot1).x, stands_at);
  EXPECT_TRUE(floor.traffic.waiting(kRobot1, floor.now));
  floor.traffic.set_speed(kRobot1, 1, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 12);
}

TEST(Traffic, NobodySendsAHaltedRobotAway) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}}));
  floor.traffic.set_speed(kRobot2, 0, floor.now);
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  const auto arrived = [&] { return floor.traffic.arrived(kRobot1); };
  EXPECT_GT(floor.until(arrived, 30), 30);
  EXPECT_EQ(floor.pose(kRobot2).x, 0);
  floor.traffic.set_speed(kRobot2, 1, floor.now);
  EXPECT_LT(floor.until(arrived), 30);
  EXPECT_GE(floor.least_distance, 0.47);
}

TEST(Traffic, OneThatPeopleSetDownStandsThereAndOthersKeepTheirDistance) {
  Drivers floor(open_floor({{-6, 4, 0}, {0, 7, 0}}));
  floor.traffic.request(kRobot1, {6, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot2, {6, 7, 0}, {}, floor.now);
  floor.until([&] { return floor.pose(kRobot1).x > -0.8; });
  floor.traffic.set_down(kRobot2, {0, 4.1, 0}, floor.now);  // in the way of the other
  floor.push(kRobot2, {0, 4.1, 0});
  EXPECT_FALSE(floor.traffic.moving(kRobot2));
  EXPECT_FALSE(floor.traffic.waiting(kRobot2, floor.now));
  floor.least_distance = 100;
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 30);
  EXPECT_GT(floor.least_distance, 0.46);
}

TEST(Traffic, ASlowRobotThatIsFastAgainDrivesFastAtOnce) {
  Drivers floor(open_floor({{-6, 4, 0}}));
  floor.traffic.set_speed(kRobot1, 0.2, floor.now);
  floor.traffic.request(kRobot1, {6, 4, 0}, {}, floor.now);
  EXPECT_GT(floor.until([&] { return floor.pose(kRobot1).x > -5; }), 1 / (0.2 * DriveLimits{}.speed));
  floor.traffic.set_speed(kRobot1, 1, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 11 / DriveLimits{}.speed + 3);
}

TEST(Traffic, AStretchedMotionIsTheSameOneInSoManyTimesTheTime) {
  FloorPlan plan = open_floor({{-6, 1, 0}});
  plan.stations = {{"A", "BS", {-3, 1.2, 0}, true}};
  const auto planned = [&](double times) {
    Drivers floor(plan);
    floor.traffic.stretch(kRobot1, times);
    floor.traffic.request(kRobot1, {0, 1.2, 3}, {}, floor.now);
    floor.tick();
    return *floor.traffic.motion(kRobot1);
  };
  const Trajectory usual = planned(1);
  for (const double times : {0.5, 1.6}) {
    const Trajectory other = planned(times);
    EXPECT_NEAR(to_seconds(other.duration()), times * to_seconds(usual.duration()), 0.11);
    for (double part = 0; part <= 1; part += 0.125) {
      const auto at = [&](const Trajectory& motion) {
        return motion.at(motion.start() + from_seconds(part * to_seconds(motion.duration())));
      };
      EXPECT_LT(distance(at(other).position(), at(usual).position()), 0.1) << times << " at " << part;
      EXPECT_LT(std::abs(wrap_angle(at(other).yaw - at(usual).yaw)), 0.15) << times << " at " << part;
    }
  }
}

TEST(Traffic, MotionsStayWithinTheLimitsOfTheBase) {
  FloorPlan plan = open_floor({{-6, 1, 0}});
  plan.stations = {
      {"A", "BS", {-3, 1.2, 0}, true}, {"B", "BS", {0, 3.5, 0.785}, true}, {"C", "BS", {3, 6, 1.57}, true}};
  Drivers floor(plan);
  floor.traffic.request(kRobot1, {6, 7, -3}, {}, floor.now);
  const Trajectory* motion = nullptr;
  floor.until([&] { return (motion = floor.traffic.motion(kRobot1)) != nullptr; });
  const auto poses = motion->poses();
  double previous = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double v = distance(poses[i - 1].position(), poses[i].position()) / 0.05;
    EXPECT_LE(v, 0.7);
    EXPECT_LE(v - previous, 0.4 * 0.05 + 0.02);
    EXPECT_GE(v - previous, -1.5 * 0.05 - 0.02);
    EXPECT_LE(std::abs(wrap_angle(poses[i].yaw - poses[i - 1].yaw)) / 0.05, 1.4);
    previous = v;
  }
  floor.until([&] { return floor.traffic.arrived(kRobot1); });
  EXPECT_GE(floor.least_clearance, FloorMap::kClearance - 0.02);
}

TEST(Traffic, TurningTakesItsTimeByTheShorterSide) {
  for (const auto& [from, to, least, most] : {std::tuple{0.0, 3.1, 3.1 / 1.4, 5.0}, std::tuple{3.0, -3.0, 0.1, 1.5}}) {
    Drivers floor(open_floor({{0, 4, from}}));
    floor.traffic.request(kRobot1, {0, 4, to}, {}, floor.now);
    const double took = floor.until([&] { return floor.traffic.arrived(kRobot1); });
    EXPECT_GT(took, least) << from << " to " << to;
    EXPECT_LT(took, most) << from << " to " << to;
    EXPECT_NEAR(floor.pose(kRobot1).yaw, to, 1e-9);
  }
}

TEST(Traffic, CurvesAreDrivenSlowly) {
  std::vector<Vec2> way;
  for (int i = 0; i <= 60; ++i) way.push_back({-3 + 0.05 * i, 0});
  for (int i = 1; i <= 30; ++i) way.push_back({0.4 * std::sin(i * 0.05), 0.4 - 0.4 * std::cos(i * 0.05)});
  for (int i = 1; i <= 60; ++i)
    way.push_back({way[90].x() + i * 0.05 * std::cos(1.5), way[90].y() + i * 0.05 * std::sin(1.5)});
  const DriveLimits limits;
  const Trajectory motion(way, 0, 0, limits);
  double fastest_straight = 0, fastest_in_curve = 0;
  for (SimTime t{}; t < motion.end(); t += Trajectory::kStep) {
    const Vec2 p = motion.point_at(t);
    double& fastest = p.x() > 0.05 && p.y() < 0.35 ? fastest_in_curve : fastest_straight;
    fastest = std::max(fastest, motion.speed_at(t));
  }
  EXPECT_NEAR(fastest_straight, limits.speed, 0.01);
  for (SimTime t = motion.end() - from_seconds(1); t < motion.end(); t += Trajectory::kStep) {
    const double left = distance(motion.point_at(t), way.back()), speed = motion.speed_at(t);
    EXPECT_LE(speed * speed, 2 * limits.slow_down * left + 0.02) << left << " m before the end";
  }
  EXPECT_NEAR(fastest_in_curve, std::sqrt(limits.sideways * 0.4), 0.02);
}

TEST(Traffic, WhatRemainsIsTheWayStillToDrive) {
  Drivers floor(open_floor({{-3, 4, 0}}));
  EXPECT_EQ(floor.traffic.remaining(kRobot1, floor.now), 0);
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  for (const double x : {-2.0, 0.0, 2.9}) {
    floor.until([&] { return floor.pose(kRobot1).x > x; });
    EXPECT_NEAR(floor.traffic.remaining(kRobot1, floor.now), 3 - floor.pose(kRobot1).x, 0.05);
  }
  floor.until([&] { return floor.traffic.arrived(kRobot1); });
  EXPECT_EQ(floor.traffic.remaining(kRobot1, floor.now), 0);
}

TEST(Traffic, ThoseThatCrossKeepTheirDistanceAlsoWhenOneIsEarlyOrLate) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 1, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
  floor.tick();
  ASSERT_TRUE(floor.traffic.motion(kRobot1) && floor.traffic.motion(kRobot2));
  const Trajectory first = *floor.traffic.motion(kRobot1), second = *floor.traffic.motion(kRobot2);
  double least = 100;
  for (SimTime t{}; t < std::max(first.end(), second.end()); t += kTick)
    for (const double late : {-0.3, 0.0, 0.3})
      least = std::min(least, distance(first.point_at(t), second.point_at(t + from_seconds(late))));
  EXPECT_GT(least, 0.48);
}

TEST(Traffic, WhoIsAtWorkKeepsItsDistanceFromThoseWhoPass) {
  Drivers floor(open_floor({{0, 3, 0}, {-4, 4.62, 0}}));
  floor.traffic.request(kRobot2, {4, 4.62, 0}, {}, floor.now);
  floor.until([&] { return floor.pose(kRobot2).x > -2.5; });
  floor.traffic.request(kRobot1, {0, 4, 0}, Segment{{0, 4}, {0, 4.17}}, floor.now);
  double least = 100;
  floor.until([&] {
    if (floor.traffic.working(kRobot1))
      least = std::min(least, distance(floor.pose(kRobot2).position(), Vec2{0, 4.17}));
    return floor.traffic.working(kRobot1) && floor.traffic.arrived(kRobot2);
  });
  EXPECT_TRUE(floor.traffic.working(kRobot1) && floor.traffic.arrived(kRobot2));
  EXPECT_GE(least, 0.49);
}

TEST(Traffic, OfTwoThatWantOnePlaceTheFirstThatAskedGetsIt) {
  for (const auto& [first, second] : {std::pair{kRobot1, kRobot2}, std::pair{kRobot2, kRobot1}}) {
    Drivers floor(open_floor({{-3, 4, 0}, {3, 4, 0}}));
    const Segment work{{0, 4}, {0, 4.17}};
    floor.traffic.request(first, {0, 4, 0}, work, floor.now);
    floor.traffic.request(second, {0, 4, 0}, work, floor.now);
    floor.until([&] { return floor.traffic.working(kRobot1) || floor.traffic.working(kRobot2); });
    EXPECT_TRUE(floor.traffic.working(first));
  }
}

TEST(Traffic, OneThatHasEndedItsWorkIsSentAwayAfterASecond) {
  for (const double offset : {0.0, 0.5, 1.0, 1.5}) {
    Drivers floor(open_floor({{-5, 4, 0}, {0.5, 4, 0}}));
    const Segment work{{0, 4}, {0.17, 4}};
    floor.traffic.request(kRobot2, {0, 4, 0}, work, floor.now);
    floor.until([&] { return floor.traffic.working(kRobot2); });
    floor.traffic.request(kRobot1, {0, 4, 0}, work, floor.now);
    const SimTime begin = floor.now + from_seconds(15 + offset);
    floor.until([&] { return floor.now >= begin; });
    floor.traffic.withdraw(kRobot2, floor.now);
    EXPECT_NEAR(floor.until([&] { return floor.traffic.moving(kRobot2); }), 1.0, 0.1) << offset;
  }
}

TEST(Traffic, TwoThatMeetPassEachOther) {
  Drivers floor(open_floor({{-3, 4, 0}, {3, 4, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot2, {-3, 4, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1) && floor.traffic.arrived(kRobot2); }), 40);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, OneThatStandsIdleStepsAside) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}}));
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 20);
  EXPECT_GT(distance(floor.pose(kRobot2).position(), Vec2{0, 4}), 0.5);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, OneThatStepsAsideKeepsItsDistanceFromThoseThatStand) {
  const auto place = [](const Vec2& standing) {
    Drivers floor(open_floor({{standing.x(), standing.y(), 0}, {-3, 1, 0}, {0, 4, 0}}));
    floor.traffic.request(kRobot2, {0, 4, 0}, {}, floor.now);
    EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot2); }), 30);
    return floor.pose(kRobot3).position();
  };
  const Vec2 alone = place({5, 7});
  for (int k = 0; k < 12; ++k) {
    const double angle = k * std::numbers::pi / 6;
    const Vec2 beside = alone + 0.54 * Vec2(std::cos(angle), std::sin(angle));
    if (distance(beside, Vec2(0, 4)) < 1) continue;
    EXPECT_GE(distance(place(beside), beside), 0.58 - 1e-6) << k;
  }
}

TEST(Traffic, OneThatStepsAsideKeepsItsDistanceFromTheWholeWay) {
  for (int k = 0; k < 10; ++k) {
    const Vec2 from(-3 - 0.01 * k, 4.0205), goal(-0.01 * k, 4.0205);
    Drivers floor(open_floor({{from.x(), from.y(), 0}, {goal.x() - 0.25, 4.02, 0}}));
    floor.until([&] { return floor.now > from_seconds(1); });
    floor.traffic.request(kRobot1, {goal.x(), goal.y(), 0}, {}, floor.now);
    floor.tick();
    ASSERT_TRUE(floor.traffic.moving(kRobot2));
    EXPECT_GE(distance(floor.traffic.motion(kRobot2)->last().position(), Segment{from, goal}), 0.58 - 1e-6) << k;
  }
}

TEST(Traffic, OneAtWorkIsWaitedForNearby) {
  Drivers floor(open_floor({{-5, 4, 0}, {0.5, 4, 0}}));
  const Segment work{{0, 4}, {0.17, 4}};
  floor.traffic.request(kRobot2, {0, 4, 0}, work, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot2); });
  floor.traffic.request(kRobot1, {0, 4, 0}, work, floor.now);
  for (int i = 0; i < 1000; ++i) floor.tick();
  EXPECT_FALSE(floor.traffic.arrived(kRobot1));
  EXPECT_NEAR(floor.pose(kRobot2).x, 0, 1e-9);
  EXPECT_LT(distance(floor.pose(kRobot1).position(), Vec2{0, 4}), 1.5);
  floor.traffic.withdraw(kRobot2, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 15);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, InADeadEndThoseInFrontMakeWay) {
  // A corridor as wide as one robot and a bit: 3 behind 2 behind 1.
  FloorPlan plan = open_floor({{4.5, 0.5, 0}, {5.5, 0.5, 0}, {6.5, 0.5, 0}});
  plan.walls = {{{5, 1}, {7, 1}}, {{4, 0}, {4, 1}}};
  Drivers floor(plan);
  floor.traffic.request(kRobot3, {4.5, 4, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot3); }), 40);
  floor.traffic.request(kRobot2, {6.5, 0.5, 0}, {}, floor.now);
  floor.traffic.request(kRobot1, {5.5, 0.5, 0}, {}, floor.now);
  floor.traffic.request(kRobot3, {4.5, 0.5, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] {
    return !floor.traffic.waiting(kRobot1, floor.now) && !floor.traffic.waiting(kRobot2, floor.now) &&
           floor.traffic.arrived(kRobot3);
  }),
            100);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, ThreeThatChangePlacesAllArrive) {
  Drivers floor(open_floor({{-1, 4, 0}, {0, 4, 0}, {1, 4, 0}}));
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot2, {1, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot3, {-1, 4, 0}, {}, floor.now);
  bool arrived[3] = {};
  EXPECT_LT(floor.until([&] {
    for (int i = 0; i < 3; ++i) arrived[i] = arrived[i] || floor.traffic.arrived(static_cast<RobotId>(i));
    return arrived[0] && arrived[1] && arrived[2];
  }),
            60);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, AWithdrawnRequestBrakesTheRobotAndLeavesRoomToTheOthers) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 1, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
  floor.until([&] { return floor.pose(kRobot1).x > -0.1; });
  floor.traffic.withdraw(kRobot1, floor.now);
  EXPECT_LT(floor.until([&] { return !floor.traffic.moving(kRobot1); }), 1.0);
  EXPECT_LT(floor.pose(kRobot1).x, 0.4);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot2); }), 30);
  EXPECT_GE(floor.least_distance, 0.46);
}

TEST(Traffic, AGoalInsideAMachineIsUnreachable) {
  FloorPlan plan = open_floor({{0, 1, 0}});
  plan.stations = {{"A", "BS", {3, 4, 0}, true}};
  Drivers floor(plan);
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.tick();
  EXPECT_TRUE(floor.traffic.unreachable(kRobot1));
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  EXPECT_FALSE(floor.traffic.unreachable(kRobot1));
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 20);
}

TEST(Traffic, AGoalTooNearToAWallIsUnreachable) {
  FloorPlan plan = open_floor({{0, 1, 0}});
  plan.walls = {{{3, 0}, {3, 8}}};
  for (const auto& [x, reached] : {std::pair{2.85, false}, std::pair{2.6, true}}) {
    Drivers floor(plan);
    floor.traffic.request(kRobot1, {x, 4, 0}, {}, floor.now);
    floor.until([&] { return floor.traffic.arrived(kRobot1) || floor.traffic.unreachable(kRobot1); }, 20);
    EXPECT_EQ(floor.traffic.arrived(kRobot1), reached) << x;
    EXPECT_EQ(floor.traffic.unreachable(kRobot1), !reached) << x;
  }
}

TEST(Traffic, AGoalBehindClosedWallsIsUnreachable) {
  FloorPlan plan = open_floor({{0, 1, 0}});
  plan.walls = {{{2, 3}, {4, 3}}, {{4, 3}, {4, 5}}, {{4, 5}, {2, 5}}, {{2, 5}, {2, 3}}};
  Drivers floor(plan);
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.tick();
  EXPECT_TRUE(floor.traffic.unreachable(kRobot1));
}

TEST(Traffic, ARobotThatIsPushedOffItsMotionIsPlannedAnew) {
  Drivers floor(open_floor({{-3, 4, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.pose(kRobot1).x > 0; });
  const auto before = floor.traffic.motion_number(kRobot1);
  Pose2 pushed = floor.pose(kRobot1);
  pushed.y += 0.3;
  floor.traffic.observe(kRobot1, pushed, floor.now);
  EXPECT_GT(floor.traffic.motion_number(kRobot1), before);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1); }), 20);
}

TEST(Traffic, TheOlderRequestGoesFirst) {
  Drivers floor(open_floor({{-3, 4, 0}, {-3, 6, 0}}));
  const Segment work{{0, 5}, {0.17, 5}};
  floor.traffic.request(kRobot2, {0, 5, 0}, work, floor.now);
  floor.traffic.request(kRobot1, {0, 5, 0}, work, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot1) || floor.traffic.working(kRobot2); });
  EXPECT_TRUE(floor.traffic.working(kRobot2));
}

TEST(Traffic, ARobotThatHasJustFinishedIsNotSentAwayAtOnce) {
  Drivers floor(open_floor({{-0.9, 4, 0}, {0, 4, 0}}));  // so near that waiting nearby is not worth a drive
  floor.traffic.request(kRobot2, {0, 4, 0}, Segment{{0, 4}, {0.17, 4}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot2); });
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  floor.traffic.withdraw(kRobot2, floor.now);
  for (int i = 0; i < 45; ++i) floor.tick();
  EXPECT_FALSE(floor.traffic.moving(kRobot2)) << "0.9 s later";
  EXPECT_LT(floor.until([&] { return floor.traffic.moving(kRobot2); }), 2.5);
}

TEST(Traffic, OneThatSteppedAsideDoesNotReturnBeforeTheOtherHasGone) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot1); });
  floor.traffic.request(kRobot2, {0, 4, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.arrived(kRobot1) && floor.traffic.arrived(kRobot2); }), 40);
  EXPECT_GE(floor.least_distance, 0.49);
}

TEST(Traffic, RemainingIsTheWayThatIsLeft) {
  FloorPlan plan = open_floor({{-1, 4, 0}});
  plan.stations = {{"A", "BS", {0, 4, 0}, true}};
  Drivers floor(plan);
  floor.traffic.request(kRobot1, {1, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot1); });
  const double whole = floor.traffic.remaining(kRobot1, floor.now);
  EXPECT_NEAR(whole, floor.traffic.motion(kRobot1)->length(), 0.05);
  EXPECT_GT(whole, 2.3) << "around the machine";
  floor.until([&] { return floor.pose(kRobot1).x > 0; });
  EXPECT_NEAR(floor.traffic.remaining(kRobot1, floor.now), whole / 2, 0.3);
  floor.until([&] { return floor.traffic.arrived(kRobot1); });
  EXPECT_EQ(floor.traffic.remaining(kRobot1, floor.now), 0);
}

TEST(Traffic, AStandingPlaceIsFreeAndNear) {
  FloorPlan plan = open_floor({});
  plan.stations = {{"A", "BS", {0, 4, 0}, true}};
  const Traffic traffic(plan);
  const auto place = traffic.standing_place(Vec2(0, 4), 0.75);
  ASSERT_TRUE(place);
  EXPECT_GE(plan.clearance(*place), 0.25);
  EXPECT_LE(distance(*place, Vec2(0, 4)), 0.5);
  EXPECT_FALSE(traffic.standing_place(Vec2(0, 4), 0.4));
  EXPECT_EQ(*traffic.standing_place(Vec2(3, 4), 0.75), Vec2(3, 4));
}

TEST(Traffic, OfStandingPlacesThatAreEquallyNearTheFirstIsTaken) {
  FloorPlan plan = open_floor({});
  plan.stations = {{"A", "BS", {0, 4, 0}, true}};
  const Vec2 place = *Traffic(plan).standing_place(Vec2(0, 4), 0.75);
  EXPECT_NEAR(place.x(), -0.45, 1e-9);
  EXPECT_NEAR(place.y(), 4, 1e-9);
}

TEST(Traffic, NobodyWaitsCloserThanHalfAMetreToAWorkingRobot) {
  Drivers floor(open_floor({{-2, 4, 0}, {0.5, 4, 0}}));
  floor.traffic.request(kRobot2, {0, 4, 0}, Segment{{0, 4}, {0.17, 4}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot2); });
  floor.traffic.request(kRobot1, {-0.45, 4, 0}, {}, floor.now);
  for (int i = 0; i < 500; ++i) floor.tick();
  EXPECT_FALSE(floor.traffic.arrived(kRobot1));
  EXPECT_GE(floor.least_distance, 0.5);
}

TEST(Traffic, OneThatDrivesToWaitTurnsToItsGoalWhenThatIsFree) {
  Drivers floor(open_floor({{-6, 4, 0}, {0.5, 4, 0}}));
  const Segment work{{0, 4}, {0.17, 4}};
  floor.traffic.request(kRobot2, {0, 4, 0}, work, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot2); });
  floor.traffic.request(kRobot1, {0, 4, 0}, work, floor.now);
  floor.until([&] { return floor.pose(kRobot1).x > -4.5; });
  ASSERT_TRUE(floor.traffic.moving(kRobot1)) << "to a place to wait";
  const auto motions = floor.traffic.motion_number(kRobot1);
  floor.traffic.withdraw(kRobot2, floor.now);
  floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
  EXPECT_LT(floor.until([&] { return floor.traffic.motion_number(kRobot1) > motions; }), 2.1)
      << "it looks every two seconds";
  EXPECT_LT(floor.until([&] { return floor.traffic.working(kRobot1); }), 12);
}

TEST(Traffic, NobodyWaitsLongerThanItMust) {
  for (const double ahead : {0.0, 0.5, 1.0, 1.3}) {
    Drivers floor(open_floor({{-3, 4, 0}, {0, 1 + ahead, 0}}));
    floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
    floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
    floor.tick();
    const Trajectory first = *floor.traffic.motion(kRobot1), second = *floor.traffic.motion(kRobot2);
    const SimTime waits = second.start() - floor.now;
    if (waits == SimTime{}) continue;
    double least = 100;
    for (SimTime t{}; t < first.end(); t += kTick)
      for (const double late : {-0.3, -0.15, 0.0, 0.15, 0.3})
        least = std::min(least, distance(first.point_at(t), second.point_at(t + from_seconds(late + 0.2))));
    EXPECT_LT(least, 0.5) << "0.2 s earlier it would have come too near; ahead " << ahead;
  }
}

TEST(Traffic, AStandingPlaceLiesWithinTheRadiusAlsoByTheDiagonal) {
  FloorPlan plan = open_floor({});
  const Traffic traffic(plan);
  // The field ends at x = 7: the nearest place keeps 0.25 m from it.
  for (const double x : {7.3, 7.45}) {
    const auto place = traffic.standing_place(Vec2(x, 8.4), 0.9);
    if (place) {
      EXPECT_LE(distance(*place, Vec2(x, 8.4)), 0.9) << x;
    }
  }
  EXPECT_FALSE(traffic.standing_place(Vec2(7.45, 8.45), 0.9)) << "0.7 m off on either axis";
}

TEST(Traffic, OneThatSteppedAsideWaitsForTheOtherTwentySecondsAtMost) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}, {6, 6, 0}}));
  floor.traffic.request(kRobot3, {6, 6, 0}, Segment{{6, 6}, {6, 6}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot3); });
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot2); });
  const SimTime stepped_aside = floor.now;
  floor.until([&] { return !floor.traffic.moving(kRobot2); });
  floor.traffic.request(kRobot1, {6, 6, 0}, {}, floor.now);  // which stays occupied
  floor.traffic.request(kRobot2, {-3, 6, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot2); });
  EXPECT_GE(floor.now - stepped_aside, from_seconds(20));
  EXPECT_LE(floor.now - stepped_aside, from_seconds(22)) << "it looks every two seconds";
}

TEST(Traffic, ANewWishOfOneThatStepsAsideDoesNotBrakeIt) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}}));
  floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot2); });
  const auto motions = floor.traffic.motion_number(kRobot2);
  floor.traffic.request(kRobot2, {0, 6, 0}, {}, floor.now);
  EXPECT_EQ(floor.traffic.motion_number(kRobot2), motions);
  floor.traffic.withdraw(kRobot2, floor.now);
  EXPECT_EQ(floor.traffic.motion_number(kRobot2), motions);
}

TEST(Traffic, WhereWaysCrossHalfAMetreIsKeptAtEachInstant) {
  for (int k = 0; k < 12; ++k) {
    Drivers floor(open_floor({{-3, 4, 0}, {0, 0.5 + 0.17 * k, 0}}));
    floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
    floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
    floor.tick();
    const Trajectory first = *floor.traffic.motion(kRobot1), second = *floor.traffic.motion(kRobot2);
    double least = 100;
    double apart = 0;
    for (SimTime t{}; t < std::max(first.end(), second.end()); t += (apart > 1 ? 20 : 1) * kTick) {
      apart = distance(first.point_at(t), second.point_at(t));
      if (apart > 1) continue;
      for (const double late : {-0.3, -0.15, 0.0, 0.15, 0.3})
        least = std::min(least, distance(first.point_at(t), second.point_at(t + from_seconds(late))));
    }
    EXPECT_GT(least, 0.497) << k;
  }
}

TEST(Traffic, OneThatStandsCloseToTheGoalOfAnotherMayLeaveAtOnce) {
  Drivers floor(open_floor({{0, 3, 0}, {4, 4, 0}}));
  floor.traffic.request(kRobot2, {0.48, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.pose(kRobot2).x < 0.55; });
  ASSERT_TRUE(floor.traffic.moving(kRobot2));
  floor.push(kRobot1, {0, 4, 0});
  floor.tick();
  floor.traffic.request(kRobot1, {-3, 4, 0}, {}, floor.now);
  floor.tick();
  ASSERT_TRUE(floor.traffic.moving(kRobot1) && floor.traffic.moving(kRobot2));
  EXPECT_EQ(floor.traffic.motion(kRobot1)->start(), floor.now);
}

TEST(Traffic, OneThatStepsAsideLeavesTheGoalsOfOthersFree) {
  const auto place = [](const Vec2& wanted) {
    Drivers floor(open_floor({{-3, 1, 0}, {6, 7, 0}, {0, 4, 0}}));
    floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
    floor.traffic.request(kRobot2, {wanted.x(), wanted.y(), 0}, {}, floor.now);
    floor.until([&] { return floor.traffic.moving(kRobot3); });
    return floor.traffic.motion(kRobot3)->last().position();
  };
  const Vec2 alone = place({5, 1});
  for (int k = 0; k < 12; ++k) {
    const double angle = k * std::numbers::pi / 6;
    const Vec2 goal = alone + 0.3 * Vec2(std::cos(angle), std::sin(angle));
    EXPECT_GE(distance(place(goal), goal), 0.58 - 1e-6) << k;
  }
}

TEST(Traffic, OneThatBrakesWhereAnotherIsAboutToWorkStopsThatOneToo) {
  for (const auto& [y, stops] : {std::pair{3.55, true}, std::pair{3.4, false}}) {
    Drivers floor(open_floor({{-3, 4, 0}, {0, 0.5, 0}}));
    floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
    floor.tick();
    floor.traffic.request(kRobot2, {0, 3.3, 0}, Segment{{0, 3.3}, {0, y}}, floor.now);
    floor.until([&] { return floor.pose(kRobot1).x > -0.15; });
    ASSERT_TRUE(floor.traffic.moving(kRobot2));
    const auto motions = floor.traffic.motion_number(kRobot2);
    floor.traffic.withdraw(kRobot1, floor.now);
    EXPECT_EQ(floor.traffic.motion_number(kRobot2) > motions, stops) << y;
  }
}

TEST(Traffic, OneThatGivesUpItsWorkTakesTheRoomOfARobotOnly) {
  // At work it takes the room up to (0, 4.5), which the other wants to pass.
  Drivers floor(open_floor({{0, 3, 0}, {-3, 4.6, 0}}));
  floor.traffic.request(kRobot1, {0, 4, 0}, Segment{{0, 4}, {0, 4.5}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot1); });
  floor.traffic.withdraw(kRobot1, floor.now);
  floor.traffic.request(kRobot2, {3, 4.6, 0}, {}, floor.now);
  floor.traffic.plan(floor.now);  // in the same tick
  ASSERT_TRUE(floor.traffic.moving(kRobot2));
  EXPECT_NEAR(floor.traffic.motion(kRobot2)->length(), 6, 0.01);
}

TEST(Traffic, OneAtWorkThatWantsToBeElsewhereEndsItsWork) {
  Drivers floor(open_floor({{0, 3, 0}, {-3, 4.6, 0}}));
  floor.traffic.request(kRobot1, {0, 4, 0}, Segment{{0, 4}, {0, 4.5}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot1); });
  floor.traffic.set_speed(kRobot1, 0, floor.now);  // it cannot leave yet
  floor.traffic.request(kRobot1, {0, 2, 0}, {}, floor.now);
  EXPECT_FALSE(floor.traffic.working(kRobot1));
  floor.traffic.request(kRobot2, {3, 4.6, 0}, {}, floor.now);
  floor.traffic.plan(floor.now);  // in the same tick
  ASSERT_TRUE(floor.traffic.moving(kRobot2));
  EXPECT_NEAR(floor.traffic.motion(kRobot2)->length(), 6, 0.01);
  floor.traffic.set_speed(kRobot1, 1, floor.now);
  floor.until([&] { return floor.traffic.arrived(kRobot1); });
  EXPECT_NEAR(floor.pose(kRobot1).y, 2, 1e-6);
  EXPECT_FALSE(floor.traffic.working(kRobot1));
}

/// "robot1 waits for robot2; ...": those that wait, with whom they wait for, if it is known.
std::string who_waits(const Drivers& floor, int robots) {
  std::string out;
  for (int i = 0; i < robots; ++i)
    if (const auto id = static_cast<RobotId>(i); floor.traffic.waiting(id, floor.now)) {
      const auto whom = floor.traffic.waits_for(id, floor.now);
      out += (out.empty() ? "robot" : "; robot") + std::to_string(i + 1) + " waits" +
             (whom ? " for robot" + std::to_string(static_cast<int>(*whom) + 1) : "");
    }
  return out;
}

TEST(WhoWaits, IsToldOfTheOneAtItsGoal) {
  for (const auto& [worker, other] : {std::pair{kRobot1, kRobot2}, std::pair{kRobot2, kRobot1}}) {
    Drivers floor(open_floor({{-0.9, 4, 0}, {0.9, 4, 0}, {0, 7, 0}}));
    const Segment work{{0, 4}, {0, 4.17}};
    floor.traffic.request(worker, {0, 4, 0}, work, floor.now);
    floor.until([&] { return floor.traffic.working(worker); });
    floor.traffic.request(other, {0, 4, 0}, work, floor.now);
    floor.tick();
    EXPECT_EQ(who_waits(floor, 3), worker == kRobot1 ? "robot2 waits for robot1" : "robot1 waits for robot2");
    floor.traffic.withdraw(worker, floor.now);
    floor.until([&] { return floor.traffic.arrived(other); });
    EXPECT_EQ(who_waits(floor, 3), "");
  }
}

TEST(WhoWaits, IsToldOfTheOneThatItHasCometoWaitFor) {
  Drivers floor(open_floor({{-5, 4, 0}, {0.5, 4, 0}}));
  const Segment work{{0, 4}, {0.17, 4}};
  floor.traffic.request(kRobot2, {0, 4, 0}, work, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot2); });
  floor.traffic.request(kRobot1, {0, 4, 0}, work, floor.now);
  floor.tick();
  EXPECT_EQ(who_waits(floor, 2), "") << "it drives nearer";
  floor.until([&] { return floor.traffic.waiting(kRobot1, floor.now); });
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(who_waits(floor, 2), "robot1 waits for robot2");
    floor.tick();
  }
}

TEST(WhoWaits, IsToldOfTheOneThatItWouldMeetIfItSetOff) {
  int waits = 0;
  for (int k = 0; k < 12; ++k) {
    Drivers floor(open_floor({{-3, 4, 0}, {0, 1 + 0.15 * k, 0}, {0.9, 7, 0}}));
    floor.traffic.request(kRobot1, {3, 4, 0}, {}, floor.now);
    floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
    floor.traffic.request(kRobot3, {0, 7, 0}, {}, floor.now);
    floor.tick();
    if (!floor.traffic.waiting(kRobot2, floor.now)) continue;
    ++waits;
    EXPECT_EQ(who_waits(floor, 3), "robot2 waits for robot1; robot3 waits for robot2") << k;
    floor.until([&] { return floor.now >= floor.traffic.motion(kRobot2)->start(); });
    EXPECT_EQ(who_waits(floor, 3), "robot3 waits for robot2") << k;
  }
  EXPECT_GT(waits, 0);
}

TEST(WhoWaits, IsToldOfNobodyWhereItIsHaltedItself) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}}));
  floor.traffic.request(kRobot2, {0, 7, 0}, {}, floor.now);
  floor.traffic.set_speed(kRobot2, 0, floor.now);
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.now > from_seconds(1) && floor.traffic.waiting(kRobot1, floor.now); });
  EXPECT_EQ(who_waits(floor, 2), "robot1 waits for robot2; robot2 waits");
  floor.traffic.set_speed(kRobot1, 0, floor.now);
  floor.tick();
  EXPECT_EQ(who_waits(floor, 2), "robot1 waits; robot2 waits");
  floor.traffic.set_speed(kRobot1, 1, floor.now);
  floor.tick();
  EXPECT_EQ(who_waits(floor, 2), "robot1 waits for robot2; robot2 waits");
}

TEST(WhoWaits, IsToldOfTheFirstInARow) {
  // A corridor as wide as one robot and a bit: 3 behind 2 behind 1. 2 stands less in the middle.
  FloorPlan plan = open_floor({{4.5, 0.5, 0}, {5.5, 0.65, 0}, {6.5, 0.5, 0}});
  plan.walls = {{{5, 1}, {7, 1}}, {{4, 0}, {4, 1}}};
  for (const bool second_is_halted : {false, true}) {
    Drivers floor(plan);
    floor.traffic.set_speed(kRobot1, 0, floor.now);
    floor.traffic.set_speed(kRobot2, second_is_halted ? 0 : 1, floor.now);
    floor.until([&] { return floor.now > from_seconds(2); });
    floor.traffic.request(kRobot2, {3, 0.5, 0}, {}, floor.now);
    floor.traffic.request(kRobot3, {3, 4, 0}, {}, floor.now);
    floor.tick();
    EXPECT_EQ(who_waits(floor, 3), second_is_halted ? "robot2 waits; robot3 waits for robot2"
                                                    : "robot2 waits for robot1; robot3 waits for robot1")
        << "who could make room is not in the way";
  }
}

TEST(WhoWaits, IsToldOfOneThatHasNoPlaceToGo) {
  FloorPlan plan = open_floor({{5.5, 0.5, 0}, {4.5, 0.5, 0}, {0, 4, 0}});
  plan.walls = {{{4, 1}, {7, 1}}, {{4, 0}, {4, 1}}, {{6, 0}, {6, 1}}};
  Drivers floor(plan);
  floor.until([&] { return floor.now > from_seconds(2); });
  floor.traffic.request(kRobot2, {5.5, 0.5, 0}, {}, floor.now);
  floor.tick();
  EXPECT_EQ(who_waits(floor, 3), "robot2 waits for robot1");
}

TEST(WhoWaits, IsToldOfTheOneForWhichItSteppedAside) {
  Drivers floor(open_floor({{-3, 4, 0}, {0, 4, 0}, {6, 6, 0}}));
  floor.traffic.request(kRobot3, {6, 6, 0}, Segment{{6, 6}, {6, 6}}, floor.now);
  floor.until([&] { return floor.traffic.working(kRobot3); });
  floor.traffic.request(kRobot1, {0, 4, 0}, {}, floor.now);
  floor.until([&] { return floor.traffic.moving(kRobot2); });
  floor.until([&] { return !floor.traffic.moving(kRobot2); });
  floor.traffic.request(kRobot1, {6, 6, 0}, {}, floor.now);  // which stays occupied
  floor.traffic.request(kRobot2, {-3, 6, 0}, {}, floor.now);
  floor.tick();
  EXPECT_EQ(who_waits(floor, 2), "robot2 waits for robot1");
}

/// Where a robot wants to go, and the ground that it works on there.
struct Wish {
  Vec2 goal{};
  Segment ground{};
};

/// How near two robots come, if each drives to its goal as if it were alone, or as it is planned to.
double nearest_approach(FloorMap& map, const Drivers& floor, const Wish (&wishes)[3], RobotId a, RobotId b) {
  const auto places = [&](RobotId id) {
    const Wish& wish = wishes[static_cast<std::size_t>(id)];
    std::vector<Vec2> out{floor.pose(id).position()};
    if (floor.traffic.working(id)) out.insert(out.end(), {wish.ground.a, wish.ground.b});
    if (floor.traffic.moving(id))
      for (SimTime t = floor.now; t < floor.traffic.motion(id)->end(); t += 5 * kTick)
        out.push_back(floor.traffic.motion(id)->point_at(t));
    if (!floor.traffic.waiting(id, floor.now)) return out;
    out.insert(out.end(), {wish.ground.a, wish.ground.b});
    if (const auto way = map.route(out.front(), wish.goal, {})) out.insert(out.end(), way->begin(), way->end());
    return out;
  };
  // As numbers: without optimisation Eigen takes most of the time of this test.
  const auto numbers = [&](RobotId id) {
    std::vector<std::pair<double, double>> out;
    for (const Vec2& at : places(id)) out.emplace_back(at.x(), at.y());
    return out;
  };
  double nearest = 100 * 100;
  const auto others = numbers(b);
  for (const auto& [x, y] : numbers(a))
    for (const auto& [u, v] : others) nearest = std::min(nearest, (x - u) * (x - u) + (y - v) * (y - v));
  return std::sqrt(nearest);
}

/// Three robots on a floor with machines, who each get one job after another: half of them work at a spot for a while.
/// `restless`: now and then a job is given up or replaced on the way.
std::string busy_floor(std::uint64_t seed, bool restless = false) {
  RandomStream random(seed, "traffic test");
  FloorPlan plan = open_floor({{4.5, 0.5, 1.57}, {5.5, 0.5, 1.57}, {6.5, 0.5, 1.57}});
  plan.walls = {{{5, 1}, {7, 1}}, {{4, 0}, {4, 1}}};
  for (int i = 0; i < 6; ++i)
    plan.stations.push_back({"M" + std::to_string(i),
                             i % 2 ? "CS" : "BS",
                             {-2.4 + 1.6 * i + random.uniform(-0.3, 0.3),
                              i % 3 == 0   ? 2.5
                              : i % 3 == 1 ? 5.5
                                           : 6.5,
                              wrap_angle(static_cast<double>(random.between(0, 7)) * std::numbers::pi / 4)},
                             true});
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    for (Spot& spot : spots_of(plan.stations[i], static_cast<StationId>(i))) plan.spots.push_back(std::move(spot));
  Drivers floor(plan);
  FloorMap map(plan);
  Wish wishes[3];
  constexpr int kJobs = 5;
  int done[3] = {}, impossible = 0;
  bool busy[3] = {};
  SimTime works_until[3] = {};
  double waited = 0, named = 0, farthest = 0;
  floor.until(
      [&] {
        for (int i = 0; i < 3; ++i) {
          const auto id = static_cast<RobotId>(i);
          Traffic& traffic = floor.traffic;
          if (traffic.waiting(id, floor.now)) {
            waited += to_seconds(kTick);
            const auto whom = traffic.waits_for(id, floor.now);
            named += whom || traffic.unreachable(id) ? to_seconds(kTick) : 0;
            if (whom) farthest = std::max(farthest, nearest_approach(map, floor, wishes, id, *whom));
          }
          if (restless && busy[i] && random.chance(0.001)) {
            if (random.chance(0.5)) traffic.withdraw(id, floor.now);
            busy[i] = false;
          }
          if (busy[i] && traffic.arrived(id) && works_until[i] == SimTime{})
            works_until[i] = floor.now + from_seconds(traffic.working(id) ? 4 : 0);
          const bool failed = busy[i] && traffic.unreachable(id);
          if (failed || (busy[i] && traffic.arrived(id) && floor.now >= works_until[i])) {
            impossible += failed;
            ++done[i];
            busy[i] = false;
            traffic.withdraw(id, floor.now);
          }
          if (busy[i] || done[i] == kJobs) continue;
          busy[i] = true;
          works_until[i] = SimTime{};
          if (random.chance(0.8)) {
            const Spot& spot = plan.spots[random.below(plan.spots.size())];
            traffic.request(id, spot.align_in_world, spot.footprint(), floor.now);
            wishes[i] = {spot.align_in_world.position(), spot.footprint()};
          } else {
            const Pose2 goal{random.uniform(-3, 3), random.uniform(2, 6), random.uniform(-3, 3)};
            traffic.request(id, goal, {}, floor.now);
            wishes[i] = {goal.position(), {goal.position(), goal.position()}};
          }
        }
        return done[0] + done[1] + done[2] == 3 * kJobs;
      },
      600);
  EXPECT_GE(floor.least_distance, restless ? 0.45 : 0.46) << seed;
  EXPECT_NEAR(named, waited, 0.03) << seed << ": a robot that waits waits for one";
  // A plan to set off later stays, also where the other one has given up meanwhile.
  EXPECT_LT(farthest, restless ? 1.5 : 0.6) << seed << ": who waits for one would come near it";
  char text[200];
  std::snprintf(text, sizeof text, "%.1f s, %u %u %u motions, waited %.1f s, %d impossible", to_seconds(floor.now),
                floor.traffic.motion_number(kRobot1), floor.traffic.motion_number(kRobot2),
                floor.traffic.motion_number(kRobot3), waited, impossible);
  return text;
}

// Times are counted in ticks of 20 ms, so that the last bits of a square root do not show.
TEST(Traffic, FiveJobsForEachOfThreeTakeAsLongAsTheyDid) {
  const char* wanted[]{
      "92.6 s, 5 7 9 motions, waited 0.0 s, 0 impossible",  "79.4 s, 7 6 5 motions, waited 0.0 s, 0 impossible",
      "79.9 s, 5 5 5 motions, waited 0.4 s, 0 impossible",  "104.7 s, 8 8 8 motions, waited 57.7 s, 0 impossible",
      "92.3 s, 8 8 8 motions, waited 13.6 s, 0 impossible", "80.5 s, 5 6 6 motions, waited 0.6 s, 0 impossible"};
  for (std::uint64_t seed = 0; seed < std::size(wanted); ++seed) EXPECT_EQ(busy_floor(seed + 1), wanted[seed]);
}

TEST(Traffic, JobsThatAreGivenUpOrReplacedTakeAsLongAsTheyDid) {
  for (const auto& [seed, wanted] : {std::pair{2, "111.6 s, 19 23 29 motions, waited 28.9 s, 1 impossible"},
                                     std::pair{3, "99.6 s, 13 25 21 motions, waited 11.7 s, 1 impossible"},
                                     std::pair{5, "100.3 s, 17 11 12 motions, waited 19.9 s, 2 impossible"}})
    EXPECT_EQ(busy_floor(static_cast<std::uint64_t>(seed), true), wanted);
}

}  // namespace
}  // namespace cxlab::sim::traffic_test
