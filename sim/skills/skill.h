#pragma once
// The skills of a robot, their results, and the interface that both tiers implement.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cx/base/time.h"
#include "sim/world.h"

namespace cxlab::sim {

enum class SkillKind : std::uint8_t { kDriveTo, kPick, kPlace, kDiscard, kExplore, kTransport };
std::string_view to_string(SkillKind kind);  ///< "drive_to" ...
/// One skill: the name of its action on a robot, and the type in the package cxlab_skills.
struct SkillWord {
  SkillKind kind{};
  std::string_view name, type;
};
std::span<const SkillWord> skill_words();

/// Error codes of the league's AgentTask.
enum class SkillCode : std::uint16_t {
  kNone = 0,
  kInvalidTarget = 103,
  kUnableToMove = 201,
  kNoWorkpiece = 202,
  kMachineNotFound = 203,
  kSensorDisagreement = 204,
  kGraspFailed = 206,
  kGripperFull = 207,
  kGripperEmpty = 208,
  kOccupied = 209,
  kOffField = 210,  ///< of cxlab
  kInternal = 220,
  kNoPath = 300,
};
/// One line for people.
std::string_view to_string(SkillCode code);

/// What a skill is doing; posted as feedback when it changes.
enum class SkillPhase : std::uint8_t {
  kWait,  ///< others are in the way
  kDrive,
  kAlign,     ///< 0.5 m from the face, in line with the spot
  kLook,      ///< stands there until the camera has found the spot, or read the markers in a zone, or until a
              ///< piece comes that it waits for
  kApproach,  ///< base to the working distance, gripper forward
  kLower,
  kGrip,
  kRelease,
  kLift,
  kBackOff,  ///< to 0.5 m from the face (not a discard), gripper home
  kCheck,    ///< looks whether the piece is where it should be
  kHandle,   ///< timed tier: all between align and back off
  kStop,     ///< cancelled: until the robot stands and its gripper is home
};
std::string_view to_string(SkillPhase phase);  ///< "wait" ...

struct SkillGoal {
  SkillKind kind{};
  std::string target;          ///< as the client named it
  std::optional<SpotId> spot;  ///< pick and place always; drive_to and discard when the target is a spot
  Pose2 pose;                  ///< where to stand; of a discard without a target: where the robot stands; of
                               ///< explore: the middle of the zone
  std::optional<SpotId> to{};  ///< transport, whose `spot` and `pose` say where from
  SimTime wait{};              ///< pick: how long it stands there until a piece lies at the spot
};

/// The parts of a transport.
SkillGoal first_part(const SkillGoal& transport);
SkillGoal second_part(const SkillGoal& transport, const FloorPlan& plan);

struct SkillResult {
  SkillCode code = SkillCode::kNone;
  bool cancelled = false;           ///< ended because of `cancel`
  std::string text{};               ///< what happened, empty when all went well
  std::optional<StationId> seen{};  ///< explore: the machine in the zone

  static SkillResult of(SkillCode code) { return {code, false, std::string(to_string(code)), {}}; }
  static SkillResult cancel() { return {SkillCode::kNone, true, "cancelled", {}}; }
};

/// Longest time that a skill drives and waits, and that it takes in all; then it ends with 201.
inline constexpr SimTime kDriveTimeout{95'000'000'000};
inline constexpr SimTime kSkillTimeout{115'000'000'000};
/// A transport finds its spots while it drives the last metre.
inline constexpr double kLookAhead = 1.0;
/// The longest that a pick waits for its piece; that time is added to `kSkillTimeout`.
inline constexpr SimTime kLongestWait{60'000'000'000};
/// How often it looks meanwhile.
inline constexpr SimTime kWaitPeriod{200'000'000};
/// How long an explore looks.
inline constexpr SimTime kExploreTime{2'000'000'000};

/// The skills of one robot in one tier: a state machine that runs one skill at a time.
class RobotSkills {
 public:
  virtual ~RobotSkills() = default;
  virtual void start(const SkillGoal& goal, SimTime now) = 0;
  /// The skill ends soon, with the robot standing, its gripper home, and what it held still held.
  virtual void cancel(SimTime now) = 0;
  /// The robot was carried away: the skill is over at once, without a result, and the gripper opens.
  virtual void abandon(SimTime now) = 0;
  /// The floor was halted and goes on: since then nobody has called `sense` or `act`. Times stood, too.
  virtual void resume(SimTime now) = 0;
  /// Looks at the world and moves on. The result, once, when the skill has ended.
  virtual std::optional<SkillResult> sense(SimTime now) = 0;
  /// Commands motors, or writes the book; also between skills, when the robot makes room for others.
  virtual void act(SimTime now) = 0;
  /// Lets go of what the robot holds, wherever it is: a fault, not a skill.
  virtual void drop(SimTime now) = 0;
  virtual SkillPhase phase() const = 0;
  /// In the phase `kWait`: the robot that is in the way; nothing if a fault holds this one up.
  virtual std::optional<RobotId> waits_for(SimTime now) const = 0;
  /// The skill, or what a transport is at: a pick, then a place.
  virtual SkillKind part() const = 0;
  /// Metres still to drive.
  virtual double remaining(SimTime now) const = 0;
  /// When `sense` has something to see by itself.
  virtual SimTime next_due() const = 0;
};

}  // namespace cxlab::sim
