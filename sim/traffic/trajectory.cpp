#include "sim/traffic/trajectory.h"

#include <algorithm>
#include <cmath>

namespace cxlab::sim {
namespace {

constexpr double kStepSeconds = 0.05;

/// How far one has turned after t seconds, of `angle` > 0, with equal ramps.
double turned(double t, double angle, const DriveLimits& limits) {
  const double ramp = std::min(limits.turn / limits.turn_up, std::sqrt(angle / limits.turn_up));
  const double rate = ramp * limits.turn_up;
  const double total = angle / rate + ramp;
  if (t <= 0) return 0;
  if (t >= total) return angle;
  if (t < ramp) return 0.5 * limits.turn_up * t * t;
  if (t > total - ramp) return angle - 0.5 * limits.turn_up * (total - t) * (total - t);
  return rate * (t - 0.5 * ramp);
}

double turn_time(double angle, const DriveLimits& limits) {
  if (angle <= 0) return 0;
  const double ramp = std::min(limits.turn / limits.turn_up, std::sqrt(angle / limits.turn_up));
  return angle / (ramp * limits.turn_up) + ramp;
}

/// 1 / radius of the circle through three points.
double curvature(Point2 a, Point2 b, Point2 c) {
  const double ab = distance(a, b), bc = distance(b, c), ca = distance(c, a);
  const double product = ab * bc * ca;
  if (product < 1e-12) return 0;
  return 2 * std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / product;
}

}  // namespace

Trajectory::Trajectory(std::span<const Point2> way, double yaw_from, double yaw_to, const DriveLimits& limits) {
  const std::size_t n = way.size();
  std::vector<double> reached(n, 0), speed(n, limits.speed), when(n, 0);
  for (std::size_t i = 1; i < n; ++i) reached[i] = reached[i - 1] + distance(way[i - 1], way[i]);
  length_ = reached.back();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double bend = curvature(way[i - 1], way[i], way[i + 1]);
    if (bend > 0) speed[i] = std::min(speed[i], std::max(0.1, std::sqrt(limits.sideways / bend)));
  }
  speed.front() = speed.back() = 0;
  for (std::size_t i = 1; i < n; ++i)
    speed[i] = std::min(speed[i],
                        std::sqrt(speed[i - 1] * speed[i - 1] + 2 * limits.speed_up * (reached[i] - reached[i - 1])));
  for (std::size_t i = n - 1; i-- > 0;)
    speed[i] = std::min(speed[i],
                        std::sqrt(speed[i + 1] * speed[i + 1] + 2 * limits.slow_down * (reached[i + 1] - reached[i])));
  for (std::size_t i = 1; i < n; ++i) {
    const double ds = reached[i] - reached[i - 1];
    if (ds <= 0) {
      when[i] = when[i - 1];
      continue;
    }
    const double mean = 0.5 * (speed[i - 1] + speed[i]);
    // A piece between two standing ends is driven by speeding up and slowing down within it.
    const double peak = std::sqrt(2 * ds / (1 / limits.speed_up + 1 / limits.slow_down));
    when[i] = when[i - 1] + ds / (mean > 0 ? mean : 0.5 * peak);
  }

  const double turn = wrap_angle(yaw_to - yaw_from);
  const double total = std::max(when.back(), turn_time(std::abs(turn), limits));
  const auto steps = static_cast<std::size_t>(std::ceil(total / kStepSeconds - 1e-9));
  poses_.reserve(steps + 1);
  std::size_t i = 1;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) * kStepSeconds;
    while (i < n && when[i] <= t) ++i;
    Point2 p = way.back();
    if (i < n) {
      const double span = when[i] - when[i - 1], u = t - when[i - 1];
      const double gained = (speed[i] - speed[i - 1]) / span;
      const double ds = reached[i] - reached[i - 1];
      double driven = speed[i - 1] * u + 0.5 * gained * u * u;
      if (speed[i - 1] + speed[i] <= 0) driven = ds * (u / span) * (u / span) * (3 - 2 * u / span);
      p = between(way[i - 1], way[i], std::clamp(driven / ds, 0.0, 1.0));
    }
    const double yaw = yaw_from + std::copysign(turned(t, std::abs(turn), limits), turn);
    poses_.push_back({p.x, p.y, wrap_angle(yaw)});
  }
  poses_.back() = {way.back().x, way.back().y, wrap_angle(yaw_to)};
}

Pose2 Trajectory::at(SimTime t) const {
  if (t <= start_) return poses_.front();
  if (t >= end()) return poses_.back();
  const auto i = static_cast<std::size_t>((t - start_) / kStep);
  const double f = static_cast<double>(((t - start_) % kStep).count()) / static_cast<double>(kStep.count());
  const Pose2 &a = poses_[i], &b = poses_[i + 1];
  return {a.x + f * (b.x - a.x), a.y + f * (b.y - a.y), wrap_angle(a.yaw + f * wrap_angle(b.yaw - a.yaw))};
}

Point2 Trajectory::point_at(SimTime t) const {
  if (t <= start_) return point_of(poses_.front());
  if (t >= end()) return point_of(poses_.back());
  const auto i = static_cast<std::size_t>((t - start_) / kStep);
  const double f = static_cast<double>(((t - start_) % kStep).count()) / static_cast<double>(kStep.count());
  return between(point_of(poses_[i]), point_of(poses_[i + 1]), f);
}

double Trajectory::speed_at(SimTime t) const {
  if (t < start_ || t >= end()) return 0;
  const auto i = static_cast<std::size_t>((t - start_) / kStep);
  return distance(point_of(poses_[i]), point_of(poses_[i + 1])) / kStepSeconds;
}

Trajectory Trajectory::braked(SimTime now, const DriveLimits& limits) const {
  // Time on the old trajectory runs slower and slower until it stands; turning stops with it.
  const double duration = std::max(0.4, speed_at(now) / limits.slow_down);
  const auto steps = static_cast<std::size_t>(std::ceil(duration / kStepSeconds));
  Trajectory rest;
  rest.start_ = now;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double t = std::min(duration, static_cast<double>(k) * kStepSeconds);
    rest.poses_.push_back(at(now + from_seconds(t - 0.5 * t * t / duration)));
    if (k > 0) rest.length_ += distance(point_of(rest.poses_[k - 1]), point_of(rest.poses_[k]));
  }
  return rest;
}

}  // namespace cxlab::sim
