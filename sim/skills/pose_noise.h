#pragma once
// Errors of a drive when the robot is wrong about its own pose.

#include "sim/pose.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

/// Where a robot comes to stand that drives to `goal` and whose belief is off by `error`, in the directions of the
/// world. Its scanner keeps it off things: where it could not stand, or not drive straight on to the goal, it is off by
/// half, a quarter, or only turned.
Pose2 astray(const Pose2& goal, const Pose2& error, const Traffic& traffic);

/// Whether the camera of a robot there finds the spot before which it should stand at `align`.
bool in_sight(const Pose2& align, const Pose2& robot);

/// So long a robot looks for a spot before it gives up.
inline constexpr SimTime kSearchTime{8'000'000'000};

}  // namespace cxlab::sim
