#pragma once
// A game of the timed tier with its referee box on the network, and programs of a test that speak with it.

#include <gmock/gmock.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/network/network.h"
#include "cx/protobuf/types.h"
#include "cx/run/loop.h"
#include "scenarios/rcll/refbox/league_link.h"
#include "scenarios/rcll/refbox/messages.h"
#include "scenarios/rcll/refbox/node.h"
#include "scenarios/rcll/world.h"
#include "scenarios/stage.h"
#include "tests/support/test_bus.h"

namespace cxlab::rcll {

/// Ports of the referee box and of robot 1.
struct Way {
  std::uint16_t send = 0, receive = 0;
};
inline constexpr Way kPublicWay{4445, 4444}, kCyanWay{4446, 4441}, kMagentaWay{4447, 4442}, kRobot1{2126, 2116};
inline constexpr const char* kLeagueKey = "randomkey";

class RefboxStory : private bus::TestBus {
 public:
  /// What came to a program: when, and the message as text.
  struct Heard {
    double at = 0;
    std::string type, text;
    std::shared_ptr<google::protobuf::Message> message;
  };
  struct Program {
    net::LinkId link{};
    std::unique_ptr<pb::Crypto> crypto;
    std::vector<Heard> heard;
    /// Times at which that type came.
    std::vector<double> times(const std::string& type) const {
      std::vector<double> out;
      for (const Heard& h : heard)
        if (h.type == type) out.push_back(h.at);
      return out;
    }
    /// The last of that type; nullptr if none came.
    const Heard* last(const std::string& type) const {
      const Heard* found = nullptr;
      for (const Heard& h : heard)
        if (h.type == type) found = &h;
      return found;
    }
    std::string last_text(const std::string& type) const {
      const Heard* found = last(type);
      return found ? found->text : "none came";
    }
  };

  /// `client`: with a league_client, whose topics and actions begin with /outside.
  explicit RefboxStory(const WorldConfig& config = game(), std::optional<LeagueClientConfig> client = {}) {
    scenario_.set_world({&kWorld, config, {}});
    scenario_.tier = Tier::kTimed;
    const StageSetup setup{.scenario = scenario_, .bus = bus_, .sink = sink_, .network = &network_, .log = &log_};
    auto stage = kWorld.make_stage(setup);
    EXPECT_TRUE(stage) << (stage ? "" : stage.error().text());
    stage_ = *std::move(stage);
    if (client) {
      client->name_space = "/outside";
      EXPECT_TRUE(kLeagueClient.add(ServerSpec{&kLeagueClient, *client, {}}, setup, *stage_));
    }
    types_ = *load_types();
    agent_ = join(bus::ParticipantKind::kEnvironment, "env/agent", {"agent", "/", {}});
    host_ = *net::Host::create(network_, agent_, [this](const net::Event& event) { take(event); });
    Parts parts{.referee = stage_->referee, .agents = {&player_}};
    for (auto& world : stage_->worlds) parts.worlds.push_back(world.get());
    for (auto& server : stage_->servers) parts.servers.push_back(server.get());
    loop_.emplace(bus_, scenario_.tick, std::move(parts));
  }

  /// No down periods; one C0 order, and exploration is over.
  static WorldConfig game() {
    WorldConfig config;
    config.down = false;
    OrderConfig order;
    order.base_color = "BASE_RED";
    order.cap_color = "CAP_GREY";
    config.orders = {order};
    return config;
  }

  Program& open(const Way& way, const std::string& key = {}) {
    Program& program = programs_[host_->open_datagrams(way.send, way.receive)];
    program.link = std::prev(programs_.end())->first;
    if (!key.empty()) program.crypto = *pb::Crypto::create(pb::Cipher::kAes128Cbc, key);
    return program;
  }
  Program& open_stream(std::uint16_t port = 4444) {
    const net::LinkId link = host_->connect(port);
    readers_[link];
    programs_[link].link = link;
    return programs_[link];
  }

  /// A message from its text: name without package, fields in protobuf's text format.
  pb::MessagePtr message(const std::string& type, const std::string& fields) const;
  void say(Program& program, const std::string& type, const std::string& fields) {
    send(program, *pb::Types::write(*message(type, fields), program.crypto.get()));
  }
  void send(Program& program, const std::string& bytes) { host_->send(program.link, bytes); }

  /// How a goal ended.
  struct Outcome {
    bool rejected = false, ended = false;
    bus::GoalStatus status{};
    std::int64_t code = -1;
    std::string text;  ///< the result
    std::vector<std::string> feedback;
    bus::EndpointId client{};
    bus::GoalId goal{};
  };
  /// Sends a goal; the outcome is filled in later.
  std::shared_ptr<Outcome> send_goal(const std::string& action, const std::string& type, const std::string& yaml);
  /// The last message of that topic as text, filled in later.
  std::shared_ptr<std::string> listen(const std::string& topic, const std::string& type);
  void cancel(const Outcome& outcome) { bus_.cancel_goal(outcome.client, outcome.goal); }

  void run_until(double seconds) {
    loop_->set_end(from_seconds(seconds));
    while (loop_->now() < from_seconds(seconds))
      ASSERT_TRUE(every_tick_ && loop_->ticks() > 0 ? loop_->tick_at(loop_->now() + scenario_.tick) : loop_->tick());
  }
  void run_for(double seconds) { run_until(now() + seconds); }
  double now() const { return std::max(0.0, to_seconds(loop_->now())); }
  /// From now on also the ticks at which nothing is due.
  void take_every_tick() { every_tick_ = true; }
  std::int64_t ticks() const { return loop_->ticks(); }

  const std::vector<std::string>& warnings() const { return log_.lines; }
  bus::Bus& bus() { return bus_; }
  const KeptRecords& records() const { return sink_; }

 private:
  struct Log final : cx::LogSink {
    void line(const cx::LogLine& line) override { lines.emplace_back(line.text); }
    std::vector<std::string> lines;
  };
  /// Takes what comes.
  struct Player final : Agent {
    explicit Player(RefboxStory& of) : story(of) {}
    Status perceive() override {
      story.bus_.deliver(story.agent_);
      return {};
    }
    Status decide(SimTime) override { return {}; }
    Status act() override { return {}; }
    SimTime next_due() const override { return kNever; }
    RefboxStory& story;
  };

  void take(const net::Event& event);
  void keep(Program& program, const Expected<pb::MessagePtr>& message);

  net::Network network_{bus_, sink_};
  Log log_;
  Scenario scenario_;
  std::unique_ptr<Stage> stage_;
  std::unique_ptr<pb::Types> types_;
  bus::ParticipantId agent_{};
  std::unique_ptr<net::Host> host_;
  std::map<net::LinkId, Program> programs_;
  std::map<net::LinkId, pb::StreamReader> readers_;
  Player player_{*this};
  std::optional<Loop> loop_;
  bool every_tick_ = false;
};

}  // namespace cxlab::rcll
