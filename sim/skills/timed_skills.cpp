#include "sim/skills/timed_skills.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "sim/skills/destination.h"
#include "sim/skills/explore.h"

namespace cxlab::sim {

namespace {

// What a transport saves of a pick and a place: it looks while it drives the last metre, and checks its grip on the
// way.
constexpr double kLookAheadTime = 2.3, kCheckSeconds = 2.0;  // s
constexpr double kShortestDrive = 0.4;                       // of the planned time

}  // namespace

HandlingMeans means_of(const TimedSkillsConfig& config) {
  constexpr HandlingMeans kPhysics{15.5, 15.5, 15.3, 15.3, 6.5}, kMeasured{20.9, 24.2, 19.2, 23.5, 8.25};
  const HandlingMeans& usual = config.durations == "measured" ? kMeasured : kPhysics;
  return {config.pick_mean_s.value_or(usual.pick),
          config.pick_shelf_mean_s.value_or(config.pick_mean_s.value_or(usual.pick_shelf)),
          config.place_mean_s.value_or(usual.place),
          config.place_slide_mean_s.value_or(config.place_mean_s.value_or(usual.place_slide)),
          config.discard_mean_s.value_or(usual.discard)};
}

Status validate(const TimedSkillsConfig& config) {
  const HandlingMeans means = means_of(config);
  constexpr double kAny = std::numeric_limits<double>::infinity(), kPositive = std::numeric_limits<double>::min();
  struct Value {
    const char* name;
    double value, least, most;
    const char* expected;
  };
  for (const Value& v : {Value{"pick_mean_s", means.pick, kPositive, kAny, "a time > 0 s"},
                         {"place_mean_s", means.place, kPositive, kAny, "a time > 0 s"},
                         {"pick_shelf_mean_s", means.pick_shelf, kPositive, kAny, "a time > 0 s"},
                         {"place_slide_mean_s", means.place_slide, kPositive, kAny, "a time > 0 s"},
                         {"discard_mean_s", means.discard, kPositive, kAny, "a time > 0 s"},
                         {"discard_sigma_s", config.discard_sigma_s, 0, kAny, ">= 0 s"},
                         {"shortest_s", config.shortest_s, kPositive, kAny, "a time > 0 s"},
                         {"pick_sigma_s", config.pick_sigma_s, 0, kAny, ">= 0 s"},
                         {"place_sigma_s", config.place_sigma_s, 0, kAny, ">= 0 s"},
                         {"drive_sigma", config.drive_sigma, 0, 1, "a share of the planned time, 0 .. 1"},
                         {"drive_failure", config.drive_failure, 0, 1, "a probability, 0 .. 1"},
                         {"pick_failure", config.pick_failure, 0, 1, "a probability, 0 .. 1"},
                         {"place_failure", config.place_failure, 0, 1, "a probability, 0 .. 1"}})
    if (!(v.value >= v.least && v.value <= v.most))
      return input_error(std::string(v.name) + ": " + found_expected(std::to_string(v.value), v.expected));
  return {};
}

TimedSkills::TimedSkills(RobotId robot, const WorldView& world, RobotBook& book, Traffic& traffic,
                         const TimedSkillsConfig& config, std::uint64_t seed)
    : robot_(robot),
      world_(world),
      book_(book),
      traffic_(traffic),
      config_(config),
      durations_(seed, "durations/" + world.plan().robot(robot).name),
      drives_(seed, "drives/" + world.plan().robot(robot).name),
      failures_(seed, "failures/" + world.plan().robot(robot).name) {}

void TimedSkills::start(const SkillGoal& goal, SimTime now) {
  next_.reset();
  blended_ = goal.kind == SkillKind::kTransport;
  if (blended_) next_ = second_part(goal, world_.plan());
  begin(blended_ ? first_part(goal) : goal, now);
}

void TimedSkills::begin(const SkillGoal& goal, SimTime now) {
  goal_ = goal;
  begun_ = now;
  active_ = true;
  phase_ = SkillPhase::kDrive;
  due_ = now + kDriveTimeout;
  zone_ = goal.pose.position();
  const Destination there = destination_of(goal, world_, traffic_, robot_);
  goal_.pose = there.pose;
  if (config_.drive_sigma > 0)
    traffic_.stretch(robot_, std::max(kShortestDrive, drives_.normal(1, config_.drive_sigma)));
  traffic_.request(robot_, there.pose, there.ground, now);
}

void TimedSkills::cancel(SimTime now) {
  if (!active_) return;
  phase_ = SkillPhase::kStop;
  due_ = now;
  traffic_.withdraw(robot_, now);
}

SkillResult TimedSkills::end(SkillCode code, SimTime now) {
  active_ = false;
  traffic_.withdraw(robot_, now);
  return SkillResult::of(code);
}

/// Why a skill that handles a piece cannot begin.
std::optional<SkillCode> TimedSkills::obstacle() const {
  const bool holds = world_.robot(robot_).held.has_value();
  if (goal_.kind == SkillKind::kDiscard) return holds ? std::nullopt : std::optional(SkillCode::kGripperEmpty);
  const bool taken = world_.at(*goal_.spot) != nullptr;
  if (goal_.kind == SkillKind::kPick) {
    if (holds) return SkillCode::kGripperFull;
    if (!taken) return SkillCode::kNoWorkpiece;
  } else {
    if (!holds) return SkillCode::kGripperEmpty;
    if (taken) return SkillCode::kOccupied;
  }
  return std::nullopt;
}

SimTime TimedSkills::drawn_duration(SimTime now) {
  const SpotKind spot = goal_.spot ? world_.plan().spot(*goal_.spot).kind : SpotKind::kBeltInput;
  const HandlingMeans means = means_of(config_);
  const auto [mean, sigma] =
      goal_.kind == SkillKind::kPick
          ? std::pair(spot == SpotKind::kShelf ? means.pick_shelf : means.pick, config_.pick_sigma_s)
      : goal_.kind == SkillKind::kPlace
          ? std::pair(spot == SpotKind::kSlide ? means.place_slide : means.place, config_.place_sigma_s)
          : std::pair(means.discard, config_.discard_sigma_s);
  double duration = durations_.normal(mean, sigma);
  if (blended_) duration -= std::min(kLookAheadTime, to_seconds(now - begun_)) + (next_ ? kCheckSeconds : 0);
  return from_seconds(std::max(config_.shortest_s, duration));
}

std::optional<SkillResult> TimedSkills::begin_handling(SimTime now) {
  if (const auto code = obstacle()) return end(*code, now);
  phase_ = SkillPhase::kHandle;
  due_ = now + drawn_duration(now);
  return std::nullopt;
}

SkillCode TimedSkills::handle() {
  if (const auto code = obstacle()) return *code;
  if (goal_.kind == SkillKind::kDiscard) {
    book_.drop(robot_);
    return SkillCode::kNone;
  }
  const bool picks = goal_.kind == SkillKind::kPick;
  if (failures_.chance(picks ? config_.pick_failure : config_.place_failure))
    return picks ? SkillCode::kGraspFailed : SkillCode::kSensorDisagreement;
  const Status done = picks ? book_.grasp(robot_, *goal_.spot) : book_.release(robot_, *goal_.spot);
  return done ? SkillCode::kNone : SkillCode::kInternal;
}

SimTime TimedSkills::next_due() const {
  if (!active_) return kNever;
  // A motion that is planned to begin later ends the waiting then.
  return phase_ == SkillPhase::kWait && traffic_.moving(robot_) ? std::min(due_, traffic_.motion(robot_)->start())
                                                                : due_;
}

std::optional<SkillResult> TimedSkills::sense(SimTime now) {
  if (!active_) return std::nullopt;
  if (phase_ == SkillPhase::kStop) {
    if (traffic_.moving(robot_)) {
      due_ = traffic_.motion(robot_)->end();
      return std::nullopt;
    }
    active_ = false;
    return SkillResult::cancel();
  }
  if (phase_ == SkillPhase::kLook && goal_.kind == SkillKind::kPick) {
    if (obstacle() == SkillCode::kNoWorkpiece && now < wait_until_) {
      due_ = std::min(wait_until_, now + kWaitPeriod);
      return std::nullopt;
    }
    return begin_handling(now);
  }
  if (phase_ == SkillPhase::kLook) {
    if (now < due_) return std::nullopt;
    SkillResult result = end(SkillCode::kNone, now);
    result.seen = station_in_zone(world_.plan(), zone_);
    return result;
  }
  if (phase_ == SkillPhase::kHandle) {
    if (now < due_) return std::nullopt;
    const SkillCode code = handle();
    if (code != SkillCode::kNone || !next_) return end(code, now);
    begin(*std::exchange(next_, std::nullopt), now);
    return std::nullopt;
  }
  if (traffic_.arrived(robot_)) {
    if (goal_.kind == SkillKind::kDriveTo)
      return end(failures_.chance(config_.drive_failure) ? SkillCode::kUnableToMove : SkillCode::kNone, now);
    if (goal_.kind == SkillKind::kExplore) {
      phase_ = SkillPhase::kLook;
      due_ = now + kExploreTime;
      return std::nullopt;
    }
    if (goal_.wait > SimTime::zero() && obstacle() == SkillCode::kNoWorkpiece) {
      phase_ = SkillPhase::kLook;
      wait_until_ = now + goal_.wait;
      due_ = now + kWaitPeriod;
      return std::nullopt;
    }
    return begin_handling(now);
  }
  if (traffic_.unreachable(robot_)) return end(SkillCode::kNoPath, now);
  if (now >= due_) return end(SkillCode::kUnableToMove, now);
  phase_ = traffic_.waiting(robot_, now) ? SkillPhase::kWait : SkillPhase::kDrive;
  return std::nullopt;
}

void TimedSkills::act(SimTime now) {
  if (traffic_.motion_number(robot_) == motions_) return;
  motions_ = traffic_.motion_number(robot_);
  const Trajectory& motion = *traffic_.motion(robot_);
  constexpr std::size_t kEvery = 8;
  const auto poses = motion.poses();
  std::vector<Pose2> path{world_.robot(robot_).pose_in_world};
  for (std::size_t i = kEvery; i + 1 < poses.size(); i += kEvery) path.push_back(poses[i]);
  path.push_back(motion.last());
  book_.move_along(robot_, path, std::max(now, motion.start()), motion.end());
  if (active_ && phase_ != SkillPhase::kStop)
    phase_ = traffic_.waiting(robot_, now) ? SkillPhase::kWait : SkillPhase::kDrive;
}

}  // namespace cxlab::sim
