#pragma once
// The skills without physics: drives take as long as the planned motion, handling takes a drawn time, failures are
// drawn.

#include <optional>

#include "cx/base/expected.h"
#include "cx/base/random.h"
#include "sim/skills/skill.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

/// How long handling takes, and how often skills fail. Every duration is at least `shortest_s`.
struct TimedSkillsConfig {
  double pick_mean_s = 15.5;  ///< from standing before the spot to standing there again
  double pick_sigma_s = 0.4;
  double place_mean_s = 15.3;
  double place_sigma_s = 0.6;
  double shortest_s = 2.0;
  double drive_failure = 0;  ///< probability a drive_to that it ends with 201, where it should have ended well
  double pick_failure = 0;   ///< a pick: 206, the piece stays
  double place_failure = 0;  ///< a place: 204, the piece stays in the gripper

  template <class Keys>
  void fields(Keys& keys) {
    keys("pick_mean_s", pick_mean_s);
    keys("pick_sigma_s", pick_sigma_s);
    keys("place_mean_s", place_mean_s);
    keys("place_sigma_s", place_sigma_s);
    keys("shortest_s", shortest_s);
    keys("drive_failure", drive_failure);
    keys("pick_failure", pick_failure);
    keys("place_failure", place_failure);
  }
};
/// Probabilities lie in 0..1, times are positive.
Status validate(const TimedSkillsConfig& config);

class TimedSkills final : public RobotSkills {
 public:
  /// Draws from streams of this robot alone: what the others do moves none of its draws. World, book and traffic
  /// outlive it.
  TimedSkills(RobotId robot, const WorldView& world, RobotBook& book, Traffic& traffic, const TimedSkillsConfig& config,
              std::uint64_t seed);

  void start(const SkillGoal& goal, SimTime now) override;
  void cancel(SimTime now) override;
  std::optional<SkillResult> sense(SimTime now) override;
  void act(SimTime now) override;
  void drop(SimTime) override { book_.drop(robot_); }
  SkillPhase phase() const override { return phase_; }
  double remaining(SimTime now) const override { return traffic_.remaining(robot_, now); }
  SimTime next_due() const override;

 private:
  SkillResult end(SkillCode code, SimTime now);
  std::optional<SkillCode> obstacle() const;
  SkillCode handle();

  RobotId robot_;
  const WorldView& world_;
  RobotBook& book_;
  Traffic& traffic_;
  TimedSkillsConfig config_;
  RandomStream durations_;
  RandomStream failures_;
  SkillGoal goal_;
  bool active_ = false;
  SkillPhase phase_ = SkillPhase::kDrive;
  SimTime due_ = kNever;  ///< of the time-out, or of the end of handling
  std::uint32_t motions_ = 0;
};

}  // namespace cxlab::sim
