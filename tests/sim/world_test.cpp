#include "sim/world.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace cxlab::sim {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Angles, AreWrappedIntoTheHalfOpenCircle) {
  EXPECT_DOUBLE_EQ(wrap_angle(-kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap_angle(kPi), kPi);
  EXPECT_NEAR(wrap_angle(2.5 * kPi), 0.5 * kPi, 1e-12);
  EXPECT_NEAR(wrap_angle(-1.5 * kPi), 0.5 * kPi, 1e-12);
}

TEST(Frames, TransformAndItsInverseCancel) {
  const Pose2 frame{1, 2, 0.7};
  const Vec3 there = transform(frame, {0.3, -0.4, 0.9});
  const Vec3 back = inverse_transform(frame, there);
  EXPECT_NEAR(back.x(), 0.3, 1e-12);
  EXPECT_NEAR(back.y(), -0.4, 1e-12);
  EXPECT_DOUBLE_EQ(back.z(), 0.9);
}

TEST(FloorClock, StandsWhileItIsHalted) {
  using std::chrono::seconds;
  FloorClock clock;
  EXPECT_EQ(clock.at(seconds(7)), seconds(7));
  EXPECT_EQ(clock.when(kNever), kNever);
  clock.halt(seconds(10));
  EXPECT_TRUE(clock.halted());
  EXPECT_EQ(clock.at(seconds(25)), seconds(10));
  EXPECT_EQ(clock.when(seconds(9)), seconds(9));
  EXPECT_EQ(clock.when(seconds(10)), kNever);
  clock.go_on(seconds(15));
  EXPECT_FALSE(clock.halted());
  clock.halt(seconds(20));
  clock.go_on(seconds(23));
  for (const auto& [simulated, shown] : {std::pair{9, 9}, {10, 10}, {12, 10}, {16, 11}, {20, 15}, {22, 15}, {24, 16}})
    EXPECT_EQ(clock.at(seconds(simulated)), seconds(shown)) << simulated;
  for (const auto& [shown, simulated] : {std::pair{9, 9}, {10, 15}, {14, 19}, {15, 23}, {16, 24}})
    EXPECT_EQ(clock.when(seconds(shown)), seconds(simulated)) << shown;
  EXPECT_EQ(clock.when(kNever), kNever);
}

TEST(Spots, RobotAtTheInputFacesTheMachineInLineWithTheBelt) {
  // Turned by 90 degrees, the machine's input looks along +y and its left is -x.
  const Station station{"C-CS1", "CS", {3.5, 4.5, kPi / 2}, true};
  const auto spots = spots_of(station, StationId{0});
  ASSERT_EQ(spots.size(), 5u);
  EXPECT_EQ(spots[0].name, "C-CS1-INPUT");
  EXPECT_NEAR(spots[0].work_in_world.x, 3.525, 1e-12);
  EXPECT_NEAR(spots[0].work_in_world.y, 4.5 + 0.175 + 0.33, 1e-12);
  EXPECT_NEAR(spots[0].work_in_world.yaw, -kPi / 2, 1e-12);
  EXPECT_NEAR(spots[1].align_in_world.y, 4.5 - 0.175 - 0.50, 1e-12);
  EXPECT_NEAR(spots[1].align_in_world.yaw, kPi / 2, 1e-12);
}

TEST(Spots, DependOnTheKindOfMachine) {
  const auto names = [](const char* kind) {
    std::string all;
    for (const Spot& spot : spots_of({"M", kind, {}, true}, StationId{3})) all += spot.name + " ";
    return all;
  };
  EXPECT_EQ(names("BS"), "M-INPUT M-OUTPUT ");
  EXPECT_EQ(names("DS"), "M-INPUT ");
  EXPECT_EQ(names("RS"), "M-INPUT M-OUTPUT M-SLIDE ");
  EXPECT_EQ(names("CS"), "M-INPUT M-OUTPUT M-SHELF-LEFT M-SHELF-MIDDLE M-SHELF-RIGHT ");
}

/// What the models do not have, so that no world compares it at its start.
TEST(Geometry, HasTheMeasuresOfTheDocumentation) {
  EXPECT_EQ(kField.half_length, 7);
  EXPECT_EQ(kField.width, 8);
  EXPECT_EQ(kWall.half_thickness, 0.025);
  EXPECT_EQ(kWall.half_height, 0.25);
  EXPECT_EQ(kMachine.belt_rest_x, 0.155);
  EXPECT_EQ(kMachine.processing_x, 0);
  EXPECT_EQ(kMachine.slide_rest_x, 0.145);
  EXPECT_EQ(kMachine.slide_counted_x, 0.100);
  EXPECT_EQ(kStanding.align, 0.50);
  EXPECT_EQ(kStanding.belt, 0.33);
  EXPECT_EQ(kStanding.shelf, 0.30);
  EXPECT_EQ(kSpotTolerance.along_belt, 0.010);
  EXPECT_EQ(kSpotTolerance.across_belt, 0.015);
  EXPECT_EQ(kSpotTolerance.shelf, 0.040);
  EXPECT_EQ(kSpotTolerance.height, 0.030);
  EXPECT_EQ(kPiece.cap_height, 0.004);
  EXPECT_EQ(kPiece.part_mass, 0.005);
  EXPECT_NEAR(kRobot.carried_height, kRobot.home_height + kRobot.up_stroke, 1e-12);
  EXPECT_EQ(kRobot.fingers_squeeze, -0.010);
}

TEST(FloorPlan, FindsByName) {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {}, true}, {"C-DS", "DS", {}, true}};
  plan.robots = {{"R1", {}}};
  plan.spots = spots_of(plan.stations[1], StationId{1});
  EXPECT_EQ(plan.find_station("C-DS"), StationId{1});
  EXPECT_EQ(plan.find_spot("C-DS-INPUT"), SpotId{0});
  EXPECT_EQ(plan.find_spot("C-DS-OUTPUT"), std::nullopt);
}

}  // namespace
}  // namespace cxlab::sim
