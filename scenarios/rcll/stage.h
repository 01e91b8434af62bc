#pragma once
// The stage of a Logistics League game: field, robots with their skills, machines, referee.

#include <memory>
#include <string>

#include "cx/base/expected.h"
#include "scenarios/catalogue.h"
#include "scenarios/rcll/factory.h"
#include "sim/skills/fleet.h"

namespace cxlab::sim {
class MujocoWorld;
class PhysicsLog;
}  // namespace cxlab::sim

namespace cxlab::rcll {

class GameStage final : public Stage {
 public:
  /// Servers in the order robots, faults of machines, factory.
  static Expected<std::unique_ptr<Stage>> create(const StageSetup& setup);
  ~GameStage() override;

  std::string take_inputs() override;
  void report(Result& result) const override;

  const sim::World& floor() const { return *floor_; }
  const Factory& factory() const { return *factory_; }

 private:
  GameStage();
  Status build(const StageSetup& setup);
  Status build_physics(const StageSetup& setup, sim::FloorPlan plan);
  Status build_ledger(const StageSetup& setup, sim::FloorPlan plan);
  Status add_fleet(Expected<std::unique_ptr<sim::Fleet>> fleet);

  std::unique_ptr<sim::PhysicsLog> physics_log_;
  sim::World* floor_ = nullptr;  // one of the two tiers, owned as world
  sim::MujocoWorld* physics_ = nullptr;
  sim::Fleet* fleet_ = nullptr;  // owned as servers
  Factory* factory_ = nullptr;
};

/// The physics of a recorded game.
Expected<std::unique_ptr<WorldReplay>> replay(const Scenario& scenario, const std::filesystem::path& models,
                                              const std::string& log);

}  // namespace cxlab::rcll
