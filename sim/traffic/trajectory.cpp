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
double curvature(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double product = distance(a, b) * distance(b, c) * distance(c, a);
  if (product < 1e-12) return 0;
  const Vec2 ab = b - a, ac = c - a;
  return 2 * std::abs(ab.x() * ac.y() - ab.y() * ac.x()) / product;
}

}  // namespace

Trajectory::Trajectory(std::span<const Vec2> way, double yaw_from, double yaw_to, const DriveLimits& limits) {
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
    Vec2 p = way.back();
    if (i < n) {
      const double span = when[i] - when[i - 1], u = t - when[i - 1];
      const double gained = (speed[i] - speed[i - 1]) / span;
      const double ds = reached[i] - reached[i - 1];
      double driven = speed[i - 1] * u + 0.5 * gained * u * u;
      if (speed[i - 1] + speed[i] <= 0) driven = ds * (u / span) * (u / span) * (3 - 2 * u / span);
      p = between(way[i - 1], way[i], std::clamp(driven / ds, 0.0, 1.0));
    }
    const double yaw = yaw_from + std::copysign(turned(t, std::abs(turn), limits), turn);
    poses_.push_back({p.x(), p.y(), wrap_angle(yaw)});
  }
  poses_.back() = {way.back().x(), way.back().y(), wrap_angle(yaw_to)};
}

Trajectory::Place Trajectory::place_at(SimTime t) const {
  if (t < start_) return {poses_.front(), poses_.front(), 0};
  if (t >= end()) return {poses_.back(), poses_.back(), 0};
  const auto i = static_cast<std::size_t>((t - start_) / kStep);
  const double part = static_cast<double>(((t - start_) % kStep).count()) / static_cast<double>(kStep.count());
  return {poses_[i], poses_[i + 1], part};
}

Pose2 Trajectory::at(SimTime t) const {
  const auto& [before, after, part] = place_at(t);
  const Vec2 p = between(before.position(), after.position(), part);
  return {p.x(), p.y(), wrap_angle(before.yaw + part * wrap_angle(after.yaw - before.yaw))};
}

Vec2 Trajectory::point_at(SimTime t) const {
  const auto& [before, after, part] = place_at(t);
  return between(before.position(), after.position(), part);
}

double Trajectory::speed_at(SimTime t) const {
  const auto& [before, after, part] = place_at(t);
  return distance(before.position(), after.position()) / kStepSeconds;
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
    if (k > 0) rest.length_ += distance(rest.poses_[k - 1].position(), rest.poses_[k].position());
  }
  return rest;
}

}  // namespace cxlab::sim
