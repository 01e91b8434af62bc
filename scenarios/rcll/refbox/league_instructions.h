#pragma once
// The action `factory/instruct_machine` with an outside referee box: an instruction is a PrepareMachine or
// ResetMachine, and how it ends is seen from the states of the machines.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scenarios/rcll/refbox/league_link.h"
#include "scenarios/rcll/rules/machine.h"

namespace cxlab::rcll {

class LeagueInstructions {
 public:
  /// The link outlives it.
  static Expected<std::unique_ptr<LeagueInstructions>> open(LeagueLink& link);

  /// The machines as a MachineInfo has them.
  void take_machines(google::protobuf::Message& machine_info);
  /// Sends instructions again that no machine works on.
  void repeat();
  /// Reports what the machines do, and ends instructions.
  void follow();

 private:
  struct Pending {
    bus::GoalId goal{};
    std::string machine, reported;
    pb::MessagePtr message;
    SimTime since{};
    bool reset = false, waits_for_piece = false, at_work = false;
  };

  explicit LeagueInstructions(LeagueLink& link) : link_(link) {}
  Status serve();
  void take(const bus::Delivery& delivery);
  pb::MessagePtr message_for(const bus::MessageView& goal) const;
  void finish(const Pending& instruction, InstructError code, const std::string& error);

  LeagueLink& link_;
  const bus::ActionType* type_ = nullptr;
  bus::EndpointId server_{};
  std::vector<Pending> pending_;
  std::map<std::string, std::string> machines_;  ///< state by name
};

}  // namespace cxlab::rcll
