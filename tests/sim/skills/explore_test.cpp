// What a robot sees of machines from where.

#include "sim/skills/explore.h"

#include <gtest/gtest.h>

#include "sim/ledger/ledger_world.h"
#include "sim/skills/destination.h"

namespace cxlab::sim {
namespace {

constexpr StationId kMachine0{0};
constexpr double kBelt = kMachine.belt_y, kDegree = std::numbers::pi / 180;

/// A machine at the origin, input to +x.
FloorPlan one_machine(std::vector<Segment> walls = {}) {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {0, 0, 0}, true}};
  plan.walls = std::move(walls);
  return plan;
}

/// `way` m from the marker at the input, `aside` degrees off the straight line before it, looking `off` degrees past
/// it.
Pose2 before_input(double way, double aside = 0, double off = 0) {
  const double a = aside * kDegree;
  return {kMachine.half_depth + way * std::cos(a), kBelt + way * std::sin(a),
          wrap_angle(a + std::numbers::pi + off * kDegree)};
}

TEST(Explore, AMarkerIsReadNearAndAhead) {
  const FloorPlan plan = one_machine();
  EXPECT_TRUE(reads_marker(plan, before_input(1.49), kMachine0));
  EXPECT_FALSE(reads_marker(plan, before_input(1.51), kMachine0));
  EXPECT_TRUE(reads_marker(plan, before_input(1, 59), kMachine0));
  EXPECT_FALSE(reads_marker(plan, before_input(1, 61), kMachine0)) << "seen too flat";
  EXPECT_TRUE(reads_marker(plan, before_input(1, -59), kMachine0));
  EXPECT_TRUE(reads_marker(plan, before_input(1, 0, 29), kMachine0));
  EXPECT_FALSE(reads_marker(plan, before_input(1, 0, 31), kMachine0)) << "not in the picture";
  EXPECT_FALSE(reads_marker(plan, before_input(1, 0, -31), kMachine0));
}

TEST(Explore, TheMarkerAtTheOutputIsAsGood) {
  const FloorPlan plan = one_machine();
  EXPECT_TRUE(reads_marker(plan, {-kMachine.half_depth - 1.49, kBelt, 0}, kMachine0));
  EXPECT_FALSE(reads_marker(plan, {-kMachine.half_depth - 1.51, kBelt, 0}, kMachine0));
  EXPECT_FALSE(reads_marker(plan, {0, 1, -std::numbers::pi / 2}, kMachine0)) << "there is none at the sides";
}

TEST(Explore, ABodyIsSeenFromAllSides) {
  const FloorPlan plan = one_machine();
  for (const Vec2& place : {Vec2(3.99, 0), Vec2(0, 3.99), Vec2(-2.8, -2.8)})
    EXPECT_TRUE(sees_body(plan, place, kMachine0));
  EXPECT_FALSE(sees_body(plan, {4.01, 0}, kMachine0));
}

TEST(Explore, AWallHides) {
  const FloorPlan plan = one_machine({{{0.9, -1}, {0.9, 1}}});
  EXPECT_FALSE(reads_marker(plan, before_input(1), kMachine0));
  EXPECT_TRUE(reads_marker(plan, before_input(0.6), kMachine0)) << "before the wall";
  EXPECT_FALSE(sees_body(plan, {3, 0}, kMachine0));
  EXPECT_TRUE(sees_body(plan, {-3, 0}, kMachine0));
}

/// From where robot1 looks at the empty zone around (3.5, 3.5), and where it stands before.
std::optional<Pose2> lookout_of(const Vec2& robot1, const Vec2& robot2) {
  FloorPlan plan = one_machine();
  plan.robots = {{"robot1", {robot1.x(), robot1.y(), 0}}, {"robot2", {robot2.x(), robot2.y(), 0}}};
  const LedgerWorld world(plan);
  Traffic traffic(plan);
  return lookout(world, traffic, RobotId{0}, {3.5, 3.5});
}

TEST(Explore, ARobotLooksFromNearTheZoneButNotFromInsideIt) {
  constexpr double kRounded = 1e-9;
  const Vec2 zone(3.5, 3.5), away(-3, -3);
  for (const double from : {0.0, 0.5, 0.9, 1.1, 1.4, 1.6, 3.0}) {
    const auto place = lookout_of({zone.x() + from, zone.y()}, away);
    ASSERT_TRUE(place) << from;
    const double way = distance(place->position(), zone);
    EXPECT_GE(way, 1.0 - kRounded) << from;
    EXPECT_LE(way, 1.5 + kRounded) << from;
    const bool stays = distance(place->position(), {zone.x() + from, zone.y()}) < kRounded;
    EXPECT_EQ(stays, from > 1.0 && from < 1.5) << from;
  }
}

TEST(Explore, AZoneIsASquareMetre) {
  const FloorPlan plan = one_machine();
  for (const auto& [zone, in] :
       {std::pair{Vec2(0.45, 0.45), true}, {Vec2(-0.45, 0.45), true}, {Vec2(0.55, 0), false}, {Vec2(0, -0.55), false}})
    EXPECT_EQ(station_in_zone(plan, zone).has_value(), in) << zone.transpose();
}

TEST(Explore, OnlyADriveNeedsNoGroundAtItsGoal) {
  FloorPlan plan = one_machine();
  plan.spots = spots_of(plan.stations[0], kMachine0);
  plan.robots = {{"robot1", {4, 4, 0}}};
  LedgerWorld world(plan);
  Traffic traffic(plan);
  for (const SkillKind kind :
       {SkillKind::kDriveTo, SkillKind::kPick, SkillKind::kPlace, SkillKind::kDiscard, SkillKind::kExplore}) {
    const SkillGoal goal{kind, "A", SpotId{0}, {3, 3, 0}};
    EXPECT_EQ(destination_of(goal, world, traffic, RobotId{0}).ground.has_value(), kind != SkillKind::kDriveTo)
        << to_string(kind);
  }
}

TEST(Explore, ARobotLooksFromBesideAnother) {
  const Vec2 here(4.7, 3.5), too_near(4.2, 3.5), near(4.7, 4.2);
  const auto aside = lookout_of(here, too_near);
  ASSERT_TRUE(aside);
  EXPECT_GE(distance(aside->position(), too_near), 0.6);
  const auto stays = lookout_of(here, near);
  ASSERT_TRUE(stays);
  EXPECT_NEAR(distance(stays->position(), here), 0, 1e-9);
}

}  // namespace
}  // namespace cxlab::sim
