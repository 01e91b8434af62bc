#pragma once
// A team on its channel: it is told MachineInfo, RingInfo and MachineReportInfo, and what it says becomes instructions
// of machines (PrepareMachine, ResetMachine), reports (MachineReport) and requests (SetRobotMaintenance) on the bus.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/controllers.h"
#include "scenarios/rcll/refbox/refbox_context.h"

namespace cxlab::rcll {

class TeamPeer {
 public:
  /// Context and controllers outlive it.
  TeamPeer(RefboxContext& context, Controllers& controllers, Team team, Channel channel);
  TeamPeer(const TeamPeer&) = delete;
  TeamPeer& operator=(const TeamPeer&) = delete;
  /// Opens its action and topics on the bus.
  Status open();

  Channel& channel() { return channel_; }
  /// A message of its agent, which came from `host`.
  void take(const Fields& message, const std::string& type, std::string_view host);
  /// Says what is due. `rings`: the last RingInfo of the bus, or none.
  void speak(const bus::SharedMessage& rings);
  SimTime next_due() const;

 private:
  struct Instructed {
    std::string machine;
    bool busy = false;  ///< it was not idle: the instruction is ignored silently
  };
  void prepare(const Fields& message);
  bool is_stale(const Fields& message);
  void instruct(bus::Message goal);
  void take_result(const bus::Delivery& result);
  pb::MessagePtr machines() const;

  RefboxContext& context_;
  Controllers& controllers_;
  const Team team_;
  Channel channel_;
  Heard machines_, reports_;
  Rate machine_rate_, ring_rate_, report_rate_;
  std::string machines_sent_;                ///< the last MachineInfo
  int machine_count_ = 0;                    ///< MachineInfos sent so far
  std::optional<std::int64_t> clock_ahead_;  ///< s: of the team's clock, by its youngest message
  const bus::ActionType* action_ = nullptr;
  bus::EndpointId instruct_{}, report_{};
  std::map<bus::GoalId, Instructed> instructed_;  ///< running goals
};

}  // namespace cxlab::rcll
