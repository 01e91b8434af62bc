#pragma once
// From commands to motors: commands are wishes, the motors get ramps within the limits of speed and acceleration
// (docs/reference/models.md).

#include <vector>

#include "sim/mujoco/physics_gate.h"

namespace cxlab::sim {

class RobotMotors {
 public:
  explicit RobotMotors(std::size_t robots) : motors_(robots) {}

  // As in RobotBodies.
  void command_base(RobotId robot, const Vec2& velocity, double omega);
  void command_gripper(RobotId robot, const Vec3& axes) { motors_[index_of(robot)].want_axes = within_strokes(axes); }
  void command_fingers(RobotId robot, double opening);
  /// The base stands at once.
  void stand(RobotId robot);

  /// All robots brake and keep the axes of their grippers where they are, whatever they are asked to do.
  void hold(bool on) { held_ = on; }

  /// Writes the targets that all motors have for the next `dt` seconds.
  void drive(PhysicsGate& gate, double dt);

 private:
  /// What a robot was asked to do, and how far its ramps have come.
  struct Motors {
    Vec2 want_velocity = Vec2::Zero(), velocity = Vec2::Zero();  ///< in the world
    double want_omega = 0, omega = 0;
    Vec3 want_axes = Vec3::Zero(), axes = Vec3::Zero();
    double want_opening = kRobot.fingers_open, opening = kRobot.fingers_open;
  };
  static void ramp(Motors& motors, double dt);
  static void brake(Motors& motors, double dt);

  std::vector<Motors> motors_;  ///< by robot
  bool held_ = false;
};

}  // namespace cxlab::sim
