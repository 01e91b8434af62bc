#pragma once
// What a robot sees of machines, and from where.
//
// Its lasers see bodies in all directions: a scan has a ray each degree, so ten rays or so meet the face of a machine 4
// m away. Its camera looks ahead and reads the markers below the belt. A marker is 135 mm wide and has 7 x 7 fields.
// The camera has 320 columns over 60 degrees, so a field has 3.5 columns at 1.5 m. When the robot turns fast, a field
// is smeared over more than one of its width.

#include <numbers>
#include <optional>

#include "sim/traffic/traffic.h"
#include "sim/world.h"

namespace cxlab::sim {

inline constexpr double kLaserRange = 4;                                                           ///< m
inline constexpr double kMarkerRange = 1.5;                                                        ///< m
inline constexpr double kCameraAngle = std::numbers::pi / 6, kMarkerAngle = std::numbers::pi / 3;  ///< to either side
inline constexpr double kReadingTurn = 0.5;                                                        ///< rad/s

/// Whether the lasers of a robot there see the station: nothing stands between.
bool sees_body(const FloorPlan& plan, const Vec2& robot, StationId station);
/// Whether the camera of a robot there, turning no faster than kReadingTurn, can read the marker at input or output.
bool reads_marker(const FloorPlan& plan, const Pose2& robot, StationId station);

/// The station whose middle is in the zone of 1 x 1 m around that point.
std::optional<StationId> station_in_zone(const FloorPlan& plan, const Vec2& zone);

/// The nearest place, by the robot's way to it, from which the robot can see the zone; the robot faces the zone there.
/// The place is 1 to 1.5 m from the middle of the zone, it is free of other robots, and no machine or wall hides the
/// zone. If a machine stands in the zone, the robot can read one of its markers there. Nothing if no such place exists.
std::optional<Pose2> lookout(const WorldView& world, Traffic& traffic, RobotId robot, const Vec2& zone);

}  // namespace cxlab::sim
