#pragma once
// What a robot sees of a zone, and from where.

#include <optional>

#include "sim/traffic/traffic.h"
#include "sim/world.h"

namespace cxlab::sim {

/// The station whose middle is in the zone of 1 x 1 m around that point.
std::optional<StationId> station_in_zone(const FloorPlan& plan, const Vec2& zone);

/// The place nearest to the robot, by the way it drives, that is free of other robots, 1 to 1.5 m from the middle of
/// the zone, and from which no machine or wall hides the zone; facing it. Nothing when there is no such place.
std::optional<Pose2> lookout(const WorldView& world, Traffic& traffic, RobotId robot, const Vec2& zone);

}  // namespace cxlab::sim
