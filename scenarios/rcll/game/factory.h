#pragma once
// The factory on the bus, node "factory": to all it publishes the game, orders, rings and robots (`/game_state`,
// `/order_info`, `/ring_info`, `/robot_info`), on change and periodically; each team has a channel for its machines
// (team_channel.h).
//
// In a tick, `sense` reports what the machines did. `judge` gives points and releases orders. `act` strikes faults,
// takes goals, lets the machines work, and has robots carried off the field or back. It acts after the skills of the
// robots, so it sees what they did in that tick.
//
// Machines, referee, maintenance and faults go by the floor's clock, which stands while the game is paused; topics by
// simulated time. The service `/set_game_state` of the node "referee" pauses the game and lets it go on.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/bus/transforms.h"
#include "cx/run/parts.h"
#include "scenarios/rcll/game/game.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/event_log.h"
#include "scenarios/rcll/rules/machine_faults.h"
#include "scenarios/rcll/rules/machines.h"
#include "scenarios/rcll/rules/maintenance.h"
#include "scenarios/rcll/rules/pauses.h"
#include "scenarios/rcll/rules/referee.h"
#include "scenarios/rcll/topics/team_channel.h"
#include "scenarios/rcll/topics/topic.h"
#include "sim/faults/fault.h"
#include "sim/floor_records.h"
#include "sim/world.h"

namespace cxlab::rcll {

class Factory final : public Server, public Referee {
 public:
  /// World, bus and sink outlive it; `seed` is that of the faults. Takes those of `faults` that are not about skills;
  /// strikes are written to the stream "faults". Fails on a bad configuration, a fault of an unknown machine, or when
  /// the interface package is missing.
  static Expected<std::unique_ptr<Factory>> make(const WorldConfig& config, const Game& game, std::uint64_t seed,
                                                 sim::World& world, bus::Bus& bus, RecordSink& sink,
                                                 std::span<const sim::Fault> faults = {});

  Status sense(SimTime now) override;
  Status judge(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

  // What a controller of the referee box may do, after `judge` and before `act`. What speaks against it, else empty.
  std::string set_phase(Phase phase) { return referee_.set_phase(phase, world_.floor_time()); }
  std::string confirm_delivery(std::int64_t id, bool correct) {
    return referee_.confirm(id, correct, world_.floor_time());
  }
  /// The referee breaks a machine, as a team's reset does, or ends that it is BROKEN.
  std::string reset_machine(const std::string& name);
  std::string repair_machine(const std::string& name);

  /// What happens in the game, for those who listen.
  EventLog& events() { return events_; }
  const GameReferee& referee() const { return referee_; }
  const Maintenance& maintenance() const { return maintenance_; }
  const std::vector<std::unique_ptr<Machine>>& machines() const { return machines_; }
  const GameClock& clock() const { return context_.clock; }
  const sim::WorldView& floor() const { return world_; }
  GameState state() const { return pauses_.state(); }
  std::vector<Team> teams() const;  ///< that play
  /// Fills a MachineInfo with all there is of every machine.
  void put_machines(const bus::MessageView& info) const;
  /// Fills a RobotInfo.
  void put_robots(const bus::MessageView& info, bool poses) const;
  /// Takes what people should know of what teams send.
  void on_warning(const std::function<void(const std::string&)>& warn);
  /// Asks for RUNNING or PAUSED; `by` is for the journal. What speaks against it, else empty.
  std::string request_state(std::string_view state, std::string by, std::span<const RecordRef> causes = {}) {
    return pauses_.request(state, std::move(by), causes);
  }
  bool over() const override {
    return referee_.phase() == Phase::kPostGame && world_.floor_time() >= referee_.clock().production_end + post_game_;
  }

 private:
  Factory(const WorldConfig& config, const Game& game, std::uint64_t seed, sim::World& world, bus::Bus& bus,
          RecordSink& sink);
  Status join();
  Status serve_state();
  Status broadcast_transforms();

  void publish_game_state();
  void publish_orders();
  void publish_foresight();
  void publish_rings();
  void publish_robots();

  Information information_;
  SimTime post_game_;
  sim::World& world_;
  bus::Bus& bus_;
  RecordSink& sink_;
  sim::FloorRecords records_;
  EventLog events_;
  MachineFaults faults_;
  GameReferee referee_;
  MachineContext context_;
  Maintenance maintenance_;
  Pauses pauses_;
  std::vector<std::unique_ptr<Machine>> machines_;
  std::vector<DownPeriodConfig> down_;  ///< that are to come, once production has begun

  bus::ParticipantId node_{}, referee_node_{};
  std::vector<std::unique_ptr<TeamChannel>> channels_;  ///< of the teams that play
  PeriodicTopic game_state_, order_info_, ring_info_, robot_info_;
  std::optional<PeriodicTopic> foresight_;               ///< where it is wanted
  std::vector<DownPeriodConfig> foreseen_down_;          ///< all of the game
  std::optional<bus::TransformBroadcaster> transforms_;  ///< where they are wanted
  std::uint64_t published_order_changes_ = 0, published_explored_ = 0, published_duties_ = 0;
  std::array<std::int64_t, 2> published_points_{-1, -1};
  Phase published_phase_ = Phase::kSetup;
  GameState published_state_ = GameState::kRunning;
  const bus::ServiceType* state_type_ = nullptr;
  bus::EndpointId state_service_{};
};

}  // namespace cxlab::rcll
