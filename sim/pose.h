#pragma once
// Points, poses and segments, in metres and radians.

#include <algorithm>

#include <Eigen/Core>

namespace cxlab::sim {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

/// A pose on the floor, and the frame that has its origin there.
struct Pose2 {
  double x = 0, y = 0;  ///< m
  double yaw = 0;       ///< rad (-pi, pi]
  Vec2 position() const { return {x, y}; }
};
double wrap_angle(double a);  ///< into (-pi, pi]
int whole_degrees(double a);  ///< of an angle in [-pi, pi]: 0..359, rounded
/// The pose `local` of that frame, seen from the frame in which `frame` is given.
Pose2 compose(const Pose2& frame, const Pose2& local);
Vec3 transform(const Pose2& frame, const Vec3& local);
/// The opposite of `transform`.
Vec3 inverse_transform(const Pose2& frame, const Vec3& point);

/// A straight line from a to b; both may be the same point.
struct Segment {
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();
};
inline double distance(const Vec2& p, const Vec2& q) { return (p - q).norm(); }
/// `part` of the way from p to q, 0 to 1.
inline Vec2 between(const Vec2& p, const Vec2& q, double part) { return p + part * (q - p); }
inline double distance(const Vec2& p, const Segment& s) {
  const Vec2 along = s.b - s.a;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0 ? std::clamp((p - s.a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return distance(p, s.a + part * along);
}
/// Too large when the two cross; else exact.
inline double distance(const Segment& s, const Segment& t) {
  return std::min({distance(s.a, t), distance(s.b, t), distance(t.a, s), distance(t.b, s)});
}

}  // namespace cxlab::sim
