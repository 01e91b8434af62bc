#include "sim/traffic/floor_map.h"

#include <numbers>

#include <gtest/gtest.h>

#include "cx/base/random.h"

namespace cxlab::sim {
namespace {

constexpr auto kAnywhere = [](const Vec2&) { return true; };

FloorPlan one_machine() {
  FloorPlan plan;
  plan.stations = {{"A", "BS", {2, 4, std::numbers::pi / 2}, true}};
  return plan;
}

double least_clearance(const FloorPlan& plan, const std::vector<Vec2>& way) {
  double least = 100;
  for (std::size_t i = 1; i < way.size(); ++i)
    for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0})
      least = std::min(least, plan.clearance(between(way[i - 1], way[i], part)));
  return least;
}

double length(const std::vector<Vec2>& way) {
  double sum = 0;
  for (std::size_t i = 1; i < way.size(); ++i) sum += distance(way[i - 1], way[i]);
  return sum;
}

TEST(FloorMap, ClearanceIsTheDistanceToTheNextBodyWallOrBorder) {
  FloorPlan plan = one_machine();
  plan.walls = {{{-4, 0}, {-4, 2}}};
  const FloorMap map(plan);
  EXPECT_NEAR(map.clearance({2, 4.175 + 0.5}), 0.5, 1e-6) << "before its face";
  EXPECT_NEAR(map.clearance({2 - 0.35 - 0.25, 4}), 0.25, 1e-6) << "beside it";
  EXPECT_EQ(map.clearance({2, 4}), 0);
  EXPECT_NEAR(map.clearance({-3.5, 1}), 0.5 - 0.025, 1e-6);
  EXPECT_NEAR(map.clearance({-6.5, 4}), 0.5 - 0.025, 1e-6);
  EXPECT_NEAR(map.clearance({-6.55, 4}), 0.45 - 0.025, 1e-6) << "between nodes";
  EXPECT_EQ(map.clearance({-7.1, 4}), 0) << "outside";
  EXPECT_EQ(map.clearance({0, 8.1}), 0);
}

TEST(FloorMap, AWayKeepsARobotsWidthFromMachines) {
  const FloorPlan plan = one_machine();
  FloorMap map(plan);
  const auto way = map.route({0, 4}, {4, 4}, {});
  ASSERT_TRUE(way);
  EXPECT_EQ(way->front(), Vec2(0, 4));
  EXPECT_EQ(way->back(), Vec2(4, 4));
  EXPECT_GE(least_clearance(plan, *way), 0.25);
  EXPECT_LT(length(*way), 4.4);
}

TEST(FloorMap, AWiderGapIsWorthADetour) {
  // A wall with a gap of 0.60 m, through which a robot barely fits, and a wide one above it that is a little further.
  FloorPlan plan;
  plan.walls = {{{0, 0}, {0, 3.7}}, {{0, 4.3}, {0, 4.4}}, {{0, 6}, {0, 8}}};
  FloorMap map(plan);
  const auto way = map.route({-2, 4.3}, {2, 4.3}, {});
  ASSERT_TRUE(way);
  EXPECT_GE(least_clearance(plan, *way), 0.3);
}

TEST(FloorMap, AWayStaysOutOfKeepouts) {
  FloorMap map{FloorPlan{}};
  const Keepout robot{{{0, 4}, {0, 4.3}}, 0.5};
  const auto way = map.route({-2, 4}, {2, 4}, {&robot, 1});
  ASSERT_TRUE(way);
  for (const Vec2& p : *way) EXPECT_GE(distance(p, robot.around), 0.5);
  const Keepout at_goal{{{2.1, 4}, {2.1, 4}}, 0.5};
  EXPECT_FALSE(map.route({-2, 4}, {2, 4}, {&at_goal, 1}));
}

TEST(FloorMap, WaysKeepTheirDistanceFromKeepoutsOnAllSides) {
  RandomStream random(1, "keepouts");
  FloorMap map{FloorPlan{}};
  int ways = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec2 middle(random.uniform(-4, 4), random.uniform(2.5, 5.5));
    const Keepout robot{{middle, middle + Vec2(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3))},
                        random.uniform(0.3, 0.9)};
    const double angle = random.uniform(-3.14, 3.14), turn = random.uniform(2, 4);
    const auto beside = [&](double a) -> Vec2 { return middle + 1.6 * Vec2(std::cos(a), std::sin(a)); };
    const auto way = map.route(beside(angle), beside(angle + turn), {&robot, 1});
    if (!way) continue;
    ++ways;
    for (std::size_t k = 1; k < way->size(); ++k)
      for (const double part : {0.0, 0.25, 0.5, 0.75})
        ASSERT_GE(distance(between((*way)[k - 1], (*way)[k], part), robot.around), robot.radius - 0.012) << i;
  }
  EXPECT_EQ(ways, 100);
}

