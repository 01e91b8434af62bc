#pragma once
// Where a robot will be at a time: a way with a speed profile that a real base can follow.

#include <span>
#include <vector>

#include "cx/base/time.h"
#include "sim/pose.h"

namespace cxlab::sim {

/// What a planned motion asks of a base: a little less than it can do, so that the controller can catch up.
struct DriveLimits {
  double speed = 0.50;     ///< m/s, of 0.7: what RCLL teams reckon with for a Robotino, whose rim runs at 0.59
  double speed_up = 0.36;  ///< m/s2, of 0.4
  double slow_down = 1.0;  ///< m/s2, of 1.5
  double sideways = 0.35;  ///< m/s2, centripetal in curves
  double turn = 0.9;       ///< rad/s, of 1.4: a held piece stays where it is
  double turn_up = 1.2;    ///< rad/s2, of 1.6 / 3.2
};

/// Poses at equal steps of time; before the first and after the last the robot stands.
class Trajectory {
 public:
  static constexpr SimTime kStep{50'000'000};

  Trajectory() = default;
  /// Along the way, turning from one yaw to the other by the shorter side from the start on.
  Trajectory(std::span<const Vec2> way, double yaw_from, double yaw_to, const DriveLimits& limits);

  /// The same motion, begun at that time.
  void begin_at(SimTime start) { start_ = start; }
  /// What remains when the robot brakes at `now`: it stays on the way and comes to rest.
  Trajectory braked(SimTime now, const DriveLimits& limits) const;

  SimTime start() const { return start_; }
  SimTime end() const { return start_ + kStep * static_cast<std::int64_t>(poses_.size() - 1); }
  SimTime duration() const { return end() - start_; }
  bool empty() const { return poses_.empty(); }
  Pose2 at(SimTime t) const;
  Vec2 point_at(SimTime t) const;
  double speed_at(SimTime t) const;
  const Pose2& last() const { return poses_.back(); }
  std::span<const Pose2> poses() const { return poses_; }
  double length() const { return length_; }

 private:
  /// Between two poses, or twice the same one where the robot stands.
  struct Place {
    const Pose2 &before, &after;
    double part;
  };
  Place place_at(SimTime t) const;

  SimTime start_{};
  std::vector<Pose2> poses_;
  double length_ = 0;
};

}  // namespace cxlab::sim
