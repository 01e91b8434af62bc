#pragma once
// Scripted robots for tests: feed-back driving and the motions of a pick and a put, one robot at a time.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/mujoco/mujoco_world.h"

namespace cxlab::sim {

class Rig {
 public:
  explicit Rig(MujocoWorld& driven) : world(driven) {}

  void wait(double seconds) {
    for (int n = static_cast<int>(std::lround(seconds / 0.02)); n > 0; --n) tick();
  }

  void drive_to(RobotId robot, const Pose2& goal, double timeout = 30) {
    for (double t = 0; t < timeout; t += 0.02) {
      const RobotState state = world.robot(robot);
      const Pose2& here = state.pose_in_world;
      const double dx = goal.x - here.x, dy = goal.y - here.y, turn = wrap_angle(goal.yaw - here.yaw);
      const double distance = std::hypot(dx, dy);
      if (distance < 0.0008 && std::abs(turn) < 0.002 && std::hypot(state.vx, state.vy) < 0.002) break;
      const double speed = std::min(0.7, 2.0 * distance) / std::max(distance, 1e-9);
      world.command_base(robot, speed * dx, speed * dy, 3.0 * turn);
      tick();
    }
    world.command_base(robot, 0, 0, 0);
  }

  /// Puts the gripper's frame over a point that is given in the robot's frame.
  void reach(RobotId robot, double forward, double left, double up) {
    world.command_gripper(robot, {forward - 0.139, left, up});
    for (int n = 0; n < 500; ++n) {
      tick();
      const Vec3 g = world.robot(robot).gripper;
      if (std::abs(g.x() - forward + 0.139) < 0.0005 && std::abs(g.y() - left) < 0.0005 &&
          std::abs(g.z() - up) < 0.0008)
        return;
    }
  }

  Vec3 seen_by(RobotId robot, const Vec3& point) { return inverse_transform(world.robot(robot).pose_in_world, point); }
  Vec3 rest(SpotId id) { return world.plan().spot(id).rest_in_world; }

  void pick(RobotId robot, SpotId from) {
    const Spot& spot = world.plan().spot(from);
    drive_to(robot, spot.align_in_world);
    world.command_fingers(robot, 0.035);
    world.command_gripper(robot, {0, 0, kUp});
    drive_to(robot, spot.work_in_world);
    const Vec3 there = seen_by(robot, rest(from));
    reach(robot, there.x(), there.y(), kUp);
    reach(robot, there.x(), there.y(), 0.010);
    world.command_fingers(robot, -0.010);
    wait(0.8);
    reach(robot, there.x(), there.y(), kUp);
    world.command_gripper(robot, {0, 0, kUp});
    drive_to(robot, spot.align_in_world);
    wait(1.0);
  }

  void put(RobotId robot, SpotId to) {
    const Spot& spot = world.plan().spot(to);
    drive_to(robot, spot.align_in_world);
    drive_to(robot, spot.work_in_world);
    const Vec3 there = seen_by(robot, rest(to));
    reach(robot, there.x(), there.y(), kUp);
    reach(robot, there.x(), there.y(), spot.kind == SpotKind::kSlide ? 0.022 : 0.0115);
    world.command_fingers(robot, 0.035);
    wait(0.8);
    reach(robot, there.x(), there.y(), kUp);
    world.command_gripper(robot, {0, 0, kUp});
    drive_to(robot, spot.align_in_world);
  }

  void tick() {
    const Status status = world.advance(std::chrono::milliseconds(20));
    ASSERT_TRUE(status.ok()) << status.error().text();
    for (const HolderChange& change : world.changes()) history.push_back(change);
  }

  /// "belt gripper slide": the holders that a piece came to, in order.
  std::string life(PieceId piece) const {
    std::string words;
    for (const HolderChange& change : history)
      if (change.piece == piece) words += (words.empty() ? "" : " ") + std::string(to_string(change.to));
    return words;
  }

  static constexpr double kUp = 0.055;
  MujocoWorld& world;
  std::vector<HolderChange> history;
};

}  // namespace cxlab::sim
