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
  EXPECT_NEAR(back.x, 0.3, 1e-12);
  EXPECT_NEAR(back.y, -0.4, 1e-12);
  EXPECT_DOUBLE_EQ(back.z, 0.9);
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

TEST(FloorPlan, FindsByName) {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {}, true}, {"C-DS", "DS", {}, true}};
  plan.robots = {{"R1", {}}};
  plan.spots = spots_of(plan.stations[1], StationId{1});
  EXPECT_EQ(plan.find_station("C-DS"), StationId{1});
  EXPECT_EQ(plan.find_robot("R1"), RobotId{0});
  EXPECT_EQ(plan.find_spot("C-DS-INPUT"), SpotId{0});
  EXPECT_EQ(plan.find_spot("C-DS-OUTPUT"), std::nullopt);
}

}  // namespace
}  // namespace cxlab::sim
