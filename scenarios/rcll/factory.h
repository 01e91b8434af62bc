#pragma once
// The factory on the bus, node "factory": machines take instructions as goals of `/factory/instruct_machine`
// (rcll_interfaces/action/InstructMachine); game, orders, machines, rings and robots are published on `/game_state`,
// `/order_info`, `/machine_info`, `/ring_info` and `/robot_info`, on change and periodically.
//
// In a tick: `sense` reports what the machines did, `judge` gives points and releases orders, `act` strikes faults,
// takes goals and lets the machines work. It acts after the skills of the robots, so that it sees what they did in that
// tick.

#include <array>
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
#include "scenarios/rcll/config.h"
#include "scenarios/rcll/game.h"
#include "scenarios/rcll/machines.h"
#include "scenarios/rcll/referee.h"
#include "sim/faults/fault.h"
#include "sim/world.h"

namespace cxlab::rcll {

class Factory final : public Server, public Referee {
 public:
  /// World, bus and sink outlive it; `seed` is that of the faults. Takes those of `faults` that are about machines;
  /// strikes are written to the stream "faults". Fails on a bad configuration, a fault of an unknown machine, or when
  /// the interface package is missing.
  static Expected<std::unique_ptr<Factory>> make(const WorldConfig& config, const Game& game, std::uint64_t seed,
                                                 sim::World& world, bus::Bus& bus, RecordSink& sink,
                                                 std::span<const sim::Fault> faults = {});

  Status sense(SimTime now) override;
  Status judge(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override;

  const GameReferee& referee() const { return referee_; }
  const std::vector<std::unique_ptr<Machine>>& machines() const { return machines_; }
  const GameClock& clock() const { return context_.clock; }
  Team team() const { return team_; }
  bool over() const override { return referee_.phase() == Phase::kPostGame; }

 private:
  Factory(const WorldConfig& config, const Game& game, std::uint64_t seed, sim::World& world, bus::Bus& bus,
          RecordSink& sink);
  Status join();
  Status take_faults(std::span<const sim::Fault> faults, std::uint64_t seed);
  void strike_faults(SimTime now);
  Status broadcast_transforms();

  /// One topic with its period.
  struct Topic {
    const bus::MessageType* type = nullptr;
    bus::EndpointId endpoint{};
    SimTime period{}, next{};
  };
  Status advertise(Topic& topic, std::string_view name, const std::string& type, SimTime period);
  /// Whether the topic is to be published now; plans its next time.
  static bool due(Topic& topic, SimTime now, bool changed);
  void publish_game_state(SimTime now);
  void publish_orders();
  void publish_machines();
  void publish_rings();
  void publish_robots();

  struct Goal {
    bus::GoalId id{};
    Machine* machine = nullptr;
    std::uint32_t job = 0;
    MachineState reported{};
  };
  void start(const bus::Delivery& delivery);
  void cancel(const bus::Delivery& delivery);
  void report(Goal& goal);
  void finish(const bus::GoalId& goal, InstructError error, const std::string& text, const std::string& machine);
  Machine* find(std::string_view name) const;
  std::string unknown(const std::string& machine) const;  ///< the error that there is no such machine

  Team team_;
  sim::World& world_;
  bus::Bus& bus_;
  RecordSink& sink_;
  MachineContext context_;
  GameReferee referee_;
  std::vector<std::unique_ptr<Machine>> machines_;
  std::vector<std::pair<sim::FaultTimer, Machine*>> faults_;

  bus::ParticipantId node_{};
  const bus::ActionType* action_ = nullptr;
  bus::EndpointId server_{};
  Topic game_state_, order_info_, machine_info_, ring_info_, robot_info_;
  std::optional<bus::TransformBroadcaster> transforms_;  ///< where they are wanted
  std::vector<Goal> goals_;                              ///< running, in order of arrival
  std::uint64_t published_order_changes_ = 0;
  std::array<std::int64_t, 2> published_points_{-1, -1};
  Phase published_phase_ = Phase::kSetup;
};

}  // namespace cxlab::rcll
