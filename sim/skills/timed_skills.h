#pragma once
// The skills without physics: drives take as long as the planned motion, handling takes a drawn time, failures are
// drawn.

#include <optional>

#include "cx/base/random.h"
#include "sim/skills/skill.h"
#include "sim/skills/timed_config.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

class TimedSkills final : public RobotSkills {
 public:
  /// Draws from streams of this robot alone: what the others do moves none of its draws. World, book and traffic
  /// outlive it.
  TimedSkills(RobotId robot, const WorldView& world, RobotBook& book, Traffic& traffic, const TimedSkillsConfig& config,
              std::uint64_t seed);

  void start(const SkillGoal& goal, SimTime now) override;
  void cancel(SimTime now) override;
  void abandon(SimTime) override { active_ = false; }
  void resume(SimTime) override {}  // a robot in the book has no momentum: it is where it was to be
  std::optional<SkillResult> sense(SimTime now) override;
  void act(SimTime now) override;
  void drop(SimTime) override { book_.drop(robot_); }
  SkillPhase phase() const override { return phase_; }
  std::optional<RobotId> waits_for(SimTime now) const override { return traffic_.waits_for(robot_, now); }
  SkillKind part() const override { return goal_.kind; }
  double remaining(SimTime now) const override { return traffic_.remaining(robot_, now); }
  SimTime next_due() const override;

 private:
  SkillResult end(SkillCode code, SimTime now);
  std::optional<SkillCode> obstacle() const;
  void begin(const SkillGoal& goal, SimTime now);
  SimTime drawn_duration(SimTime now);
  /// It stands before the spot: what hinders it ends it.
  std::optional<SkillResult> begin_handling(SimTime now);
  SkillCode handle();

  RobotId robot_;
  const WorldView& world_;
  RobotBook& book_;
  Traffic& traffic_;
  TimedSkillsConfig config_;
  RandomStream durations_;
  RandomStream drives_;
  RandomStream failures_;
  SkillGoal goal_;
  std::optional<SkillGoal> next_;  ///< the second part of a transport
  bool blended_ = false;           ///< a part of a transport
  SimTime begun_{};
  SimTime wait_until_{};      ///< for the piece
  Vec2 zone_ = Vec2::Zero();  ///< that is explored
  bool active_ = false;
  SkillPhase phase_ = SkillPhase::kDrive;
  SimTime due_ = kNever;  ///< of the time-out, or of the end of handling
  std::uint32_t motions_ = 0;
};

}  // namespace cxlab::sim
