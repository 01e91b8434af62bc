#include "sim/skills/skill.h"

namespace cxlab::sim {

std::string_view to_string(SkillKind kind) {
  switch (kind) {
    case SkillKind::kDriveTo: return "drive_to";
    case SkillKind::kPick: return "pick";
    case SkillKind::kPlace: return "place";
  }
  return "unknown";
}

std::string_view to_string(SkillCode code) {
  switch (code) {
    case SkillCode::kNone: return "";
    case SkillCode::kInvalidTarget: return "invalid target";
    case SkillCode::kUnableToMove: return "unable to move";
    case SkillCode::kNoWorkpiece: return "no workpiece found";
    case SkillCode::kSensorDisagreement: return "sensor disagreement";
    case SkillCode::kGraspFailed: return "grasping failed";
    case SkillCode::kGripperFull: return "workpiece already in gripper";
    case SkillCode::kGripperEmpty: return "no workpiece in gripper";
    case SkillCode::kOccupied: return "machine point occupied";
    case SkillCode::kInternal: return "internal error";
    case SkillCode::kNoPath: return "no path";
  }
  return "unknown error";
}

std::string_view to_string(SkillPhase phase) {
  switch (phase) {
    case SkillPhase::kWait: return "wait";
    case SkillPhase::kDrive: return "drive";
    case SkillPhase::kAlign: return "align";
    case SkillPhase::kLook: return "look";
    case SkillPhase::kCheck: return "check";
    case SkillPhase::kApproach: return "approach";
    case SkillPhase::kLower: return "lower";
    case SkillPhase::kGrip: return "grip";
    case SkillPhase::kRelease: return "release";
    case SkillPhase::kLift: return "lift";
    case SkillPhase::kBackOff: return "back_off";
    case SkillPhase::kHandle: return "handle";
    case SkillPhase::kStop: return "stop";
  }
  return "unknown";
}

}  // namespace cxlab::sim
