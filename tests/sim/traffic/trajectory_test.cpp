#include "sim/traffic/trajectory.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace cxlab::sim::trajectory_test {
namespace {

constexpr double kPi = std::numbers::pi;
SimTime s(double seconds) { return from_seconds(seconds); }

std::vector<Vec2> line(double length) {
  std::vector<Vec2> way;
  for (int i = 0; i <= 10 * length; ++i) way.push_back({0.1 * i, 0});
  return way;
}

TEST(Trajectory, SpeedsUpSlowlyAndBrakesFaster) {
  const Trajectory motion(line(4), 0, 0, {});
  EXPECT_NEAR(motion.length(), 4, 1e-9);
  EXPECT_NEAR(motion.speed_at(s(0.5)), 0.36 * 0.5, 0.03);
  EXPECT_NEAR(motion.speed_at(s(4)), 0.50, 1e-6);
  EXPECT_NEAR(motion.speed_at(motion.end() - s(0.25)), 1.0 * 0.25, 0.08) << "the end is a whole number of steps";
  // Up to 0.5 m/s in 0.35 m, down from it in 0.125 m.
  EXPECT_NEAR(to_seconds(motion.duration()), 0.5 / 0.36 + 0.5 / 1.0 + (4 - 0.347 - 0.125) / 0.5, 0.1);
}

TEST(Trajectory, CurvesAreDrivenSlowly) {
  std::vector<Vec2> circle;
  const double radius = 0.3;
  for (int i = 0; i <= 40; ++i) circle.push_back(radius * Vec2(std::cos(0.1 * i), std::sin(0.1 * i)));
  const Trajectory motion(circle, 0, 0, {});
  EXPECT_NEAR(motion.speed_at(motion.duration() / 2), std::sqrt(0.35 * radius), 0.01);
}

TEST(Trajectory, ACornerIsDrivenAtATenthOfAMetrePerSecond) {
  const Trajectory corner(std::vector<Vec2>{{-0.02, 0}, {0, 0}, {0, 0.02}}, 0, 0, {});
  EXPECT_NEAR(to_seconds(corner.duration()), 2 * 0.02 / (0.5 * 0.1), 1e-9);
}

TEST(Trajectory, TurnsByTheShorterSideWithinItsLimits) {
  const Trajectory motion(line(4), 0.75 * kPi, -0.75 * kPi, {});
  double fastest = 0;
  for (SimTime t{}; t < motion.end(); t += Trajectory::kStep) {
    const double turned = wrap_angle(motion.at(t + Trajectory::kStep).yaw - motion.at(t).yaw);
    EXPECT_GE(turned, -1e-9) << "to the left, over pi";
    fastest = std::max(fastest, turned / 0.05);
  }
  EXPECT_NEAR(fastest, 0.9, 0.02);
  EXPECT_NEAR(motion.last().yaw, -0.75 * kPi, 1e-9);
}

TEST(Trajectory, ATurnOnTheSpotTakesItsTime) {
  const Trajectory motion(std::vector<Vec2>{{1, 1}, {1, 1}}, 0, kPi, {});
  EXPECT_NEAR(to_seconds(motion.duration()), kPi / 0.9 + 0.9 / 1.2, 0.06);
}

TEST(Trajectory, StandsBeforeItsStartAndAfterItsEnd) {
  Trajectory motion(line(1), 0, 0, {});
  motion.begin_at(s(10));
  EXPECT_EQ(motion.at(s(3)).x, 0);
  EXPECT_EQ(motion.point_at(s(100)), Vec2(1, 0));
  EXPECT_EQ(motion.speed_at(s(3)), 0);
  EXPECT_EQ(motion.speed_at(motion.end()), 0);
  EXPECT_NEAR(motion.at(motion.start() + s(1)).x, 0.5 * 0.36, 0.01);
}

TEST(Trajectory, BrakesOnItsWay) {
  const Trajectory motion(line(4), 0, 0, {});
  const Trajectory braked = motion.braked(s(4), {});
  const double from = motion.at(s(4)).x;
  EXPECT_EQ(braked.start(), s(4));
  EXPECT_NEAR(braked.at(s(4)).x, from, 1e-9);
  EXPECT_NEAR(to_seconds(braked.duration()), 0.5, 0.051);
  EXPECT_NEAR(braked.last().x - from, 0.5 * 0.5 * 0.5, 0.01);
  EXPECT_NEAR(braked.length(), 0.125, 0.01);
}

}  // namespace
}  // namespace cxlab::sim::trajectory_test
