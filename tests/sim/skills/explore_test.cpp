// What a robot sees of machines from where.

#include "sim/skills/explore.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cxlab::sim
