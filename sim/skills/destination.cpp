#include "sim/skills/destination.h"

#include <algorithm>
#include <numbers>

#include "sim/geometry.h"
#include "sim/skills/explore.h"

namespace cxlab::sim {
namespace {

/// The place, turned as little as needed for what a robot there lets go of at arm's length to fall on free floor: away
/// from machines, walls and border. Where that is nowhere the case, to where there is most room.
Pose2 facing_free_floor(const FloorPlan& plan, const Pose2& place) {
  constexpr double kRoom = 0.30;  // m: a piece that falls from the gripper bounces and rolls
  constexpr int kTurns = 36;
  const auto room = [&](const Pose2& pose) {
    const Vec3 below = transform(pose, {kRobot.home_forward + kRobot.forward_stroke, 0, 0});
    const Vec2 at = below.head<2>();
    return std::min(
        {plan.clearance(at), at.x() - plan.min_x, plan.max_x - at.x(), at.y() - plan.min_y, plan.max_y - at.y()});
  };
  Pose2 best = place;
  for (int i = 0; i <= kTurns; ++i) {
    const double turn = (i % 2 == 0 ? 1 : -1) * ((i + 1) / 2) * 2 * std::numbers::pi / kTurns;
    const Pose2 turned{place.x, place.y, wrap_angle(place.yaw + turn)};
    if (room(turned) >= kRoom) return turned;
    if (room(turned) > room(best)) best = turned;
  }
  return best;
}

}  // namespace

Destination destination_of(const SkillGoal& goal, const WorldView& world, Traffic& traffic, RobotId robot) {
  const auto stands_at = [](const Pose2& pose) { return Destination{pose, Segment{pose.position(), pose.position()}}; };
  switch (goal.kind) {
    case SkillKind::kDriveTo: return {goal.pose, std::nullopt};
    case SkillKind::kDiscard:
      return stands_at(
          facing_free_floor(world.plan(), goal.target.empty() ? world.robot(robot).pose_in_world : goal.pose));
    case SkillKind::kExplore:
      return stands_at(lookout(world, traffic, robot, goal.pose.position()).value_or(goal.pose));
    case SkillKind::kPick:
    case SkillKind::kPlace:
    case SkillKind::kTransport: break;
  }
  return {goal.pose, world.plan().spot(*goal.spot).footprint()};
}

}  // namespace cxlab::sim
