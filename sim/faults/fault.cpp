#include "sim/faults/fault.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cxlab::sim {
namespace {

constexpr std::array<FaultWord, 16> kWords{{
    {"skill_fails", FaultKind::kSkillFails, "robot, skill, error, after_s",
     "the skill is broken off after that time and ends with the error code; what was held is still held", true},
    {"skill_stalls", FaultKind::kSkillStalls, "seconds*, robot, skill",
     "the robot stands for that time before it begins the skill", true},
    {"goal_lost", FaultKind::kGoalLost, "robot, skill",
     "the robot never hears of the skill's goal, which is aborted with 220 after 10 s", true},
    {"result_late", FaultKind::kResultLate, "seconds*, robot, skill",
     "the skill's result comes that much later than its end", true},
    {"grasp_slips", FaultKind::kGraspSlips, "robot, after_s",
     "the piece slips out of the gripper, that long after a pick that ended well", true},
    {"piece_misplaced", FaultKind::kPieceMisplaced, "robot",
     "a place lets go of the piece too early: it falls to the floor before the machine, and the place ends with 204",
     true},
    {"piece_dropped", FaultKind::kPieceDropped, "robot", "the fingers open: what the robot holds falls to the floor",
     false},
    {"robot_halts", FaultKind::kRobotHalts, "seconds*, robot",
     "the robot drives nowhere for that time, then goes on; what it does at a machine it ends", false},
    {"robot_slow", FaultKind::kRobotSlow, "factor*, seconds*, robot",
     "the robot drives at that share of its speed for that time", false},
    {"pose_noise", FaultKind::kPoseNoise, "sigma_m*, sigma_deg*, robot",
     "the robot is wrong about where it stands: a drive ends beside its goal", true},
    {"machine_breaks", FaultKind::kMachineBreaks, "machine*", "the machine is BROKEN, as after a wrong instruction",
     false},
    {"machine_down", FaultKind::kMachineDown, "machine*, seconds*", "the machine is DOWN for that time", false},
    {"piece_taken", FaultKind::kPieceTaken, "machine*",
     "somebody takes away what lies at the input, the output or the shelf of the machine", false},
    {"instruction_lost", FaultKind::kInstructionLost, "machine*",
     "the machine never hears of an instruction, which is aborted with 2 after 10 s", true},
    {"instruction_late", FaultKind::kInstructionLate, "machine*, seconds*",
     "an instruction comes to the machine that much later", true},
    {"robot_maintenance", FaultKind::kRobotMaintenance, "seconds*, robot",
     "the robot must leave the field for maintenance, which takes people that long", false},
}};

}  // namespace

std::span<const FaultWord> fault_words() { return kWords; }

bool by_occasion(FaultKind kind) { return std::ranges::find(kWords, kind, &FaultWord::kind)->by_occasion; }

std::string_view to_string(FaultKind kind) { return std::ranges::find(kWords, kind, &FaultWord::kind)->name; }

FaultTimer::FaultTimer(const Fault& fault, std::uint64_t seed, std::string_view place)
    : fault_(fault), random_(seed, "faults/" + std::to_string(fault.number) + '/' + std::string(place)) {
  left_ = fault.at ? 1 : fault.times > 0 ? fault.times : -1;
  if (fault.at)
    due_ = *fault.at;
  else if (fault.mean > SimTime::zero())
    draw_next(fault.from);
}

bool FaultTimer::open(SimTime now) const {
  return left_ != 0 && (fault_.at ? now >= *fault_.at : now >= fault_.from && now < fault_.until);
}

bool FaultTimer::strikes_occasion(SimTime now) {
  if (!open(now) || !(fault_.at || random_.chance(fault_.probability))) return false;
  struck(now);
  return true;
}

void FaultTimer::struck(SimTime now) {
  if (left_ > 0) --left_;
  due_ = kNever;
  if (left_ != 0 && fault_.mean > SimTime::zero()) draw_next(now);
}

void FaultTimer::skip_until(SimTime now) {
  while (!fault_.at && due_ < now) draw_next(due_);
}

void FaultTimer::draw_next(SimTime from) {
  due_ = from + from_seconds(std::min(1e9, -to_seconds(fault_.mean) * std::log1p(-random_.uniform())));
  if (due_ >= fault_.until) due_ = kNever;
}

RecordData& begin_strike(RecordData& data, const Fault& fault) {
  return data.begin().field("fault", to_string(fault.kind)).field("number", static_cast<std::int64_t>(fault.number));
}

}  // namespace cxlab::sim
