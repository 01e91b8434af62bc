#include "sim/skills/explore.h"

#include <cmath>
#include <numbers>

namespace cxlab::sim {
namespace {

constexpr double kHalfZone = 0.5;
constexpr double kNearest = 1.0, kFarthest = 1.5;  // m from the middle of a zone
constexpr double kRobotGap = 0.6;                  // m between robots that stand
constexpr double kSightGap = 0.05;                 // m of free floor around a line of sight
constexpr double kBeforeMarker = 0.1;              // m from a marker: the face that it is on does not hide it

/// Whether nothing stands in the first `length` m of the way from one place to the other.
bool free_sight(const FloorPlan& plan, const Vec2& from, const Vec2& to, double length) {
  const double way = distance(from, to);
  for (double s = 0; s < length;) {
    const double gap = plan.clearance(between(from, to, s / way));
    if (gap < kSightGap) return false;
    s += gap;
  }
  return true;
}

/// Whether nothing hides the zone.
bool sees_zone(const FloorPlan& plan, const Vec2& place, const Vec2& zone) {
  return free_sight(plan, place, zone, distance(place, zone) - std::numbers::sqrt2 * kHalfZone);
}

}  // namespace

bool sees_body(const FloorPlan& plan, const Vec2& robot, StationId station) {
  const Vec2 body = plan.station(station).pose_in_world.position();
  return distance(robot, body) <= kLaserRange && sees_zone(plan, robot, body);
}

bool reads_marker(const FloorPlan& plan, const Pose2& robot, StationId station) {
  const Pose2& machine = plan.station(station).pose_in_world;
  const Vec3 seen_from = inverse_transform(machine, {robot.x, robot.y, 0});  // the face towards the robot
  const double face = seen_from.x() > 0 ? kMachine.half_depth : -kMachine.half_depth;
  const Vec3 marker = transform(machine, {face, kMachine.belt_y, 0});
  const Vec2 sight = marker.head<2>() - robot.position();
  const double way = sight.norm(), out = (seen_from.x() - face) / way * (face > 0 ? 1 : -1);
  return way <= kMarkerRange && out >= std::cos(kMarkerAngle) &&
         std::abs(wrap_angle(std::atan2(sight.y(), sight.x()) - robot.yaw)) <= kCameraAngle &&
         free_sight(plan, robot.position(), marker.head<2>(), way - kBeforeMarker);
}

std::optional<StationId> station_in_zone(const FloorPlan& plan, const Vec2& zone) {
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const Vec2 off = plan.stations[i].pose_in_world.position() - zone;
    if (off.cwiseAbs().maxCoeff() < kHalfZone) return static_cast<StationId>(i);
  }
  return std::nullopt;
}

std::optional<Pose2> lookout(const WorldView& world, Traffic& traffic, RobotId robot, const Vec2& zone) {
  const FloorPlan& plan = world.plan();
  const auto station = station_in_zone(plan, zone);
  const auto facing = [&](const Vec2& p) {
    return Pose2{p.x(), p.y(), std::atan2(zone.y() - p.y(), zone.x() - p.x())};
  };
  const auto suits = [&](const Vec2& p) {
    if (distance(p, zone) < kNearest || distance(p, zone) > kFarthest) return false;
    for (std::size_t i = 0; i < plan.robots.size(); ++i)
      if (static_cast<RobotId>(i) != robot &&
          distance(world.robot(static_cast<RobotId>(i)).pose_in_world.position(), p) < kRobotGap)
        return false;
    return sees_zone(plan, p, zone) && (!station || reads_marker(plan, facing(p), *station));
  };
  const Vec2 here = world.robot(robot).pose_in_world.position();
  const auto place = suits(here) ? std::optional(here) : traffic.nearest_place(here, suits);
  if (!place) return std::nullopt;
  return facing(*place);
}

}  // namespace cxlab::sim
