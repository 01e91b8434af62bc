#pragma once
// Poses in space, and ways: where something that moves by itself will be.

#include "cx/base/time.h"
#include "sim/pose.h"

namespace cxlab::sim {

/// A pose in space, and the frame that has its origin there.
struct Pose3 {
  Vec3 position = Vec3::Zero();  ///< m
  Vec3 rotation = Vec3::Zero();  ///< axis times angle, rad; upright things turn about z alone
  /// Where its x axis points to, seen from above; rad (-pi, pi].
  double yaw() const;
};
inline Pose3 pose_in_space(const Pose2& on_floor, double z = 0) {
  return {{on_floor.x, on_floor.y, z}, {0, 0, on_floor.yaw}};
}
/// The pose `local` of that frame, seen from the frame in which `frame` is given.
Pose3 compose(const Pose3& frame, const Pose3& local);
/// The opposite of `compose`: `pose` seen from `frame`, both given in one frame.
Pose3 relative_to(const Pose3& frame, const Pose3& pose);

/// Something passes there then. From one point to the next it moves straight and turns evenly; before the first and
/// after the last it stands.
struct WayPoint {
  SimTime t{};
  Pose3 pose;
};

}  // namespace cxlab::sim
