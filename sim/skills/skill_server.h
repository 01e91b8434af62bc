#pragma once
// The skills of one robot on the bus: node "robot1" with an action for each skill: /robot1/drive_to, /robot1/pick ...
//
// One skill at a time: a goal is rejected while another one is active or still ends after a cancel. A goal with an
// unknown target, or for a robot that is off the field, is accepted and aborted at once, so that its result can report
// why.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "sim/skills/skill.h"

namespace cxlab::sim {

/// What a robot has done so far. An active skill counts up to the time asked for.
struct RobotStats {
  std::string name;
  double busy_s = 0;   ///< with a skill active
  double drive_s = 0;  ///< of these, driving to a target
  double wait_s = 0;   ///< of these, standing because others were in the way
  int skills = 0;      ///< begun
  int failures = 0;    ///< ended with an error code
};

class SkillServer {
 public:
  struct Place {
    Pose2 stand;  ///< of a robot that goes there
    Vec2 middle;
  };
  /// Names that drive_to and discard accept in addition to spots, and the zones of explore.
  using Places = std::map<std::string, Place, std::less<>>;

  /// Joins the bus under the robot's name. All outlive it. Fails when the bus does not know the package cxlab_skills.
  static Expected<std::unique_ptr<SkillServer>> create(RobotId robot, const FloorPlan& plan, const Places& places,
                                                       RobotSkills& skills, bus::Bus& bus, RecordSink& sink);
  SkillServer(const SkillServer&) = delete;
  SkillServer& operator=(const SkillServer&) = delete;

  /// Lets the skill look at the world; posts its feedback and result.
  void sense(SimTime now);
  /// Takes goals and cancels.
  void take(SimTime now);
  /// The robot is off the field, from now on or no more: what it does is aborted, and every goal until it is back.
  void set_off_field(bool off, SimTime now);
  /// Posts the phase if it has changed. If only the robot has changed for which this one waits, it is recorded.
  void report_phase(SimTime now);

  bus::ParticipantId node() const { return node_; }
  bool off_field() const { return off_field_; }
  /// Goals at a spot of a station that the robot does not know end with 203.
  void ask_whether_known(std::function<bool(StationId)> knows) { knows_ = std::move(knows); }
  bool active() const { return active_.has_value(); }
  RobotStats stats(SimTime now) const;
  /// "idle", "off-field", or skill, phase and target: "pick drive C-BS-OUTPUT", "pick wait for robot2 C-BS-OUTPUT". A
  /// target of more than 80 bytes is cut.
  const std::string& doing() const { return doing_; }

 private:
  struct Action {
    SkillKind kind{};
    const bus::ActionType* type = nullptr;
    bus::EndpointId endpoint{};
  };
  struct Active {
    const Action* action = nullptr;
    bus::GoalId goal{};
    SkillGoal skill;
    SimTime since{};
    SimTime phase_since{};
    std::optional<SkillPhase> phase;
    std::optional<RobotId> waits_for;
    bool cancelling = false;
  };

  SkillServer(RobotId robot, const FloorPlan& plan, const Places& places, RobotSkills& skills, bus::Bus& bus,
              RecordSink& sink);
  Status open(const SkillWord& skill);
  void take_goal(const Action& action, const bus::Delivery& delivery);
  void take_cancel(const Action& action, const bus::Delivery& delivery);
  /// The goal as a skill, or why it cannot be carried out.
  Expected<SkillGoal> read_goal(const Action& action, const bus::MessageView& message) const;
  /// The station of a goal's spots that the robot does not know.
  const Station* unknown_station(const SkillGoal& goal) const;
  void finish(const SkillResult& result);
  void count_phase(SimTime now, RobotStats& stats) const;
  void note_doing();
  /// As the records name it.
  static std::string target_of(const Action& action, const bus::MessageView& goal);
  std::string_view sub_action() const;
  void record(const Action& action, const std::string& target, std::string_view event);

  std::string name_;
  const FloorPlan& plan_;
  const Places& places_;
  RobotSkills& skills_;
  bus::Bus& bus_;
  RecordSink& sink_;
  bus::ParticipantId node_{};
  StreamId stream_{};
  std::deque<Action> actions_;
  std::optional<Active> active_;
  std::function<bool(StationId)> knows_;  ///< empty: all
  bool off_field_ = false;
  RobotStats stats_;
  std::string doing_ = "idle";
  RecordData data_;
  SimTime now_{};
};

}  // namespace cxlab::sim
