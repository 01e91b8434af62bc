#include "sim/skills/skill.h"

namespace cxlab::sim {

std::span<const SkillWord> skill_words() {
  static constexpr SkillWord kWords[]{{SkillKind::kDriveTo, "drive_to", "cxlab_skills/action/DriveTo"},
                                      {SkillKind::kPick, "pick", "cxlab_skills/action/Pick"},
                                      {SkillKind::kPlace, "place", "cxlab_skills/action/Place"},
                                      {SkillKind::kDiscard, "discard", "cxlab_skills/action/Discard"},
                                      {SkillKind::kExplore, "explore", "cxlab_skills/action/Explore"},
                                      {SkillKind::kTransport, "transport", "cxlab_skills/action/Transport"}};
  return kWords;
}

std::string_view to_string(SkillKind kind) { return skill_words()[static_cast<std::size_t>(kind)].name; }

std::string_view to_string(SkillCode code) {
  switch (code) {
    case SkillCode::kNone: return "";
    case SkillCode::kInvalidTarget: return "invalid target";
    case SkillCode::kUnableToMove: return "unable to move";
    case SkillCode::kNoWorkpiece: return "no workpiece found";
    case SkillCode::kMachineNotFound: return "machine not found";
    case SkillCode::kSensorDisagreement: return "sensor disagreement";
    case SkillCode::kGraspFailed: return "grasping failed";
    case SkillCode::kGripperFull: return "workpiece already in gripper";
    case SkillCode::kGripperEmpty: return "no workpiece in gripper";
    case SkillCode::kOccupied: return "machine point occupied";
    case SkillCode::kOffField: return "taken off the field";
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

SkillGoal first_part(const SkillGoal& transport) {
  return {SkillKind::kPick, transport.target, transport.spot, transport.pose, {}};
}

SkillGoal second_part(const SkillGoal& transport, const FloorPlan& plan) {
  return {SkillKind::kPlace, transport.target, transport.to, plan.spot(*transport.to).align_in_world, {}};
}

}  // namespace cxlab::sim
