#pragma once
// The skills with motors: follow the planned motion, line up, reach, close or open the fingers, back off. Everything is
// commanded through RobotBodies and seen through WorldView.

#include <cstdint>
#include <optional>

#include "sim/skills/skill.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

class PhysicsSkills final : public RobotSkills {
 public:
  /// All outlive it.
  PhysicsSkills(RobotId robot, const WorldView& world, RobotBodies& bodies, Traffic& traffic);

  void start(const SkillGoal& goal, SimTime now) override;
  void cancel(SimTime now) override;
  void abandon(SimTime now) override;
  void resume(SimTime now) override;
  std::optional<SkillResult> sense(SimTime now) override;
  void act(SimTime now) override;
  void drop(SimTime now) override;
  SkillPhase phase() const override { return phase_; }
  std::optional<RobotId> waits_for(SimTime now) const override { return traffic_.waits_for(robot_, now); }
  SkillKind part() const override { return goal_.kind; }
  double remaining(SimTime now) const override { return traffic_.remaining(robot_, now); }
  SimTime next_due() const override { return now_; }  // a stepped world is looked at each tick

 private:
  void begin(const SkillGoal& goal, SimTime now);
  void enter(SkillPhase phase, SimTime now);
  SkillResult end(SkillCode code, SimTime now);
  std::optional<SkillResult> sense_drive(SimTime now);
  std::optional<SkillResult> sense_work(SimTime now);
  std::optional<SkillResult> verify(SimTime now);
  std::optional<SkillCode> obstacle() const;
  bool occupied() const;
  std::optional<SkillResult> give_up(SkillCode code, SimTime now);

  bool base_at(const Pose2& pose, double along, double yaw) const;
  bool gripper_at(const Vec3& axes) const;
  /// Where the robot handles the piece.
  const Pose2& work_pose() const { return spot_ ? spot_->work_in_world : goal_.pose; }
  /// Axes that bring the underside of a held piece to that point of the world, seen from where the robot is.
  Vec3 axes_for(const Vec3& point_in_world, const Pose2& robot_in_world) const;
  /// Where the piece is to be gripped, or put so that it comes to rest on the spot.
  Vec3 reach_axes(const Pose2& robot_in_world, double above) const;
  /// The same while the base and the arm come in.
  Vec3 approach_axes(const Pose2& robot_in_world) const;
  /// Height over the rest at which the fingers close or open.
  double lowest() const;
  void steer_along(const Trajectory& motion, SimTime now);
  void steer_to(const Pose2& pose, double speed);
  void hold_still();
  void move_gripper(const Vec3& axes);
  void move_fingers(double opening);

  RobotId robot_;
  const WorldView& world_;
  RobotBodies& bodies_;
  Traffic& traffic_;
  SimTime now_{};
  RobotState state_;

  SkillGoal goal_;
  std::optional<SkillGoal> next_;  ///< the second part of a transport
  bool blended_ = false;           ///< a part of a transport
  SimTime looking_since_ = kNever;
  Vec2 zone_ = Vec2::Zero();  ///< that is explored
  const Spot* spot_ = nullptr;
  bool active_ = false;
  bool cancelled_ = false;
  SkillCode failure_ = SkillCode::kNone;  ///< the result, once the robot has backed off
  SkillPhase phase_ = SkillPhase::kDrive;
  SimTime started_{}, entered_{};
  SimTime waited_{};  ///< for the piece
  int tries_ = 0;
  std::optional<PieceId> piece_;        ///< in hand, or wanted
  Vec3 carried_offset_ = Vec3::Zero();  ///< of the held piece's underside from the gripper, in the robot's frame
  Vec3 gripper_goal_ = Vec3::Zero();
  double fingers_goal_ = kRobot.fingers_open;
  bool commanded_ = false;  ///< the base was commanded to move, and not yet to stand
};

}  // namespace cxlab::sim
