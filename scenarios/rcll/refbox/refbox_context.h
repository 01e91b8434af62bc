#pragma once
// What the parts of the referee box (refbox_server.h) have in common: the game and its time, the bus, who is known, and
// how messages are made.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/node/log.h"
#include "cx/protobuf/types.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/refbox/messages.h"
#include "scenarios/rcll/rules/types.h"
#include "scenarios/rcll/topics/topic.h"
#include "sim/world.h"

namespace cxlab::rcll {

inline constexpr SimTime kBurstPeriod = std::chrono::milliseconds(500);

/// What a topic of the bus said last.
struct Heard {
  bus::SharedMessage message;
  bool fresh = false;  ///< not looked at yet
};

/// What a robot of a team has told of itself.
struct Acquaintance {
  std::string name, host;
  Moment seen;
  SimTime heard{};
};

struct RefboxContext {
  const sim::World& world;
  Factory& factory;
  bus::Bus& bus;
  cx::LogSink* log;  ///< may be none
  double epoch;      ///< s after 1970: when the run began
  const std::vector<Team> teams;
  bus::ParticipantId node{};
  std::unique_ptr<pb::Types> types{};  ///< none before the box has begun
  SimTime now{};
  std::array<std::optional<std::string>, 2> team_names{};  ///< that were told
  std::array<bus::EndpointId, 2> maintenance{};            ///< topics of the teams: SetRobotMaintenance
  std::map<std::pair<Team, std::int64_t>, Acquaintance> acquaintances{};
  std::set<std::string, std::less<>> complaints{};

  Moment moment() const { return Moment::of(epoch, now); }
  bool plays(Team team) const;
  std::string team_name(Team team) const;
  /// The sender of a beacon; the name of its team counts where nobody has told another.
  void meet(const Fields& beacon, std::string_view host);

  /// A message of llsf_msgs; with what the bus says.
  pb::MessagePtr make(std::string_view type) const;
  pb::MessagePtr make(std::string_view type, const bus::MessageView& from) const;
  /// RobotInfo: for teams; for controllers with poses.
  pb::MessagePtr robots(bool poses) const;

  /// A type of rcll_interfaces.
  Expected<const bus::MessageType*> interface(std::string_view type) const;
  Status hear(const std::string& topic, std::string_view type, Heard& heard);
  /// The same message on a topic.
  void pass_on(const Fields& message, std::string_view type, bus::EndpointId topic);
  /// A line for people, each once.
  void complain(const std::string& text);
};

}  // namespace cxlab::rcll
