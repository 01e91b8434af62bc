#pragma once
// The stage of a Logistics League game: field, robots with their skills, machines, referee.

#include <filesystem>
#include <memory>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "scenarios/rcll/factory.h"
#include "scenarios/scenario.h"
#include "scenarios/stage.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/skills/fleet.h"

namespace cxlab::rcll {

class GameStage final : public Stage {
 public:
  static Expected<std::unique_ptr<GameStage>> create(const Scenario& scenario, const std::filesystem::path& models,
                                                     bus::Bus& bus, RecordSink& sink);

  std::string take_inputs() override { return physics_log_.take(); }
  void report(Result& result) const override;

  /// For pictures; nullptr in the timed tier.
  const sim::MujocoWorld* physics() const { return physics_; }
  const sim::World& floor() const { return *floor_; }
  const Factory& factory() const { return *factory_; }

 private:
  Status build(const Scenario& scenario, const std::filesystem::path& models, bus::Bus& bus, RecordSink& sink);

  sim::PhysicsLog physics_log_;
  SimTime step_{};
  sim::World* floor_ = nullptr;  // one of the two tiers, owned as `world`
  sim::MujocoWorld* physics_ = nullptr;
  sim::Fleet* fleet_ = nullptr;  // owned as servers
  Factory* factory_ = nullptr;
};

/// Everything of a game, from the scenario: servers in the order robots, faults of machines, factory.
Expected<std::unique_ptr<Stage>> make_stage(const Scenario& scenario, const std::filesystem::path& models,
                                            bus::Bus& bus, RecordSink& sink);

/// The floor of a scenario as it is at the start.
Expected<sim::ModelOptions> model_options(const Scenario& scenario, const std::filesystem::path& models);

}  // namespace cxlab::rcll
