#include "sim/mujoco/robot_motors.h"

#include <algorithm>
#include <cmath>

namespace cxlab::sim {
namespace {

constexpr double kMaxSpeed = 0.7, kMaxAcceleration = 0.4, kMaxBraking = 1.5;         // m/s, m/s2
constexpr double kMaxTurn = 1.4, kMaxTurnAcceleration = 1.6, kMaxTurnBraking = 3.2;  // rad/s, rad/s2
constexpr double kAxisSpeed = 0.1;                                                   // m/s, also of the fingers

double approach(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

void limit_norm(Vec2& vector, double most) {
  if (const double norm = vector.norm(); norm > most) vector *= most / norm;
}

}  // namespace

void RobotMotors::command_base(RobotId robot, const Vec2& velocity, double omega) {
  Motors& m = motors_[index_of(robot)];
  m.want_velocity = velocity;
  limit_norm(m.want_velocity, kMaxSpeed);
  m.want_omega = std::clamp(omega, -kMaxTurn, kMaxTurn);
}

void RobotMotors::command_fingers(RobotId robot, double opening) {
  motors_[index_of(robot)].want_opening = std::clamp(opening, kRobot.fingers_squeeze, kRobot.fingers_widest);
}

void RobotMotors::stand(RobotId robot) {
  Motors& m = motors_[index_of(robot)];
  m.want_velocity = m.velocity = Vec2::Zero();
  m.want_omega = m.omega = 0;
}

void RobotMotors::ramp(Motors& m, double dt) {
  const double fastest = std::min(kMaxSpeed, m.velocity.norm() + kMaxAcceleration * dt);
  Vec2 change = m.want_velocity - m.velocity;
  limit_norm(change, kMaxBraking * dt);
  m.velocity += change;
  limit_norm(m.velocity, fastest);
  const bool faster = std::abs(m.want_omega) > std::abs(m.omega) && m.want_omega * m.omega >= 0;
  m.omega = approach(m.omega, m.want_omega, (faster ? kMaxTurnAcceleration : kMaxTurnBraking) * dt);
  for (int i = 0; i < 3; ++i) m.axes[i] = approach(m.axes[i], m.want_axes[i], kAxisSpeed * dt);
  m.opening = approach(m.opening, m.want_opening, kAxisSpeed * dt);
}

void RobotMotors::brake(Motors& m, double dt) {
  Motors standing;
  standing.velocity = m.velocity;
  standing.omega = m.omega;
  ramp(standing, dt);
  m.velocity = standing.velocity;
  m.omega = standing.omega;
}

void RobotMotors::drive(PhysicsGate& gate, double dt) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    Motors& m = motors_[i];
    held_ ? brake(m, dt) : ramp(m, dt);
    const auto& actuator = gate.factory().robots[i].actuator;
    gate.control(actuator[kAxisX], m.velocity.x());
    gate.control(actuator[kAxisY], m.velocity.y());
    gate.control(actuator[kAxisYaw], m.omega);
    gate.control(actuator[kAxisForward], m.axes.x());
    gate.control(actuator[kAxisLeft], m.axes.y());
    gate.control(actuator[kAxisUp], m.axes.z());
    gate.control(actuator[kAxisFingerLeft], kRobot.fingers_open - m.opening);
    gate.control(actuator[kAxisFingerRight], kRobot.fingers_open - m.opening);
  }
}

}  // namespace cxlab::sim
