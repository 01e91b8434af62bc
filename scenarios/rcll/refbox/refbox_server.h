#pragma once
// The referee box on the network of a game (docs/rcll-protocol.md): what the factory says on the bus goes out as
// messages of the league, what teams send becomes instructions, reports and requests on the bus, what controllers send
// becomes calls of the factory. It judges nothing.
//
//   public channel     GameState, OrderInfo, RobotInfo, VersionInfo, BeaconSignal; takes BeaconSignal
//   team's channel     MachineInfo, RingInfo, MachineReportInfo; takes PrepareMachine, ResetMachine, MachineReport,
//                      SetRobotMaintenance
//   streams (TCP)      for controllers: all of the above with what teams must not know, WorkpieceInfo,
//                      AttentionMessage; takes SetGameState, SetGamePhase, SetTeamName, SetRobotMaintenance,
//                      SetMachineState, ConfirmDelivery
//   robots             AgentTask (robot_peer.h)
//
// Teams are told what the league tells them, whatever `information` says of the topics. Nothing happens, and nothing
// is read, before anybody listens or sends.

#include <array>
#include <cstdint>
#include <functional>
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
#include "cx/network/host.h"
#include "cx/protobuf/types.h"
#include "cx/protobuf/wire.h"
#include "cx/run/parts.h"
#include "scenarios/catalogue.h"
#include "scenarios/rcll/config.h"
#include "scenarios/rcll/factory.h"
#include "scenarios/rcll/refbox/channel.h"
#include "scenarios/rcll/refbox/messages.h"
#include "scenarios/rcll/refbox/robot_peer.h"
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
  /// When a message is sent again.
  struct Rate {
    SimTime period{};
    SimTime next{};
    bool due(SimTime now);
  };
  /// What the bus said last.
  struct Heard {
    bus::SharedMessage message;
    bool fresh = false;  ///< not looked at yet
  };
  struct Instructed {
    std::string machine;
    bool busy = false;  ///< it was not idle: what is said to it is ignored without a word
  };
  struct TeamSide {
    TeamSide(Team whose, Channel&& way) : team(whose), channel(std::move(way)) {}
    Team team;
    Channel channel;
    Heard machines, reports;
    Rate machine_rate, ring_rate, report_rate;
    std::string machines_sent;                ///< the last MachineInfo
    int machine_count = 0;                    ///< MachineInfos sent so far
    std::optional<std::int64_t> clock_ahead;  ///< s: of the team's clock, by its youngest message
    const bus::ActionType* action = nullptr;
    bus::EndpointId instruct{}, report{}, maintenance{};
    std::map<bus::GoalId, Instructed> instructed;  ///< goals under way
  };
  /// What a robot of a team has told of itself.
  struct Acquaintance {
    std::string name, host;
    Moment seen;
    SimTime heard{};
  };

  RefboxServer(const WorldConfig& config, const sim::World& world, Factory& factory, const StageSetup& setup);
  Status open_ports();
  Status begin();
  Status begin(TeamSide& side);
  bool is_heard() const;

  void take(const net::Event& event);
  void take_stream(const net::Event& event);
  void take_public(const Fields& message, const std::string& type, const net::Event& event);
  void take_team(TeamSide& side, const Fields& message, const std::string& type, const net::Event& event);
  void take_controller(const Fields& message, const std::string& type);
  /// What speaks against what a controller says; empty if nothing does.
  std::string control(const Fields& message, std::string_view type);
  std::string set_phase(const std::string& phase);
  std::string set_machine(const std::string& machine, const std::string& state);
  void take_beacon(const Fields& beacon, const net::Event& event);
  /// The same message on a topic.
  void pass_on(const Fields& message, const char* type, bus::EndpointId topic);
  void prepare(TeamSide& side, const Fields& message);
  void instruct(TeamSide& side, bus::Message goal);
  void take_result(TeamSide& side, const bus::Delivery& result);
  bool is_stale(TeamSide& side, const Fields& message);
  void name_team(Team team, const std::string& name);

  void speak();
  void speak_public();
  void speak_team(TeamSide& side);
  void speak_streams();
  /// Tells controllers what people should look after, each once while it lasts.
  void look_after();
  void attention(const std::string& text, Team team);
  void send_public(const google::protobuf::Message& message);
  void send_streams(const google::protobuf::Message& message);
  pb::MessagePtr make(std::string_view type) const;
  pb::MessagePtr game_state() const;
  pb::MessagePtr orders() const;
  /// For teams; for controllers with poses.
  pb::MessagePtr robots(bool poses) const;
  pb::MessagePtr machines(const TeamSide& side) const;
  pb::MessagePtr all_machines() const;
  pb::MessagePtr workpieces() const;
  pb::MessagePtr version() const;

  /// A line for people, each once.
  void complain(const std::string& text);
  Moment moment() const;
  TeamSide* side_of(Team team);

  const RefboxConfig config_;
  const sim::World& world_;
  Factory& factory_;
  bus::Bus& bus_;
  net::Network& network_;
  cx::LogSink* log_;
  double epoch_;
  std::vector<Team> teams_;
  std::function<Status(const std::string&, const std::filesystem::path&)> keep_;

  bus::ParticipantId node_{};
  std::unique_ptr<net::Host> host_;
  net::LinkId server_{};
  std::unique_ptr<pb::Types> types_;  ///< none before it has begun
  bool ports_shared_ = false;
  Status status_;
  SimTime now_{};

  std::optional<Channel> public_;
  std::vector<std::unique_ptr<TeamSide>> sides_;
  std::vector<std::pair<std::size_t, Channel>> robot_channels_;  ///< until it begins: by robot
  std::vector<std::unique_ptr<RobotPeer>> robots_;
  std::map<net::LinkId, pb::StreamReader> streams_;
  Rate stream_rate_, workpiece_rate_;  ///< while there are streams
  std::set<std::string> attentions_;   ///< that last

  const bus::MessageType *machine_type_ = nullptr, *robot_type_ = nullptr;
  Heard game_state_, order_info_, ring_info_;
  Rate beacon_rate_, game_rate_, order_rate_, robot_rate_, version_rate_;
  int order_burst_ = 0;          ///< OrderInfos that still follow quickly
  std::size_t order_count_ = 0;  ///< orders that were sent so far
  std::uint64_t beacons_ = 0;
  std::array<std::string, 2> team_names_;
  std::array<bool, 2> named_{};
  std::map<std::pair<Team, std::int64_t>, Acquaintance> acquaintances_;
  std::set<std::string, std::less<>> complaints_;
};

}  // namespace cxlab::rcll
