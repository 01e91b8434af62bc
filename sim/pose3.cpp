#include "sim/pose3.h"

#include <cmath>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

bool upright(const Pose3& pose) { return pose.rotation.x() == 0 && pose.rotation.y() == 0; }

Eigen::Quaterniond quaternion(const Vec3& rotation) {
  const double angle = rotation.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle));
}

Vec3 rotation_of(const Eigen::Quaterniond& quaternion) {
  const Eigen::AngleAxisd turn(quaternion);
  return wrap_angle(turn.angle()) * turn.axis();
}

}  // namespace

double Pose3::yaw() const {
  if (rotation.x() == 0 && rotation.y() == 0) return wrap_angle(rotation.z());
  const Vec3 ahead = quaternion(rotation) * Vec3::UnitX();
  return wrap_angle(std::atan2(ahead.y(), ahead.x()));
}

Pose3 compose(const Pose3& frame, const Pose3& local) {
  const Eigen::Quaterniond turn = quaternion(frame.rotation);
  const Vec3 position = frame.position + turn * local.position;
  if (upright(frame) && upright(local)) return {position, {0, 0, wrap_angle(frame.rotation.z() + local.rotation.z())}};
  return {position, rotation_of(turn * quaternion(local.rotation))};
}

Pose3 relative_to(const Pose3& frame, const Pose3& pose) {
  const Eigen::Quaterniond back = quaternion(frame.rotation).conjugate();
  const Vec3 position = back * (pose.position - frame.position);
  if (upright(frame) && upright(pose)) return {position, {0, 0, wrap_angle(pose.rotation.z() - frame.rotation.z())}};
  return {position, rotation_of(back * quaternion(pose.rotation))};
}

}  // namespace cxlab::sim
