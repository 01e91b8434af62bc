#include "sim/skills/faulty_skills.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "sim/skills/destination.h"
#include "sim/skills/pose_noise.h"

namespace cxlab::sim {
namespace {

constexpr SimTime kNoAnswer{10'000'000'000};  ///< after which a goal that was lost is aborted

bool is_about_robots(FaultKind kind) { return kind < FaultKind::kMachineBreaks; }

SkillCode code_of(const Fault& fault, SkillKind skill) {
  if (fault.error != 0) return static_cast<SkillCode>(fault.error);
  switch (skill) {
    case SkillKind::kDriveTo:
    case SkillKind::kExplore: return SkillCode::kUnableToMove;
    case SkillKind::kPick:
    case SkillKind::kTransport: return SkillCode::kGraspFailed;
    case SkillKind::kPlace:
    case SkillKind::kDiscard: return SkillCode::kSensorDisagreement;
  }
  return SkillCode::kInternal;
}

}  // namespace

FaultySkills::FaultySkills(std::unique_ptr<RobotSkills> skills, RobotId robot, const WorldView& world, Traffic& traffic,
                           std::span<const Fault> faults, std::uint64_t seed, RecordSink& sink)
    : skills_(std::move(skills)),
      robot_(robot),
      name_(world.plan().robots[static_cast<std::size_t>(robot)].name),
      world_(world),
      traffic_(traffic),
      sink_(sink) {
  for (const Fault& fault : faults)
    if (is_about_robots(fault.kind) && (fault.robot.empty() || fault.robot == name_))
      timers_.emplace_back(fault, seed, name_);
}

void FaultySkills::record(const Fault& fault, SimTime now) {
  begin_strike(data_, fault).field("robot", name_);
  sink_.write(sink_.open_stream("faults"), now, RecordKind::kControl, data_);
}

FaultTimer* FaultySkills::striking_timer(FaultKind kind, const SkillGoal& goal, SimTime now) {
  for (FaultTimer& timer : timers_) {
    const Fault& fault = timer.fault();
    if (fault.kind != kind || (!fault.skill.empty() && fault.skill != to_string(goal.kind))) continue;
    if (timer.strikes_occasion(now)) return &timer;
  }
  return nullptr;
}

const Fault* FaultySkills::striking(FaultKind kind, const SkillGoal& goal, SimTime now) {
  const FaultTimer* timer = striking_timer(kind, goal, now);
  return timer ? &timer->fault() : nullptr;
}

/// All that was to happen to the skill.
void FaultySkills::forget() {
  begins_at_ = fails_at_ = late_until_ = searches_until_ = kNever;
  begun_ = broken_off_ = cancelled_ = misplaced_ = astray_ = false;
  misplacing_ = nullptr;
  late_.reset();
}

void FaultySkills::abandon(SimTime now) {
  forget();
  halted_until_ = slow_until_ = {};
  set_speed(now);
  skills_->abandon(now);
}

void FaultySkills::start(const SkillGoal& goal, SimTime now) {
  goal_ = goal;
  forget();
  if (goal.kind == SkillKind::kPlace || goal.kind == SkillKind::kTransport)
    misplacing_ = striking(FaultKind::kPieceMisplaced, goal, now);
  failing_ = striking(FaultKind::kSkillFails, goal, now);
  if (failing_) fails_at_ = now + failing_->after;
  if (const Fault* lost = striking(FaultKind::kGoalLost, goal, now)) {
    failing_ = lost;
    fails_at_ = begins_at_ = now + kNoAnswer;
    record(*lost, now);
    return;
  }
  if (const Fault* stall = striking(FaultKind::kSkillStalls, goal, now)) {
    begins_at_ = now + stall->duration;
    record(*stall, now);
  } else {
    begin(now);
  }
}

void FaultySkills::begin(SimTime now) {
  begun_ = true;
  leg_ = goal_;
  if (!goes_astray(now)) skills_->start(goal_, now);
}

bool FaultySkills::goes_astray(SimTime now) {
  if (leg_.kind == SkillKind::kDiscard && leg_.target.empty()) return false;
  if (leg_.spot && in_sight(leg_.pose, world_.robot(robot_).pose_in_world)) return false;
  FaultTimer* noise = striking_timer(FaultKind::kPoseNoise, goal_, now);
  if (!noise) return false;
  const Fault& fault = noise->fault();
  Pose2 error;
  error.x = noise->draw(fault.sigma_m);
  error.y = noise->draw(fault.sigma_m);
  error.yaw = noise->draw(fault.sigma_deg * std::numbers::pi / 180);
  record(fault, now);
  astray_ = true;
  const Pose2 there =
      leg_.kind == SkillKind::kExplore ? destination_of(leg_, world_, traffic_, robot_).pose : leg_.pose;
  skills_->start({SkillKind::kDriveTo, leg_.target, leg_.spot, astray(there, error, traffic_)}, now);
  return true;
}

/// The leg goes on from where the robot has come to: a discard there, an explore at the nearest lookout.
void FaultySkills::go_on(SimTime now) {
  astray_ = false;
  SkillGoal leg = leg_;
  if (leg.kind == SkillKind::kDiscard) leg.target.clear();
  skills_->start(leg, now);
}

std::optional<SkillResult> FaultySkills::find_way(std::optional<SkillResult> result, SimTime now) {
  if (searching()) {
    if (cancelled_ || broken_off_)
      result = SkillResult::cancel();
    else if (now >= searches_until_)
      result = SkillResult::of(SkillCode::kUnableToMove);
  } else if (result && result->code == SkillCode::kNone && !result->cancelled && leg_.kind != SkillKind::kDriveTo) {
    result.reset();
    const bool needs_spot = leg_.kind != SkillKind::kDiscard && leg_.kind != SkillKind::kExplore;
    if (!needs_spot || in_sight(leg_.pose, world_.robot(robot_).pose_in_world))
      go_on(now);
    else
      searches_until_ = now + kSearchTime;
  }
  if (result) {
    astray_ = false;
    searches_until_ = kNever;
  }
  return result;
}

SkillResult FaultySkills::failure() const {
  if (failing_->kind == FaultKind::kGoalLost) return {SkillCode::kInternal, false, "no answer: the goal was lost"};
  return SkillResult::of(code_of(*failing_, goal_.kind));
}

void FaultySkills::cancel(SimTime now) {
  cancelled_ = true;
  if (stalled())
    begins_at_ = now;
  else if (searching())
    searches_until_ = now;
  else if (!broken_off_ && !late_)
    skills_->cancel(now);
}

std::optional<SkillResult> FaultySkills::sense(SimTime now) {
  limit_speed(now);
  if (stalled() && cancelled_) {
    forget();
    (void)skills_->sense(now);
    return SkillResult::cancel();
  }
  if (now >= fails_at_ && !cancelled_) {
    if (failing_->kind == FaultKind::kSkillFails) record(*failing_, now);
    if (stalled()) {
      forget();
      (void)skills_->sense(now);
      return failure();
    }
    fails_at_ = kNever;
    broken_off_ = true;
    if (!searching()) skills_->cancel(now);
  }
  if (now >= begins_at_) {
    begins_at_ = kNever;
    begin(now);
  }
  drop_due(now);
  const bool picks = !stalled() && skills_->part() == SkillKind::kPick;
  std::optional<SkillResult> result = skills_->sense(now);
  if (astray_) result = find_way(std::move(result), now);
  misplace(now);
  const bool picked =
      picks && (result ? !result->cancelled && result->code == SkillCode::kNone : skills_->part() == SkillKind::kPlace);
  if (picked && !result) {
    leg_ = second_part(goal_, world_.plan());
    (void)goes_astray(now);
  }
  if (result) {
    misplacing_ = nullptr;
    fails_at_ = kNever;
    if (misplaced_ && !result->cancelled) result = SkillResult::of(SkillCode::kSensorDisagreement);
    if (broken_off_ && result->cancelled) result = failure();
  }
  if (picked && world_.robot(robot_).held) {
    if (const Fault* slip = striking(FaultKind::kGraspSlips, goal_, now)) {
      slip_ = slip;
      slipping_ = world_.robot(robot_).held;
      slips_at_ = now + slip->after;
    }
  }
  drop_due(now);  // also a piece that was taken in this tick
  return deliver(std::move(result), now);
}

std::optional<SkillResult> FaultySkills::deliver(std::optional<SkillResult> result, SimTime now) {
  if (late_ && now >= late_until_) {
    late_until_ = kNever;
    return std::exchange(late_, std::nullopt);
  }
  if (!result || result->cancelled) return result;
  const Fault* fault = striking(FaultKind::kResultLate, goal_, now);
  if (!fault) return result;
  record(*fault, now);
  late_ = std::move(result);
  late_until_ = now + fault->duration;
  return std::nullopt;
}

/// Once the robot is before the machine and reaches out, the piece falls.
void FaultySkills::misplace(SimTime now) {
  const SkillPhase phase = skills_->phase();
  if (!misplacing_ || stalled() || skills_->part() != SkillKind::kPlace ||
      (phase != SkillPhase::kApproach && phase != SkillPhase::kHandle))
    return;
  if (world_.robot(robot_).held) {
    record(*misplacing_, now);
    skills_->drop(now);
    misplaced_ = true;
  }
  misplacing_ = nullptr;
}

void FaultySkills::limit_speed(SimTime now) {
  for (FaultTimer& timer : timers_) {
    const Fault& fault = timer.fault();
    const bool halts = fault.kind == FaultKind::kRobotHalts;
    if ((!halts && fault.kind != FaultKind::kRobotSlow) || now < timer.due()) continue;
    record(fault, now);
    timer.struck(now);
    if (!halts) slow_ = fault.factor;
    SimTime& until = halts ? halted_until_ : slow_until_;
    until = std::max(until, now + fault.duration);
  }
  set_speed(now);
}

void FaultySkills::set_speed(SimTime now) {
  const double speed = now < halted_until_ ? 0 : now < slow_until_ ? slow_ : 1;
  if (std::exchange(speed_, speed) != speed) traffic_.set_speed(robot_, speed, now);
}

void FaultySkills::drop_due(SimTime now) {
  for (FaultTimer& timer : timers_) {
    if (timer.fault().kind != FaultKind::kPieceDropped || now < timer.due() || !world_.robot(robot_).held) continue;
    record(timer.fault(), now);
    timer.struck(now);
    skills_->drop(now);
  }
  if (now < slips_at_) return;
  slips_at_ = kNever;
  if (world_.robot(robot_).held != slipping_) return;  // it has been put down in time
  record(*slip_, now);
  skills_->drop(now);
}

SimTime FaultySkills::next_due() const {
  SimTime due = skills_->next_due();
  if (!cancelled_) due = std::min(due, fails_at_);
  due = std::min({due, begins_at_, searches_until_, late_until_, slips_at_});
  if (speed_ < 1) due = std::min(due, speed_ == 0 ? halted_until_ : slow_until_);
  const bool holds = world_.robot(robot_).held.has_value();
  for (const FaultTimer& timer : timers_) {
    const FaultKind kind = timer.fault().kind;
    if (kind == FaultKind::kRobotHalts || kind == FaultKind::kRobotSlow || (kind == FaultKind::kPieceDropped && holds))
      due = std::min(due, timer.due());
  }
  return due;
}

}  // namespace cxlab::sim
