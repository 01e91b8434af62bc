#include "sim/pose.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

/// In this order, as `position + rotation * local` rounds differently: the bits of recorded runs hang on it.
Vec2 to_outer(const Pose2& frame, const Vec2& local) {
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(frame.yaw).toRotationMatrix();
  return frame.position() + rotation.col(0) * local.x() + rotation.col(1) * local.y();
}

}  // namespace

double wrap_angle(double a) {
  const double wrapped = std::remainder(a, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

int whole_degrees(double a) { return static_cast<int>(std::lround(a * 180 / std::numbers::pi) + 360) % 360; }

Pose2 compose(const Pose2& frame, const Pose2& local) {
  const Vec2 at = to_outer(frame, local.position());
  return {at.x(), at.y(), wrap_angle(frame.yaw + local.yaw)};
}

Vec3 transform(const Pose2& frame, const Vec3& local) {
  Vec3 point = local;
  point.head<2>() = to_outer(frame, local.head<2>());
  return point;
}

Vec3 inverse_transform(const Pose2& frame, const Vec3& point) {
  Vec3 local = point;
  local.head<2>() = Eigen::Rotation2Dd(frame.yaw).toRotationMatrix().transpose() * (point.head<2>() - frame.position());
  return local;
}

}  // namespace cxlab::sim
