#include "scenarios/rcll/refbox/league_link.h"

#include <google/protobuf/message.h>

#include "cx/bus/names.h"

namespace cxlab::rcll {

Status check(const LeagueClientConfig& config) {
  const auto range = [](const char* key, int found, int least, int most) {
    if (found >= least && found <= most) return Status();
    return Status(
        input_error(std::string(key) + ": " +
                    found_expected(std::to_string(found), std::to_string(least) + " to " + std::to_string(most))));
  };
  if (Status s = range("robots", config.robots, 0, 3); !s) return s;
  if (Status s = range("first_robot", config.first_robot, 1, 4); !s) return s;
  if (Status s = range("port_shift", config.port_shift, -1000, 60000); !s) return s;
  return bus::check_node(config.name_space, {});
}

LeagueLink::LeagueLink(const LeagueClientConfig& settings, const StageSetup& setup)
    : config(settings),
      bus(setup.bus),
      node(bus.join(bus::ParticipantKind::kNode, bus::NodeName{"league_client", config.name_space, {}},
                    setup.sink.open_stream("node/league_client"))),
      epoch_(setup.scenario.epoch) {}

Expected<std::unique_ptr<LeagueLink>> LeagueLink::open(const LeagueClientConfig& config, const StageSetup& setup,
                                                       net::Host::Handler take) {
  std::unique_ptr<LeagueLink> link(new LeagueLink(config, setup));
  auto types = load_types(setup.keep);
  if (!types) return types.error();
  link->types_ = *std::move(types);
  if (Status s = link->open_channels(*setup.network, std::move(take)); !s) return s.error();
  return link;
}

Status LeagueLink::open_channels(net::Network& network, net::Host::Handler take) {
  auto host = net::Host::create(network, node, std::move(take));
  if (!host) return host.error();
  host_ = *std::move(host);
  std::unique_ptr<pb::Crypto> crypto;
  if (!config.key.empty()) {
    const auto cipher = pb::cipher_of(config.cipher);
    if (!cipher) return cipher.error();
    auto made = pb::Crypto::create(*cipher, config.key);
    if (!made) return made.error();
    crypto = *std::move(made);
  }
  const int magenta = config.team == "MAGENTA" ? 1 : 0;
  everybody_.emplace(*host_, "public channel", port(4445), port(4444));
  team_.emplace(*host_, "channel of the team", port(4446 + magenta), port(4441 + magenta), std::move(crypto));
  return {};
}

Channel LeagueLink::open_robot(int number) {
  const int of_game = config.first_robot + number - 2;
  return Channel(*host_, "channel of robot " + std::to_string(number), port(2126 + of_game), port(2116 + of_game));
}

}  // namespace cxlab::rcll
