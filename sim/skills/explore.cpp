#include "sim/skills/explore.h"

#include <cmath>
#include <numbers>

namespace cxlab::sim {
namespace {

constexpr double kHalfZone = 0.5;
constexpr double kNearest = 1.0, kFarthest = 1.5;  // m from the middle of a zone
constexpr double kRobotGap = 0.6;                  // m between robots that stand
constexpr double kSightStep = 0.05, kSightGap = 0.05;

/// Whether nothing stands between the place and the zone.
bool sees(const FloorPlan& plan, const Vec2& place, const Vec2& zone) {
  const double way = distance(place, zone), outside = way - std::numbers::sqrt2 * kHalfZone;
  for (double s = 0; s < outside; s += kSightStep)
    if (plan.clearance(between(place, zone, s / way)) < kSightGap) return false;
  return true;
}

}  // namespace

std::optional<StationId> station_in_zone(const FloorPlan& plan, const Vec2& zone) {
  for (std::size_t i = 0; i < plan.stations.size(); ++i) {
    const Vec2 off = plan.stations[i].pose_in_world.position() - zone;
    if (off.cwiseAbs().maxCoeff() < kHalfZone) return static_cast<StationId>(i);
  }
  return std::nullopt;
}

std::optional<Pose2> lookout(const WorldView& world, Traffic& traffic, RobotId robot, const Vec2& zone) {
  const FloorPlan& plan = world.plan();
  const auto suits = [&](const Vec2& p) {
    if (distance(p, zone) < kNearest || distance(p, zone) > kFarthest) return false;
    for (std::size_t i = 0; i < plan.robots.size(); ++i)
      if (static_cast<RobotId>(i) != robot &&
          distance(world.robot(static_cast<RobotId>(i)).pose_in_world.position(), p) < kRobotGap)
        return false;
    return sees(plan, p, zone);
  };
  const Vec2 here = world.robot(robot).pose_in_world.position();
  const auto place = suits(here) ? std::optional(here) : traffic.nearest_place(here, suits);
  if (!place) return std::nullopt;
  return Pose2{place->x(), place->y(), std::atan2(zone.y() - place->y(), zone.x() - place->x())};
}

}  // namespace cxlab::sim
