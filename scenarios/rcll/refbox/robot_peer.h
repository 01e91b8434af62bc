#pragma once
// A robot on the network, as in the league's simulations. It takes an AgentTask from its agent and carries it out with
// its skills. It answers with the same task and its outcome, again every second until the next one. Once a second it
// sends its pose (BeaconSignal), and in exploration the machines that it has seen (MachineReport).
//
// It has one task at a time: the same task_id again is the same task, another one cancels the current task. A task that
// pauses ends its skill; when it goes on, the skill begins again.

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/messages.h"
#include "scenarios/rcll/refbox/refbox_context.h"
#include "scenarios/rcll/rules/types.h"

namespace cxlab::rcll {

class RobotPeer {
 public:
  struct Identity {
    sim::RobotId id{};
    std::string name;  ///< of its node: "robot1"
    Team team{};
    int number = 0;  ///< in its team, from 1
  };

  /// The context outlives it.
  RobotPeer(RefboxContext& context, Identity identity, Channel channel);
  ~RobotPeer();
  RobotPeer(const RobotPeer&) = delete;
  RobotPeer& operator=(const RobotPeer&) = delete;
  /// Opens its actions and topics on the bus.
  Status open();

  Channel& channel() { return channel_; }
  /// A task of its agent; what is wrong with it, where it is none that can be answered.
  std::string take(const Fields& task);
  /// Says what is due.
  void speak();
  SimTime next_due() const { return rate_.next; }

 private:
  /// A goal of one of its skills: fields of the action's goal.
  struct Step {
    std::string_view action;
    std::vector<std::pair<std::string_view, std::string>> fields;
    bool or_next = false;  ///< if nothing lies there the next step is tried
    double wait_s = 0;     ///< of a pick: how long it waits for the piece
  };
  struct Action {
    const bus::ActionType* type = nullptr;
    bus::EndpointId client{};
  };

  struct Plan {
    std::deque<Step> steps;
    std::int64_t error = 0;  ///< why there are none
  };
  Plan plan_of(const Fields& task) const;
  void begin(const google::protobuf::Message& task);
  void stop_skill();
  void next_step();
  void take_answer(const bus::Delivery& delivery);
  void take_result(const bus::Delivery& delivery);
  void end(std::int64_t error, bool canceled = false);
  void answer(const Fields& task, std::int64_t error, bool canceled = false);
  void report(const bus::MessageView& entry, Fields& report) const;
  void take_sightings(const bus::Delivery& delivery);

  RefboxContext& context_;
  Identity identity_;
  Channel channel_;
  std::map<std::string_view, Action> actions_;
  pb::MessagePtr task_;     ///< the current one, or the last one
  pb::MessagePtr waiting_;  ///< that follows when the current skill has ended
  bool under_way_ = false, cancels_ = false, paused_ = false;
  bool stops_ = false;      ///< the skill was told to end before its time
  std::deque<Step> steps_;  ///< the first is the current one
  std::optional<bus::GoalId> goal_;
  std::deque<std::pair<std::int64_t, bool>> finished_;  ///< the last tasks: their ids, whether they were successful
  std::uint64_t beacons_ = 0;
  Rate rate_{std::chrono::seconds(1)};
};

}  // namespace cxlab::rcll
