#pragma once
// What the parts of a league client share: its settings, its node on the bus, and the channels of the referee box.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/network/host.h"
#include "cx/protobuf/types.h"
#include "scenarios/catalogue.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/messages.h"

namespace cxlab::rcll {

struct LeagueClientConfig {
  std::string team = "CYAN";
  std::string team_name = "cxlab";  ///< said in beacons
  int robots = 3;                   ///< of the team, 0..3
  std::string key = "randomkey";    ///< of the team's channel; empty: not encrypted
  std::string cipher = "aes-128-cbc";
  int first_robot = 1;           ///< in the order of all robots of the game, from which their ports follow
  int port_shift = 0;            ///< added to all ports
  std::string name_space = "/";  ///< of topics and actions

  template <class Keys>
  void fields(Keys& keys) {
    keys.word("team", team, {"CYAN", "MAGENTA"});
    keys("team_name", team_name);
    keys("robots", robots);
    keys("key", key);
    keys.word("cipher", cipher, {"aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"});
    keys("first_robot", first_robot);
    keys("port_shift", port_shift);
    keys("namespace", name_space);
  }
};
/// Numbers in their ranges, and a namespace that can be one.
Status check(const LeagueClientConfig& config);

class LeagueLink {
 public:
  /// `take` is called with what comes from the network. What the stage is made with outlives it.
  static Expected<std::unique_ptr<LeagueLink>> open(const LeagueClientConfig& config, const StageSetup& setup,
                                                    net::Host::Handler take);

  const LeagueClientConfig config;
  bus::Bus& bus;
  const bus::ParticipantId node;
  SimTime now{};  ///< of the tick
  Moment moment() const { return Moment::of(epoch_, now); }

  Channel& everybody() { return *everybody_; }  ///< the public channel
  Channel& team() { return *team_; }
  /// Opens the channel of a robot of the team; `number` counts from 1.
  Channel open_robot(int number);
  pb::MessagePtr make(const std::string& type) const { return types_->make(type); }
  const pb::Types& types() const { return *types_; }

 private:
  LeagueLink(const LeagueClientConfig& settings, const StageSetup& setup);
  Status open_channels(net::Network& network, net::Host::Handler take);
  std::uint16_t port(int number) const { return static_cast<std::uint16_t>(number + config.port_shift); }

  double epoch_;
  std::unique_ptr<pb::Types> types_;
  std::unique_ptr<net::Host> host_;
  std::optional<Channel> everybody_, team_;
};

}  // namespace cxlab::rcll
