#pragma once
// A topic of the factory that is published periodically, and when something has changed.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/bus/bus.h"
#include "sim/pose.h"

namespace cxlab::rcll {

/// The package of the league's messages, with a slash.
inline constexpr std::string_view kInterfaces = "rcll_interfaces/";

/// How often the field is told of orders, machines, rings and workpieces, and of what teams reported.
inline constexpr SimTime kInfoPeriod = std::chrono::seconds(2), kReportPeriod = std::chrono::seconds(1);

/// When a message is sent again.
struct Rate {
  SimTime period{};
  SimTime next{};
  /// Whether it is to be sent now; plans its next time.
  bool due(SimTime now);
};

class PeriodicTopic {
 public:
  /// Advertises it. `type`: of the league's messages, for example "GameState".
  Status open(bus::Bus& bus, bus::ParticipantId node, std::string_view name, std::string_view type, SimTime period);
  /// Whether it is to be published now; plans its next time.
  bool due(SimTime now, bool changed);
  SimTime next() const { return rate_.next; }
  bus::Message message() const { return bus::Message(*type_); }
  void publish(bus::Bus& bus, bus::Message message) const;

 private:
  const bus::MessageType* type_ = nullptr;
  bus::EndpointId endpoint_{};
  Rate rate_;
};

/// Fills a list of strings.
void put_texts(const bus::MessageView& message, std::string_view field, const std::vector<std::string_view>& texts);
/// Fills the field "pose".
void put_pose(const bus::MessageView& message, const sim::Pose2& pose);

}  // namespace cxlab::rcll
