// The referee box of a game and the node that speaks with one. Both are on a network on which strangers send anything:
// raw datagrams, and frames of any type on each channel, encrypted with its key. A tick follows each.

#include <google/protobuf/message.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "cx/network/network.h"
#include "cx/protobuf/wire.h"
#include "cx/run/loop.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/refbox/league_link.h"
#include "scenarios/rcll/refbox/node.h"
#include "scenarios/rcll/world.h"
#include "scenarios/stage.h"
#include "tests/fuzz/surroundings.h"

namespace fuzz_refbox {
namespace {

using namespace cxlab;

/// Records nothing.
struct Nowhere final : RecordSink {
  StreamId open_stream(std::string_view) override { return {}; }
  RecordRef write(StreamId, SimTime, RecordKind, const RecordData&, std::span<const RecordRef>) override { return {}; }
};

struct Way {
  std::uint16_t to = 0;
  bool encrypted = false;
};
constexpr Way kWays[]{{4445}, {4446, true}, {2126}, {4444}, {4441, true}, {2116}};

struct Game {
  Game();
  void play(const std::uint8_t* data, std::size_t size);
  void tick() { fuzz::promise(loop->tick().ok(), "a tick passes"); }

  Nowhere sink;
  bus::Bus bus{fuzz::registry(), sink};
  net::Network network{bus, sink};
  Scenario scenario;
  std::unique_ptr<Stage> stage;
  std::optional<Loop> loop;
  bus::ParticipantId stranger{};
  std::unique_ptr<net::Host> host;
  std::unique_ptr<pb::Crypto> crypto;
};

/// A game file; drawing a layout takes longer than playing many inputs.
const std::string& game_file() {
  static const std::string file = [] {
    const std::filesystem::path path = fuzz::folder() / "game.yaml";
    std::ofstream(path) << rcll::to_yaml(*rcll::game_of(rcll::WorldConfig{}, 1));
    return path.string();
  }();
  return file;
}

Game::Game() {
  rcll::WorldConfig config;
  config.exploration = true;
  config.setup_s = 0.5;  // which controllers may end
  config.refbox.confirm_deliveries = true;
  config.game = game_file();
  scenario.set_world({&rcll::kWorld, config, {}});
  scenario.tier = Tier::kTimed;
  scenario.servers.push_back({&rcll::kLeagueClient, rcll::LeagueClientConfig{.name_space = "/outside"}, {}});
  const StageSetup setup{.scenario = scenario, .bus = bus, .sink = sink, .network = &network};
  auto made = rcll::kWorld.make_stage(setup);
  fuzz::promise(made.ok() && rcll::kLeagueClient.add(scenario.servers[0], setup, **made).ok(), "there is a game");
  stage = *std::move(made);
  Parts parts{.referee = stage->referee};
  for (auto& world : stage->worlds) parts.worlds.push_back(world.get());
  for (auto& server : stage->servers) parts.servers.push_back(server.get());
  loop.emplace(bus, scenario.tick, std::move(parts));
  stranger = bus.join(bus::ParticipantKind::kNode, bus::NodeName{"stranger", "/", {}}, {});
  host = *net::Host::create(network, stranger, [](const net::Event&) {});
  crypto = *pb::Crypto::create(pb::Cipher::kAes128Cbc, "randomkey");
}

void Game::play(const std::uint8_t* data, std::size_t size) {
  const net::LinkId stream = host->connect(4444);
  for (int i = 0; i < 3; ++i) tick();

  // Pieces: how and where, the length, the bytes.
  for (std::size_t at = 0; at + 2 <= size;) {
    const std::size_t how = data[at], length = std::min<std::size_t>(data[at + 1], size - at - 2);
    std::string bytes = fuzz::text_of(data + at + 2, length);
    at += 2 + length;
    const Way& way = kWays[how / 4 % std::size(kWays)];
    if (how % 4 >= 1 && bytes.size() >= 4) {
      const auto number = [&](std::size_t i) {
        return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[i]) << 8 |
                                          static_cast<unsigned char>(bytes[i + 1]));
      };
      const pb::MessageKey key{number(0), number(2)};
      bytes = pb::write_frame(key, bytes.substr(4), way.encrypted && how % 4 == 2 ? crypto.get() : nullptr);
    }
    if (how % 4 == 3) {
      host->send(stream, bytes);
    } else {
      const net::LinkId link = host->open_datagrams(way.to, 9);
      host->send(link, bytes);
      host->close(link);
    }
    tick();
    bus.deliver(stranger);
  }
  for (int i = 0; i < 5; ++i) tick();
  host->close(stream);
}

}  // namespace

FUZZ_TARGET(refbox) {
  // Making a game takes long, so one serves many inputs.
  fuzz::registry();  // outlives the game
  static std::unique_ptr<Game> game;
  static int inputs = 0;
  if (inputs++ % 200 == 0) game = std::make_unique<Game>();
  game->play(data, size);
  return 0;
}

}  // namespace fuzz_refbox
