#include "sim/skills/skill.h"

namespace cxlab::sim {

std::string_view to_string(SkillKind kind) {
  constexpr std::string_view kNames[]{"drive_to", "pick", "place"};
  return kNames[static_cast<std::size_t>(kind)];
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
  constexpr std::string_view kNames[]{"wait",    "drive", "align",    "look",  "approach", "lower", "grip",
                                      "release", "lift",  "back_off", "check", "handle",   "stop"};
  return kNames[static_cast<std::size_t>(phase)];
}

}  // namespace cxlab::sim
