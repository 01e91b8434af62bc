#include "sim/skills/physics_skills.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/skills/destination.h"
#include "sim/skills/explore.h"

namespace cxlab::sim {
namespace {

const Vec3 kHome(kRobot.home_forward, 0, kRobot.home_height);  ///< of the gripper, in the robot's frame
constexpr double kOpen = kRobot.fingers_open, kSqueeze = kRobot.fingers_squeeze;
constexpr double kOpenEnough = 0.028;
constexpr double kLifted = 0.045;      ///< m up: clear of the guides
constexpr double kWithinHull = 0.085;  ///< m forward: nothing sticks out over the robot's hull
constexpr double kAboveGrip = 0.005;   ///< m over the grip while coming in
constexpr double kAbovePut = 0.001;    ///< m over the rest when the fingers open
constexpr double kAboveSlide = 0.012;  ///< m: over the rim of the slide's mouth

// Steering of the base.
constexpr double kTrackGain = 2.5, kTrackYawGain = 3.0;  ///< 1/s
constexpr SimTime kLead{120'000'000};                    ///< the base follows its command that much later
constexpr SimTime kSlope{50'000'000};
constexpr double kFineGain = 3.0, kFineYawGain = 3.0;
constexpr double kFineSlowDown = 0.6;                ///< m/s2
constexpr double kFineSpeed = 0.1, kFineTurn = 0.6;  ///< the league's robots align at 0.1 m/s

// Where steering is good enough, in m and rad.
constexpr double kArrivedAt = 0.03, kArrivedYaw = 0.05;
constexpr double kAlignedAt = 0.012, kAlignedYaw = 0.02;
constexpr double kAtWork = 0.010;
constexpr double kBackedOff = 0.03;
constexpr double kStill = 0.03;   ///< m/s
constexpr double kFacing = 0.35;  ///< off the spot: the camera sees it
constexpr double kAxisExact = 0.002;
constexpr double kPieceSize = 0.042;  ///< m: two pieces nearer than that would touch

constexpr SimTime kLookTime{8'000'000'000};   ///< until the camera has found the spot and held it
constexpr SimTime kCheckTime{2'000'000'000};  ///< looking whether the piece is where it should be
constexpr SimTime kGripTime{400'000'000};
constexpr SimTime kReleaseTime{300'000'000};
constexpr SimTime kSettleTime{1'500'000'000};
constexpr SimTime kPhaseTimeout{8'000'000'000};
constexpr SimTime kLowerTimeout{2'500'000'000};
constexpr int kTries = 2;

double speed_of(const RobotState& state) { return std::hypot(state.vx, state.vy); }

}  // namespace

PhysicsSkills::PhysicsSkills(RobotId robot, const WorldView& world, RobotBodies& bodies, Traffic& traffic)
    : robot_(robot), world_(world), bodies_(bodies), traffic_(traffic) {}

void PhysicsSkills::enter(SkillPhase phase, SimTime now) {
  phase_ = phase;
  entered_ = now;
}

void PhysicsSkills::start(const SkillGoal& goal, SimTime now) {
  next_.reset();
  blended_ = goal.kind == SkillKind::kTransport;
  if (blended_) next_ = second_part(goal, world_.plan());
  begin(blended_ ? first_part(goal) : goal, now);
}

void PhysicsSkills::begin(const SkillGoal& goal, SimTime now) {
  goal_ = goal;
  looking_since_ = kNever;
  active_ = true;
  cancelled_ = false;
  failure_ = SkillCode::kNone;
  started_ = now;
  waited_ = SimTime::zero();
  tries_ = 0;
  piece_.reset();
  spot_ = nullptr;
  if (goal.kind == SkillKind::kPick || goal.kind == SkillKind::kPlace) spot_ = &world_.plan().spot(*goal.spot);
  zone_ = goal.pose.position();
  const Destination there = destination_of(goal, world_, traffic_, robot_);
  goal_.pose = there.pose;
  traffic_.request(robot_, there.pose, there.ground, now);
  enter(SkillPhase::kDrive, now);
}

void PhysicsSkills::cancel(SimTime now) {
  if (!active_ || cancelled_) return;
  cancelled_ = true;
  // Fingers that have not closed on a piece yet, or have begun to let go of one, end open.
  const bool closing_late = phase_ == SkillPhase::kGrip && now - entered_ < kGripTime / 2;
  if (goal_.kind == SkillKind::kPick && (phase_ < SkillPhase::kGrip || closing_late)) fingers_goal_ = kOpen;
  if (!traffic_.working(robot_)) traffic_.withdraw(robot_, now);
  enter(SkillPhase::kStop, now);
}

void PhysicsSkills::abandon(SimTime now) {
  active_ = false;
  drop(now);
}

/// It has come to a stand beyond the place where its motion was.
void PhysicsSkills::resume(SimTime now) {
  state_ = world_.robot(robot_);
  traffic_.halted(robot_, state_.pose_in_world, now);
}

SkillResult PhysicsSkills::end(SkillCode code, SimTime now) {
  active_ = false;
  traffic_.withdraw(robot_, now);
  return cancelled_ ? SkillResult::cancel() : SkillResult::of(code);
}

// --- Looking

bool PhysicsSkills::base_at(const Pose2& pose, double along, double yaw) const {
  return distance(state_.pose_in_world.position(), pose.position()) <= along &&
         std::abs(wrap_angle(state_.pose_in_world.yaw - pose.yaw)) <= yaw;
}

bool PhysicsSkills::gripper_at(const Vec3& axes) const {
  return (state_.gripper - axes).cwiseAbs().maxCoeff() <= kAxisExact;
}

Vec3 PhysicsSkills::axes_for(const Vec3& point, const Pose2& robot) const {
  return within_strokes(inverse_transform(robot, point) - kHome);
}

Vec3 PhysicsSkills::reach_axes(const Pose2& robot, double above) const {
  if (goal_.kind == SkillKind::kPick) {
    const Piece* piece = piece_ ? world_.find(*piece_) : nullptr;
    Vec3 at = piece ? piece->position_in_world : spot_->rest_in_world;
    at.z() = spot_->rest_in_world.z() + above;
    return axes_for(at, robot);
  }
  const Vec3 offset = transform({0, 0, robot.yaw}, carried_offset_);
  return axes_for(spot_->rest_in_world - offset + above * Vec3::UnitZ(), robot);
}

Vec3 PhysicsSkills::approach_axes(const Pose2& robot) const {
  if (!spot_) return {kRobot.forward_stroke, 0, kRobot.up_stroke};
  if (goal_.kind == SkillKind::kPick) return reach_axes(robot, kAboveGrip);
  Vec3 axes = reach_axes(robot, 0);
  axes.z() = kRobot.up_stroke;
  return axes;
}

double PhysicsSkills::lowest() const {
  if (goal_.kind == SkillKind::kPick) return 0;
  return spot_->kind == SpotKind::kSlide ? kAboveSlide : kAbovePut;
}

/// Why a skill that handles a piece cannot begin.
std::optional<SkillCode> PhysicsSkills::obstacle() const {
  if (goal_.kind == SkillKind::kPick) {
    if (state_.held) return SkillCode::kGripperFull;
    if (!world_.at(*goal_.spot)) return SkillCode::kNoWorkpiece;
  } else {
    if (!state_.held) return SkillCode::kGripperEmpty;
    if (spot_ && occupied()) return SkillCode::kOccupied;
  }
  return std::nullopt;
}

/// Whether something lies where the held piece would come down, also when it lies askew.
bool PhysicsSkills::occupied() const {
  return std::ranges::any_of(world_.pieces(), [&](const Piece& piece) {
    const Vec3 off = piece.position_in_world - spot_->rest_in_world;
    return piece.id != state_.held && std::abs(off.z()) < kPieceSize && off.head<2>().norm() < kPieceSize;
  });
}

std::optional<SkillResult> PhysicsSkills::give_up(SkillCode code, SimTime now) {
  failure_ = code;
  if (goal_.kind == SkillKind::kPick && !state_.held) fingers_goal_ = kOpen;
  enter(SkillPhase::kBackOff, now);
  return std::nullopt;
}

std::optional<SkillResult> PhysicsSkills::sense(SimTime now) {
  now_ = now;
  state_ = world_.robot(robot_);
  traffic_.observe(robot_, state_.pose_in_world, now);
  if (!active_) return std::nullopt;
  if (now - started_ > kSkillTimeout + waited_ && phase_ != SkillPhase::kStop)
    return end(SkillCode::kUnableToMove, now);
  switch (phase_) {
    case SkillPhase::kWait:
    case SkillPhase::kDrive: return sense_drive(now);
    case SkillPhase::kLook: return goal_.kind == SkillKind::kPick && !piece_ ? sense_drive(now) : sense_work(now);
    case SkillPhase::kStop: {
      const bool stands = !traffic_.moving(robot_) && speed_of(state_) < kStill;
      const bool home = state_.gripper.x() < kWithinHull;
      const bool off = !traffic_.working(robot_) || base_at(goal_.pose, kBackedOff, kArrivedYaw);
      if ((stands && home && off) || now - entered_ > kPhaseTimeout) return end(SkillCode::kNone, now);
      return std::nullopt;
    }
    default: return sense_work(now);
  }
}

std::optional<SkillResult> PhysicsSkills::sense_drive(SimTime now) {
  if (traffic_.arrived(robot_)) {
    if (goal_.kind != SkillKind::kDriveTo && goal_.kind != SkillKind::kExplore) {
      const auto code = obstacle();
      if (code == SkillCode::kNoWorkpiece && waited_ < goal_.wait) {
        if (phase_ != SkillPhase::kLook) enter(SkillPhase::kLook, now);
        waited_ = now - entered_;
        return std::nullopt;
      }
      if (code) return end(*code, now);
      if (goal_.kind == SkillKind::kPick) {
        piece_ = world_.at(*goal_.spot)->id;
      } else {
        piece_ = state_.held;
        const Vec3 held = inverse_transform(state_.pose_in_world, world_.find(*piece_)->position_in_world);
        carried_offset_ = held - kHome - state_.gripper;
      }
      enter(spot_ ? SkillPhase::kAlign : SkillPhase::kApproach, now);
      return std::nullopt;
    }
    const bool there = base_at(goal_.pose, kArrivedAt, kArrivedYaw) && speed_of(state_) < kStill;
    if (!there && now - traffic_.motion(robot_)->end() <= kSettleTime) return std::nullopt;
    if (!base_at(goal_.pose, 2 * kArrivedAt, 2 * kArrivedYaw)) return end(SkillCode::kUnableToMove, now);
    if (goal_.kind == SkillKind::kDriveTo) return end(SkillCode::kNone, now);
    enter(SkillPhase::kLook, now);
    return std::nullopt;
  }
  if (blended_ && looking_since_ == kNever && base_at(goal_.pose, kLookAhead, kFacing)) looking_since_ = now;
  if (traffic_.unreachable(robot_)) return end(SkillCode::kNoPath, now);
  if (now - started_ > kDriveTimeout) return end(SkillCode::kUnableToMove, now);
  const SkillPhase phase = traffic_.waiting(robot_, now) ? SkillPhase::kWait : SkillPhase::kDrive;
  if (phase != phase_) enter(phase, now);
  return std::nullopt;
}

std::optional<SkillResult> PhysicsSkills::sense_work(SimTime now) {
  const bool late = now - entered_ > kPhaseTimeout;
  const bool picks = goal_.kind == SkillKind::kPick;
  switch (phase_) {
    case SkillPhase::kAlign:
      if (base_at(goal_.pose, kAlignedAt, kAlignedYaw))
        enter(SkillPhase::kLook, now);
      else if (late)
        return give_up(SkillCode::kUnableToMove, now);
      return std::nullopt;
    case SkillPhase::kLook:
      if (goal_.kind == SkillKind::kExplore) {
        if (now - entered_ < kExploreTime) return std::nullopt;
        SkillResult result = end(SkillCode::kNone, now);
        result.seen = station_in_zone(world_.plan(), zone_);
        return result;
      }
      if (now - std::min(entered_, looking_since_) >= kLookTime) enter(SkillPhase::kApproach, now);
      return std::nullopt;
    case SkillPhase::kApproach:
      if (base_at(work_pose(), kAtWork, kAlignedYaw) && speed_of(state_) < kStill &&
          gripper_at(approach_axes(state_.pose_in_world)))
        enter(spot_ ? SkillPhase::kLower : SkillPhase::kRelease, now);
      else if (late)
        return give_up(SkillCode::kUnableToMove, now);
      return std::nullopt;
    case SkillPhase::kLower:
      if (gripper_at(reach_axes(state_.pose_in_world, lowest())))
        enter(picks ? SkillPhase::kGrip : SkillPhase::kRelease, now);
      else if (now - entered_ > kLowerTimeout)
        return give_up(picks ? SkillCode::kGraspFailed : SkillCode::kOccupied, now);
      return std::nullopt;
    case SkillPhase::kGrip:
      if (now - entered_ >= kGripTime) enter(SkillPhase::kLift, now);
      return std::nullopt;
    case SkillPhase::kLift:
      if (state_.gripper.z() < kLifted && !late) return std::nullopt;
      if (state_.held) {
        enter(SkillPhase::kBackOff, now);
      } else if (++tries_ < kTries && world_.at(*goal_.spot)) {
        piece_ = world_.at(*goal_.spot)->id;
        enter(SkillPhase::kApproach, now);
      } else {
        return give_up(SkillCode::kGraspFailed, now);
      }
      return std::nullopt;
    case SkillPhase::kRelease:
      if (now - entered_ >= kReleaseTime && (state_.finger_opening >= kOpenEnough || late))
        enter(SkillPhase::kBackOff, now);
      return std::nullopt;
    case SkillPhase::kBackOff:
      if (base_at(goal_.pose, kBackedOff, kArrivedYaw) && state_.gripper.x() < kWithinHull) {
        if (failure_ != SkillCode::kNone) return end(failure_, now);
        if (next_) {  // the place looks whether the piece is still held
          begin(*std::exchange(next_, std::nullopt), now);
          return std::nullopt;
        }
        enter(SkillPhase::kCheck, now);
      } else if (late) {
        return end(SkillCode::kUnableToMove, now);
      }
      return std::nullopt;
    case SkillPhase::kCheck:
      if (now - entered_ >= kCheckTime) return verify(now);
      return std::nullopt;
    default: return end(SkillCode::kInternal, now);
  }
}

/// Backed off: is the piece where it should be?
std::optional<SkillResult> PhysicsSkills::verify(SimTime now) {
  if (goal_.kind == SkillKind::kPick) return end(state_.held ? SkillCode::kNone : SkillCode::kGraspFailed, now);
  const Piece* piece = world_.find(*piece_);
  if (goal_.kind == SkillKind::kDiscard)
    return end(piece && piece->holder == Holder::kGripper ? SkillCode::kSensorDisagreement : SkillCode::kNone, now);
  // A machine may have taken it on already.
  const bool placed = !piece || (piece->holder != Holder::kGripper && piece->holder != Holder::kFloor);
  return end(placed ? SkillCode::kNone : SkillCode::kSensorDisagreement, now);
}

// --- Commanding

void PhysicsSkills::hold_still() {
  if (!commanded_) return;
  bodies_.command_base(robot_, 0, 0, 0);
  commanded_ = false;
}

void PhysicsSkills::steer_along(const Trajectory& motion, SimTime now) {
  const Pose2 wanted = motion.at(now), soon = motion.at(now + kLead), later = motion.at(now + kLead + kSlope);
  const double dt = to_seconds(kSlope);
  const Pose2& here = state_.pose_in_world;
  bodies_.command_base(robot_, (later.x - soon.x) / dt + kTrackGain * (wanted.x - here.x),
                       (later.y - soon.y) / dt + kTrackGain * (wanted.y - here.y),
                       wrap_angle(later.yaw - soon.yaw) / dt + kTrackYawGain * wrap_angle(wanted.yaw - here.yaw));
  commanded_ = true;
}

void PhysicsSkills::steer_to(const Pose2& pose, double speed) {
  const Pose2& here = state_.pose_in_world;
  const double dx = pose.x - here.x, dy = pose.y - here.y, way = std::hypot(dx, dy);
  const double turn = wrap_angle(pose.yaw - here.yaw);
  const double v = std::min({speed, kFineGain * way, std::sqrt(2 * kFineSlowDown * way)});
  const double scale = way > 1e-6 ? v / way : 0;
  bodies_.command_base(robot_, scale * dx, scale * dy, std::clamp(kFineYawGain * turn, -kFineTurn, kFineTurn));
  commanded_ = true;
}

void PhysicsSkills::move_gripper(const Vec3& axes) {
  if (axes == gripper_goal_) return;
  gripper_goal_ = axes;
  bodies_.command_gripper(robot_, axes);
}

void PhysicsSkills::move_fingers(double opening) {
  fingers_goal_ = opening;
  bodies_.command_fingers(robot_, opening);
}

void PhysicsSkills::drop(SimTime) { move_fingers(kOpen); }

void PhysicsSkills::act(SimTime now) {
  const bool at_work = active_ && traffic_.working(robot_) && goal_.kind != SkillKind::kExplore;
  if (!at_work) {
    // On the way, for itself or for others, or idle: the arm is home, high enough for what it carries.
    move_gripper({0, 0, kRobot.up_stroke});
    if (traffic_.moving(robot_))
      steer_along(*traffic_.motion(robot_), now);
    else if (active_ && traffic_.arrived(robot_))
      steer_to(goal_.pose, kFineSpeed);
    else
      hold_still();
    return;
  }
  const bool picks = goal_.kind == SkillKind::kPick;
  switch (phase_) {
    case SkillPhase::kAlign:
    case SkillPhase::kLook:
    case SkillPhase::kApproach: {
      const bool aligned = phase_ == SkillPhase::kApproach;
      if (picks) move_fingers(kOpen);
      steer_to(aligned ? work_pose() : goal_.pose, kFineSpeed);
      // While the base still drives, the arm goes to where it will be needed.
      const bool close = aligned && base_at(work_pose(), kAtWork, kAlignedYaw);
      move_gripper(approach_axes(close ? state_.pose_in_world : work_pose()));
      break;
    }
    case SkillPhase::kLower:
      hold_still();
      move_gripper(reach_axes(state_.pose_in_world, lowest()));
      break;
    case SkillPhase::kGrip:
      hold_still();
      move_fingers(kSqueeze);
      break;
    case SkillPhase::kRelease:
      hold_still();
      move_fingers(kOpen);
      break;
    case SkillPhase::kLift:
      hold_still();
      if (!state_.held && tries_ + 1 < kTries && state_.gripper.z() >= kLifted) move_fingers(kOpen);
      move_gripper({gripper_goal_.x(), gripper_goal_.y(), kRobot.up_stroke});
      break;
    default: {  // back off, also after a cancel: up first, so that nothing is dragged along
      if (fingers_goal_ == kOpen) move_fingers(kOpen);
      const bool clear =
          state_.gripper.z() >= kLifted || (fingers_goal_ == kOpen && state_.finger_opening >= kOpenEnough);
      move_gripper({clear ? 0 : gripper_goal_.x(), clear ? 0 : gripper_goal_.y(), kRobot.up_stroke});
      if (clear)
        steer_to(goal_.pose, kFineSpeed);
      else
        hold_still();
      break;
    }
  }
}

}  // namespace cxlab::sim
