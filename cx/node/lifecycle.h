#pragma once
// The life of a node as ROS 2 has it: primary states, the transitions between them, and the services through which
// others ask for them (lifecycle_msgs).

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"

namespace cxlab::cx {

/// Numbers as in lifecycle_msgs/msg/State.
enum class LifeState : std::uint8_t { kUnconfigured = 1, kInactive = 2, kActive = 3, kFinalized = 4 };
/// "unconfigured", "inactive", "active", "finalized".
std::string_view to_string(LifeState state);

/// Numbers as in lifecycle_msgs/msg/Transition; shutdown has one more number for each state that it leaves.
enum class Transition : std::uint8_t { kConfigure = 1, kCleanup = 2, kActivate = 3, kDeactivate = 4, kShutdown = 5 };
/// "configure", "cleanup", "activate", "deactivate", "shutdown".
std::string_view to_string(Transition transition);

class Lifecycle {
 public:
  using Act = std::function<Status(Transition)>;
  using Report = std::function<void(const Error&)>;
  /// `act` does what a transition means; `failed` gets the error of one that was requested on the bus: kUsage when
  /// the state does not allow it, else the error of `act`.
  Lifecycle(bus::Bus& bus, bus::ParticipantId node, Act act, Report failed);

  /// Offers `~/change_state`, `~/get_state`, `~/get_available_states`, `~/get_available_transitions`,
  /// `~/get_transition_graph` and reports transitions on `~/transition_event`.
  Status serve();

  LifeState state() const { return state_; }
  bool allows(Transition transition) const { return row_of(transition) != nullptr; }
  /// Carries out a transition. A configure that fails leaves the node unconfigured; all others reach their goal also
  /// when something in them failed. kUsage if the state does not allow it.
  Status change(Transition transition);

  struct Row;  ///< one transition out of one state

 private:
  const Row* row_of(Transition transition) const;
  /// Carries out what a request asks for; whether that went well.
  bool change_as_wanted(const bus::MessageView& wanted);
  void report_event(const Row& row, bool ended, std::uint8_t id, std::string_view label, LifeState goal);

  bus::Bus& bus_;
  bus::ParticipantId node_;
  Act act_;
  Report failed_;
  LifeState state_ = LifeState::kUnconfigured;
  std::optional<bus::EndpointId> events_;
  const bus::MessageType* event_ = nullptr;
};

/// A service of a node; `answer` fills the response.
struct ServiceOfNode {
  const char *name, *type;
  std::function<void(const bus::MessageView& request, const bus::MessageView& response)> answer;
};
/// Serves them in this order.
Expected<std::vector<bus::EndpointId>> serve(bus::Bus& bus, bus::ParticipantId node,
                                             std::vector<ServiceOfNode> services);

}  // namespace cxlab::cx
