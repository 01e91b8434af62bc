#pragma once
// What one team is told and may ask for, as on its channel of the league: its machines on `/machine_info`, what came of
// its reports on `/machine_report_info`; it sends reports to `/machine_report`, requests for maintenance of its robots
// to `/set_robot_maintenance`, and instructions to the action `/factory/instruct_machine`.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cx/bus/bus.h"
#include "scenarios/rcll/rules/machine_faults.h"
#include "scenarios/rcll/rules/machines.h"
#include "scenarios/rcll/rules/maintenance.h"
#include "scenarios/rcll/rules/referee.h"
#include "scenarios/rcll/topics/topic.h"

namespace cxlab::rcll {

/// Fills a Machine, with what a team hears of its own, or with all there is.
void put_machine(const bus::MessageView& entry, const Machine& machine, const sim::World& world,
                 const Exploration& exploration, Information information);

/// What the names of a team's channel begin with: nothing where one team plays, else `/cyan` or `/magenta`.
std::string channel_prefix(Team team, std::size_t teams);

/// A game, as its teams act on it.
struct GameParts {
  sim::World& world;
  const Machines& machines;
  GameReferee& referee;
  Maintenance& maintenance;
  MachineFaults& faults;
};

class TeamChannel {
 public:
  /// The parts and the bus outlive it.
  TeamChannel(Team team, Information information, const GameParts& game, bus::Bus& bus)
      : team_(team), information_(information), game_(game), bus_(bus) {}
  /// Opens topics and action of the node; `prefix` before their names.
  Status open(bus::ParticipantId node, const std::string& prefix);

  /// Posts what the machines did; `changed`: something did.
  void sense(SimTime now, bool changed);
  /// Takes the instructions that faults have held up to their machines, and judges the reports of a pause; by the
  /// floor's clock. Not called while the game is paused.
  void act(SimTime now);
  SimTime next_due() const;  ///< simulated time
  Team team() const { return team_; }
  /// Takes a line for each entry of a report that is nonsense.
  void on_warning(std::function<void(const std::string&)> warn) { warn_ = std::move(warn); }

 private:
  struct Goal {
    bus::GoalId id{};
    Machine* machine = nullptr;
    std::uint32_t job = 0;
    MachineState reported{};
  };
  /// An instruction that a fault has held up.
  struct Delayed {
    bus::GoalId id{};
    Machine* machine = nullptr;
    Instruction instruction;
    SimTime due{};  ///< by the floor's clock
    bool lost = false;
    bool canceled = false;  ///< nobody waits for it; it comes all the same
  };
  void start(const bus::Delivery& delivery);
  void instruct(const bus::GoalId& goal, Machine& machine, const Instruction& instruction);
  Machine::Answer hear(Machine& machine, const Instruction& instruction);
  void cancel(const bus::Delivery& delivery);
  void report(Goal& goal);
  void finish(const bus::GoalId& goal, InstructError error, const std::string& text, const std::string& machine);
  void take_report(const bus::Delivery& delivery);
  void take_maintenance(const bus::Delivery& delivery);
  void judge_report(const bus::MessageView& report);
  void publish_machines();
  void publish_reports();

  Team team_;
  Information information_;
  GameParts game_;
  bus::Bus& bus_;
  const bus::ActionType* action_ = nullptr;
  bus::EndpointId server_{};
  std::function<void(const std::string&)> warn_;
  PeriodicTopic machine_info_, report_info_;
  std::vector<Goal> goals_;  ///< running, in order of arrival
  std::vector<Delayed> delayed_;
  std::vector<bus::SharedMessage> reports_;  ///< that came in a pause
};

}  // namespace cxlab::rcll
