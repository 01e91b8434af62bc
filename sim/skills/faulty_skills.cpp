#include "sim/skills/faulty_skills.h"

#include <algorithm>

namespace cxlab::sim {
namespace {

bool is_about_robots(FaultKind kind) { return kind <= FaultKind::kPieceDropped; }

SkillCode code_of(const Fault& fault, SkillKind skill) {
  if (fault.error != 0) return static_cast<SkillCode>(fault.error);
  switch (skill) {
    case SkillKind::kDriveTo: return SkillCode::kUnableToMove;
    case SkillKind::kPick: return SkillCode::kGraspFailed;
    case SkillKind::kPlace:
    case SkillKind::kDiscard: return SkillCode::kSensorDisagreement;
  }
  return SkillCode::kInternal;
}

}  // namespace

FaultySkills::FaultySkills(std::unique_ptr<RobotSkills> skills, RobotId robot, const WorldView& world,
                           std::span<const Fault> faults, std::uint64_t seed, RecordSink& sink)
    : skills_(std::move(skills)),
      robot_(robot),
      name_(world.plan().robots[static_cast<std::size_t>(robot)].name),
      world_(world),
      sink_(sink) {
  for (const Fault& fault : faults)
    if (is_about_robots(fault.kind) && (fault.robot.empty() || fault.robot == name_))
      timers_.emplace_back(fault, seed, name_);
}

void FaultySkills::record(const Fault& fault, SimTime now) {
  data_.begin()
      .field("fault", to_string(fault.kind))
      .field("number", static_cast<std::int64_t>(fault.number))
      .field("robot", name_);
  sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data_);
}

const Fault* FaultySkills::striking(FaultKind kind, const SkillGoal& goal, SimTime now) {
  for (FaultTimer& timer : timers_) {
    const Fault& fault = timer.fault();
    if (fault.kind != kind || (!fault.skill.empty() && fault.skill != to_string(goal.kind))) continue;
    if (timer.strikes_occasion(now)) return &fault;
  }
  return nullptr;
}

void FaultySkills::start(const SkillGoal& goal, SimTime now) {
  goal_ = goal;
  begins_at_ = fails_at_ = kNever;
  broken_off_ = cancelled_ = false;
  failing_ = striking(FaultKind::kSkillFails, goal, now);
  if (failing_) fails_at_ = now + failing_->after;
  if (const Fault* stall = striking(FaultKind::kSkillStalls, goal, now)) {
    begins_at_ = now + stall->duration;
    record(*stall, now);
  } else {
    skills_->start(goal, now);
  }
}

void FaultySkills::cancel(SimTime now) {
  cancelled_ = true;
  if (!stalled() && !broken_off_) skills_->cancel(now);
}

std::optional<SkillResult> FaultySkills::sense(SimTime now) {
  if (stalled() && cancelled_) {
    begins_at_ = fails_at_ = kNever;
    (void)skills_->sense(now);
    return SkillResult::cancel();
  }
  if (now >= fails_at_ && !cancelled_) {
    record(*failing_, now);
    fails_at_ = kNever;
    if (stalled()) {
      begins_at_ = kNever;
      (void)skills_->sense(now);
      return SkillResult::of(code_of(*failing_, goal_.kind));
    }
    broken_off_ = true;
    skills_->cancel(now);
  }
  if (now >= begins_at_) {
    begins_at_ = kNever;
    skills_->start(goal_, now);
  }
  drop_due(now);
  std::optional<SkillResult> result = skills_->sense(now);
  drop_due(now);  // of what has just been taken
  if (!result) return result;
  fails_at_ = kNever;
  if (broken_off_ && result->cancelled) result = SkillResult::of(code_of(*failing_, goal_.kind));
  return result;
}

void FaultySkills::drop_due(SimTime now) {
  for (FaultTimer& timer : timers_) {
    if (timer.fault().kind != FaultKind::kPieceDropped || now < timer.due() || !world_.robot(robot_).held) continue;
    record(timer.fault(), now);
    timer.struck(now);
    skills_->drop(now);
  }
}

SimTime FaultySkills::next_due() const {
  SimTime due = skills_->next_due();
  if (!cancelled_) due = std::min(due, fails_at_);
  due = std::min(due, begins_at_);
  if (world_.robot(robot_).held)
    for (const FaultTimer& timer : timers_)
      if (timer.fault().kind == FaultKind::kPieceDropped) due = std::min(due, timer.due());
  return due;
}

}  // namespace cxlab::sim
