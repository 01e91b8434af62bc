#pragma once
// Plans the motions of all robots of a floor. Each motion is planned in space and time against all motions that are
// already decided, up to where those end, so that robots neither touch nor block each other.
//
// Rules: the oldest request is planned first. A robot that stands without work, or waits for its way, steps aside when
// another one needs its place. Others wait for a robot that works or drives, at a place nearby that leaves a way
// around.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/traffic/floor_map.h"
#include "sim/traffic/trajectory.h"

namespace cxlab::sim {

class Traffic {
 public:
  explicit Traffic(const FloorPlan& plan, const DriveLimits& limits = {});

  // --- Wishes of a robot. It has one request at a time; a new one replaces the old, and ends its work.
  /// The robot wants to stand at `goal`. With `work`, it then works within that footprint until its next wish, and
  /// nobody comes near.
  void request(RobotId robot, const Pose2& goal, std::optional<Segment> work, SimTime now);
  /// Ends the request, or the work at its goal; a robot that drives for it brakes.
  void withdraw(RobotId robot, SimTime now);
  /// Where the robot really is. If that is far from its planned motion, the robot brakes and gets a new plan.
  void observe(RobotId robot, const Pose2& pose, SimTime now);
  /// The robot drives at that share of its speed from now on; at 0 it stands where it is, and others drive around it.
  void set_speed(RobotId robot, double share, SimTime now);
  /// Motions that are planned from now on take so many times as long (> 0).
  void stretch(RobotId robot, double times) { at(robot).stretch = times; }
  /// The robot was halted on its way and stands there: its request gets a new plan.
  void halted(RobotId robot, const Pose2& pose, SimTime now);
  /// People have put the robot there: it stands, without a request, and others brake that would meet it.
  void set_down(RobotId robot, const Pose2& pose, SimTime now);

  /// Once a tick, before anybody asks: ends the motions that are over.
  void settle(SimTime now);
  /// Once a tick, after the wishes: plans the motions that are wanted.
  void plan(SimTime now);
  /// When there is something to settle or to plan.
  SimTime next_due() const;

  // --- Queries
  /// The request is fulfilled (and the robot works there, if the request had `work`).
  bool arrived(RobotId robot) const { return at(robot).arrived; }
  /// There is no way to the request's goal, wherever the other robots stand.
  bool unreachable(RobotId robot) const { return at(robot).unreachable; }
  bool working(RobotId robot) const { return at(robot).working; }
  bool moving(RobotId robot) const { return at(robot).moving; }
  /// The robot has a request and stands, because others are in the way.
  bool waiting(RobotId robot, SimTime now) const {
    return at(robot).wants && (!at(robot).moving || now < at(robot).motion.start());
  }
  /// The robot that is in the way of one that waits; nothing if a fault holds that one up.
  std::optional<RobotId> waits_for(RobotId robot, SimTime now) const {
    return waiting(robot, now) ? at(robot).blocked_by : std::nullopt;
  }
  /// The current motion, or the last one; nullptr before the first.
  const Trajectory* motion(RobotId robot) const { return at(robot).motion.empty() ? nullptr : &at(robot).motion; }
  /// Grows with each new motion of the robot.
  std::uint32_t motion_number(RobotId robot) const { return at(robot).motions; }
  /// Metres to go: along the motion to the goal, else as the crow flies.
  double remaining(RobotId robot, SimTime now) const;
  /// The place nearest to `centre`, at most `radius` m from it, that keeps clear of fixed things.
  std::optional<Vec2> standing_place(const Vec2& centre, double radius) const;
  double clearance(const Vec2& p) const { return map_.clearance(p); }
  /// The place that `accept` takes which is nearest to drive to, on a grid of 0.1 m, as if no other robot were there.
  std::optional<Vec2> nearest_place(const Vec2& from, const std::function<bool(const Vec2&)>& accept) {
    return map_.nearest(from, {}, kFarthestPlace, accept);
  }

 private:
  static constexpr double kFarthestPlace = 40;  // m: more than across the field
  enum class Purpose : std::uint8_t { kGoal, kQueue, kYield, kBrake };
  struct Robot {
    Pose2 pose;    ///< observed, or the end of its last motion
    Segment rest;  ///< where it is, or will be when its motion is over
    bool working = false;
    bool moving = false;
    Trajectory motion;
    std::uint32_t motions = 0;
    Purpose purpose = Purpose::kGoal;
    SimTime idle_since{};
    bool wants = false;  ///< has a request that is not fulfilled
    bool arrived = false;
    bool unreachable = false;
    Pose2 goal;
    std::optional<Segment> work;
    std::uint64_t order = 0;  ///< of the request
    std::optional<std::size_t>
        yields_to;  ///< the robot whose way it left; it drives back only after that one has passed
    SimTime yields_until{};
    std::optional<RobotId> blocked_by;  ///< who it would meet or whose place it needs, at the last attempt
    double speed = 1;                   ///< share of the limits
    double stretch = 1;                 ///< of the time of its motions
  };

  const Robot& at(RobotId id) const { return robots_[index_of(id)]; }
  Robot& at(RobotId id) { return robots_[index_of(id)]; }

  Segment footprint_at_goal(const Robot& robot) const;
  DriveLimits limits_of(const Robot& robot) const;
  bool movable(const Robot& robot, SimTime now) const;
  /// Rests of the robots other than `except` for which `only` holds.
  template <class Only>
  std::vector<Keepout> rests(std::size_t except, Only only) const;
  /// The robot among these whose rest comes first on the way; if none lies on it, the nearest.
  template <class Only>
  std::optional<RobotId> first_on(std::span<const Vec2> way, std::size_t except, Only only) const;
  std::vector<Keepout> rests(std::size_t except) const;

  void attempt(std::size_t robot, SimTime now);
  bool commit(std::size_t robot, std::span<const Vec2> way, double yaw, const Segment& rest, Purpose purpose,
              SimTime now);
  /// The shortest delay after which the motion meets nobody, or nothing. Notes the last one that it would meet before.
  std::optional<SimTime> delay_of(std::size_t robot, Trajectory& motion, const Segment& rest, SimTime now);
  /// The first robot that the motion would meet.
  std::optional<RobotId> met_by(std::size_t robot, const Trajectory& motion, const Segment& rest, SimTime now) const;
  static bool meets(const Trajectory& motion, const Segment& rest, const Robot& other, SimTime now);
  bool drive_to_goal(std::size_t robot, SimTime now);
  void queue(std::size_t robot, SimTime now);
  /// Sends a robot to a place off the way; if others enclose it, these first.
  bool displace(std::size_t robot, std::span<const Vec2> way, const Segment& end, std::size_t for_robot,
                std::size_t depth, SimTime now);
  std::optional<std::vector<Vec2>> way_aside(std::size_t robot, std::span<const Keepout> keepouts,
                                             std::span<const Vec2> way, const Segment& end);
  void brake(std::size_t robot, SimTime now);
  /// Robots that would meet this one, as it moves or stands now.
  void brake_others(std::size_t robot, SimTime now);
  void stand(std::size_t robot, SimTime now);

  FloorMap map_;
  DriveLimits limits_;
  std::vector<Segment> workplaces_;  ///< of all spots: no place to wait
  std::vector<Robot> robots_;
  std::uint64_t last_order_ = 0;
  bool changed_ = true;
  SimTime retry_at_ = kNever;
};

}  // namespace cxlab::sim
