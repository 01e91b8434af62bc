#include "sim/skills/pose_noise.h"

#include <cmath>

namespace cxlab::sim {
namespace {

constexpr double kRoom = 0.25;                          ///< m: a robot's radius and a little more
constexpr double kSightRange = 0.35, kSightTurn = 0.5;  ///< m and rad off

bool has_room(const Traffic& traffic, const Vec2& from, const Vec2& to) {
  constexpr int kSamples = 10;
  for (int i = 1; i <= kSamples; ++i)
    if (traffic.clearance(between(from, to, static_cast<double>(i) / kSamples)) < kRoom) return false;
  return true;
}

}  // namespace

Pose2 astray(const Pose2& goal, const Pose2& error, const Traffic& traffic) {
  const double yaw = wrap_angle(goal.yaw + error.yaw);
  for (const double share : {1.0, 0.5, 0.25}) {
    const Vec2 there = goal.position() + share * error.position();
    if (has_room(traffic, goal.position(), there)) return {there.x(), there.y(), yaw};
  }
  return {goal.x, goal.y, yaw};
}

bool in_sight(const Pose2& align, const Pose2& robot) {
  return distance(align.position(), robot.position()) <= kSightRange &&
         std::abs(wrap_angle(align.yaw - robot.yaw)) <= kSightTurn;
}

}  // namespace cxlab::sim
