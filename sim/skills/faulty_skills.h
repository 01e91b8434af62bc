#pragma once
// The skills of a robot with the scenario's faults: between the server on the bus and the skills of either tier.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cx/base/record_sink.h"
#include "sim/faults/fault.h"
#include "sim/skills/skill.h"
#include "sim/traffic/traffic.h"

namespace cxlab::sim {

class FaultySkills final : public RobotSkills {
 public:
  /// Takes those of `faults` that are about this robot. Strikes are written to the stream "faults". World, traffic and
  /// sink outlive it.
  FaultySkills(std::unique_ptr<RobotSkills> skills, RobotId robot, const WorldView& world, Traffic& traffic,
               std::span<const Fault> faults, std::uint64_t seed, RecordSink& sink);

  void start(const SkillGoal& goal, SimTime now) override;
  void cancel(SimTime now) override;
  void abandon(SimTime now) override;
  void resume(SimTime now) override { skills_->resume(now); }
  std::optional<SkillResult> sense(SimTime now) override;
  void act(SimTime now) override { skills_->act(now); }
  void drop(SimTime now) override { skills_->drop(now); }
  SkillPhase phase() const override {
    return stalled() ? SkillPhase::kWait : searching() ? SkillPhase::kLook : skills_->phase();
  }
  std::optional<RobotId> waits_for(SimTime now) const override { return skills_->waits_for(now); }
  SkillKind part() const override { return !begun_ ? goal_.kind : astray_ ? leg_.kind : skills_->part(); }
  double remaining(SimTime now) const override { return stalled() ? 0 : skills_->remaining(now); }
  SimTime next_due() const override;

 private:
  bool stalled() const { return begins_at_ != kNever; }
  bool searching() const { return searches_until_ != kNever; }
  void forget();
  void begin(SimTime now);
  /// If pose noise strikes the leg that begins: the robot drives to where it takes the goal to be.
  bool goes_astray(SimTime now);
  void go_on(SimTime now);
  /// What the skill is worth that the robot does with a wrong pose; none while it goes on.
  std::optional<SkillResult> find_way(std::optional<SkillResult> result, SimTime now);
  FaultTimer* striking_timer(FaultKind kind, const SkillGoal& goal, SimTime now);
  /// The fault of that kind that strikes the skill now, if any.
  const Fault* striking(FaultKind kind, const SkillGoal& goal, SimTime now);
  SkillResult failure() const;
  /// The result, unless it is late.
  std::optional<SkillResult> deliver(std::optional<SkillResult> result, SimTime now);
  void limit_speed(SimTime now);
  void set_speed(SimTime now);
  void misplace(SimTime now);
  void record(const Fault& fault, SimTime now);
  void drop_due(SimTime now);

  std::unique_ptr<RobotSkills> skills_;
  RobotId robot_;
  std::string name_;
  const WorldView& world_;
  Traffic& traffic_;
  RecordSink& sink_;
  std::vector<FaultTimer> timers_;

  SkillGoal goal_;
  SkillGoal leg_;               // the skill, or the second part of a transport
  SimTime begins_at_ = kNever;  // of a skill that is stalled
  SimTime fails_at_ = kNever;
  bool begun_ = false;   // not as long as it is stalled, and never if its goal was lost
  bool astray_ = false;  // drives to a wrong pose, or searches there
  SimTime searches_until_ = kNever;
  const Fault* failing_ = nullptr;
  bool broken_off_ = false, cancelled_ = false;
  const Fault* misplacing_ = nullptr;
  bool misplaced_ = false;
  std::optional<SkillResult> late_;
  SimTime late_until_ = kNever;
  const Fault* slip_ = nullptr;
  std::optional<PieceId> slipping_;
  SimTime slips_at_ = kNever;
  SimTime halted_until_{}, slow_until_{};
  double slow_ = 1, speed_ = 1;  // shares: while it is slow, and now
  RecordData data_;
};

}  // namespace cxlab::sim
