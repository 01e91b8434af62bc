#pragma once
// The referee box on the network of a game (docs/reference/rcll-protocol.md). It sends the factory's messages on the
// bus as messages of the league. Messages of teams become instructions, reports and requests on the bus, and messages
// of controllers become calls of the factory. It judges nothing.
//
//   public channel     GameState, OrderInfo, RobotInfo, VersionInfo, BeaconSignal; takes BeaconSignal
//   team's channel     team_peer.h
//   streams (TCP)      controllers.h
//   robots             robot_peer.h
//
// Teams are told what the league tells them, whatever `information` says of the topics. It does nothing, and reads
// nothing, before anybody listens or sends.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/network/host.h"
#include "cx/protobuf/types.h"
#include "cx/run/parts.h"
#include "scenarios/catalogue.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/controllers.h"
#include "scenarios/rcll/refbox/refbox_context.h"
#include "scenarios/rcll/refbox/robot_peer.h"
#include "scenarios/rcll/refbox/team_peer.h"
#include "scenarios/rcll/rules/config.h"
#include "sim/world.h"

namespace cxlab::rcll {

class RefboxServer final : public Server {
 public:
  /// Opens its ports. World, factory and what the stage is made with outlive it. It comes before the robots and the
  /// factory in a tick, so that they act at once on what it has heard.
  static Expected<std::unique_ptr<RefboxServer>> make(const WorldConfig& config, const sim::World& world,
                                                      Factory& factory, const StageSetup& setup);

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

 private:
  RefboxServer(const WorldConfig& config, const sim::World& world, Factory& factory, const StageSetup& setup);
  Status open_ports();
  Status begin();
  bool is_heard() const;
  void take(const net::Event& event);

  void tell_that_nobody_came();
  void speak();
  void speak_public();
  /// To controllers as well.
  void send_public(const google::protobuf::Message& message);
  pb::MessagePtr game_state() const;
  pb::MessagePtr orders() const;
  pb::MessagePtr version() const;

  const RefboxConfig config_;
  net::Network& network_;
  std::function<Status(const std::string&, const std::filesystem::path&)> keep_;
  RefboxContext context_;
  std::unique_ptr<net::Host> host_;
  bool ports_shared_ = false, somebody_came_ = false;
  SimTime begun_{};
  Status status_;

  std::optional<Channel> public_;
  std::optional<Controllers> controllers_;
  std::vector<std::unique_ptr<TeamPeer>> teams_;
  std::vector<std::unique_ptr<RobotPeer>> robots_;

  Heard game_state_, order_info_, ring_info_;
  Rate beacon_rate_, game_rate_, order_rate_, robot_rate_, version_rate_;
  int order_burst_ = 0;          ///< OrderInfos that still follow quickly
  std::size_t order_count_ = 0;  ///< orders that were sent so far
  std::uint64_t beacons_ = 0;
};

}  // namespace cxlab::rcll