TEST(FloorMap, AKeepoutInWhichAWayBeginsShrinks) {
  FloorMap map{FloorPlan{}};
  const Keepout robot{{{0, 4}, {0, 4}}, 0.5};
  const auto way = map.route({0.45, 4}, {3, 4}, {&robot, 1});
  ASSERT_TRUE(way);
  for (const Vec2& p : *way) EXPECT_GE(distance(p, robot.around), 0.44);
}

TEST(FloorMap, AWayOutOfAKeepoutComesNoNearer) {
  FloorMap map{FloorPlan{}};
  const Keepout robot{{{0, 4}, {0, 4}}, 0.5};
  const auto way = map.route({0.45, 4}, {-0.6, 4}, {&robot, 1});
  ASSERT_TRUE(way);
  for (std::size_t i = 1; i < way->size(); ++i)
    for (const double part : {0.0, 0.5}) EXPECT_GE(distance(between((*way)[i - 1], (*way)[i], part), Vec2(0, 4)), 0.44);
}

TEST(FloorMap, WaysOutOfWorkplacesAreAsLongAsTheyWere) {
  struct Row {
    Pose2 machine;
    Vec2 from;  ///< of the machine's face
    double length;
  };
  for (const auto& [machine, from, wanted] :
       {Row{{0.0339, 4.0221, 2.3654}, {0.2259, -0.0643}, 2.318}, Row{{0.0717, 4.0224, 0.6145}, {0.2065, 0.0281}, 2.286},
        Row{{0.0702, 4.0553, -2.5670}, {0.1951, 0.3711}, 1.682}}) {
    FloorPlan plan;
    plan.stations = {{"A", "BS", machine, true}};
    FloorMap map(plan);
    const Vec3 begin = transform(machine, Vec3(0.175 + from.x(), from.y(), 0));
    const Vec3 behind = transform(machine, Vec3(-1, from.y(), 0));
    const auto way = map.route({begin.x(), begin.y()}, {behind.x(), behind.y()}, {});
    ASSERT_TRUE(way);
    EXPECT_NEAR(length(*way), wanted, 0.01) << machine.yaw;
  }
}

TEST(FloorMap, LessThanAMetreIsDrivenStraightAlsoPastTheEndOfAWall) {
  FloorPlan plan;
  plan.walls = {{{0, 0}, {0, 4 - 0.025 - 0.27}}};
  FloorMap map(plan);
  const auto furthest = [&](double length) {
    const auto way = map.route({-length / 2, 4}, {length / 2, 4}, {});
    EXPECT_TRUE(way);
    double most = 0;
    for (const Vec2& p : *way) most = std::max(most, p.y() - 4);
    return most;
  };
  EXPECT_NEAR(furthest(0.98), 0, 1e-9);
  EXPECT_GT(furthest(1.02), 0.02) << "more room costs less";
}

TEST(FloorMap, NearestStopsAtItsLimit) {
  FloorMap map{FloorPlan{}};
  const auto beyond = [](double x) { return [x](const Vec2& p) { return p.x() > x; }; };
  const auto found = map.nearest({0, 4}, {}, 2.5, beyond(1.95));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->x(), 2, 1e-9);
  EXPECT_NEAR(found->y(), 4, 1e-9);
  EXPECT_FALSE(map.nearest({0, 4}, {}, 1.5, beyond(1.95)));
  const Keepout all_around{{{-3, 4}, {3, 4}}, 1};
  EXPECT_TRUE(map.nearest({0, 4}, {&all_around, 1}, 5, kAnywhere)) << "it shrinks, too";
}

TEST(FloorMap, ARobotInANarrowPlaceIsInTheWay) {
  FloorPlan plan;
  plan.walls = {{{-2, 3.5}, {2, 3.5}}, {{-2, 4.5}, {2, 4.5}}};
  const FloorMap map(plan);
  EXPECT_FALSE(map.passable_around({0, 4})) << "in a corridor of 1 m";
  EXPECT_TRUE(map.passable_around({0, 6.2}));
}

}  // namespace
}  // namespace cxlab::sim
