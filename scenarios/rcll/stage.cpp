#include "scenarios/rcll/stage.h"

#include "cx/journal/hash_text.h"
#include "scenarios/rcll/floor_plan.h"
#include "scenarios/rcll/layout.h"
#include "scenarios/rcll/machine_faults.h"
#include "scenarios/rcll/result.h"
#include "sim/ledger/ledger_world.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/mujoco/render.h"

namespace cxlab::rcll {

namespace {

/// Every zone of the field by its name; a robot that stands there faces +y.
sim::Fleet::Places zone_places() {
  sim::Fleet::Places places;
  for (const char side : {'C', 'M'})
    for (int column = 1; column <= 7; ++column)
      for (int row = 1; row <= 8; ++row) {
        const std::string name = std::string(1, side) + "_Z" + std::to_string(column) + std::to_string(row);
        places[name] = centre_of(*zone_named(name), 90);
      }
  return places;
}

class FloorView final : public View {
 public:
  FloorView(std::unique_ptr<sim::Renderer> renderer, const sim::PhysicsGate& floor)
      : renderer_(std::move(renderer)), floor_(floor) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override { return renderer_->draw(floor_, camera); }
  std::vector<std::string> cameras() const override { return {"field", "top"}; }

 private:
  std::unique_ptr<sim::Renderer> renderer_;
  const sim::PhysicsGate& floor_;
};

Expected<std::unique_ptr<View>> view_of_floor(const sim::FloorPlan& plan, const sim::PhysicsGate& floor, int width,
                                              int height) {
  auto renderer = sim::Renderer::create(plan, floor, width, height);
  if (!renderer) return renderer.error();
  return std::unique_ptr<View>(std::make_unique<FloorView>(*std::move(renderer), floor));
}

Expected<sim::ModelOptions> model_options(const Scenario& scenario, const std::filesystem::path& models) {
  if (!std::filesystem::is_directory(models))
    return resource_error("there is no folder of models at " + models.string());
  sim::ModelOptions options;
  options.models = models;
  options.step = to_seconds(scenario.physics_step);
  return options;
}

class FloorReplay final : public WorldReplay {
 public:
  FloorReplay(sim::FloorPlan plan, SimTime step, sim::PhysicsReplay physics)
      : plan_(std::move(plan)), step_(step), physics_(std::move(physics)) {}
  Status advance_to(SimTime t) override { return physics_.advance_to(t / step_); }
  std::string hash() const override { return hash_text(physics_.hash()); }
  Expected<std::unique_ptr<View>> view(int width, int height) const override {
    return view_of_floor(plan_, physics_.gate(), width, height);
  }

 private:
  sim::FloorPlan plan_;
  SimTime step_;
  sim::PhysicsReplay physics_;
};

}  // namespace

GameStage::GameStage() : physics_log_(std::make_unique<sim::PhysicsLog>()) {}
GameStage::~GameStage() = default;

Expected<std::unique_ptr<Stage>> GameStage::create(const StageSetup& setup) {
  std::unique_ptr<GameStage> stage(new GameStage);
  if (Status s = stage->build(setup); !s) return s.error();
  return std::unique_ptr<Stage>(std::move(stage));
}

Status GameStage::build(const StageSetup& setup) {
  const Scenario& scenario = setup.scenario;
  const WorldConfig& config = scenario.world.get<WorldConfig>();
  auto plan = floor_plan_of(config, scenario.seed);
  if (!plan) return plan.error();
  const Status built =
      scenario.tier == Tier::kPhysics ? build_physics(setup, *std::move(plan)) : build_ledger(setup, *std::move(plan));
  if (!built) return built;
  auto factory = Factory::make(config, scenario.seed, *floor_, setup.bus, setup.sink);
  if (!factory) return factory.error();
  factory_ = factory->get();
  auto faults = MachineFaults::make(scenario.faults, scenario.seed, factory_->machines(), *floor_, setup.sink);
  if (!faults) return faults.error();
  servers.push_back(*std::move(faults));
  servers.push_back(*std::move(factory));
  referee = factory_;
  return {};
}

Status GameStage::build_physics(const StageSetup& setup, sim::FloorPlan plan) {
  const Scenario& scenario = setup.scenario;
  auto options = model_options(scenario, setup.models);
  if (!options) return options.error();
  auto made = sim::MujocoWorld::create(std::move(plan), *options, physics_log_.get());
  if (!made) return made.error();
  physics_ = made->get();
  floor_ = physics_;
  files = physics_->model_files();
  worlds.push_back(*std::move(made));
  views.push_back(
      [world = physics_](int width, int height) { return view_of_floor(world->plan(), world->gate(), width, height); });
  return add_fleet(
      sim::Fleet::create(*physics_, *physics_, zone_places(), setup.bus, setup.sink, {scenario.faults, scenario.seed}));
}

Status GameStage::build_ledger(const StageSetup& setup, sim::FloorPlan plan) {
  const Scenario& scenario = setup.scenario;
  auto made = std::make_unique<sim::LedgerWorld>(std::move(plan));
  sim::LedgerWorld& ledger = *made;
  floor_ = &ledger;
  worlds.push_back(std::move(made));
  without_views = "the timed tier has no bodies to look at: --tier physics (render: --set tier=physics)";
  return add_fleet(sim::Fleet::create(ledger, ledger, scenario.timed, scenario.seed, zone_places(), setup.bus,
                                      setup.sink, {scenario.faults, scenario.seed}));
}

Status GameStage::add_fleet(Expected<std::unique_ptr<sim::Fleet>> fleet) {
  if (!fleet) return fleet.error();
  fleet_ = fleet->get();
  servers.push_back(*std::move(fleet));
  return {};
}

std::string GameStage::take_inputs() { return physics_log_->take(); }

void GameStage::report(Result& result) const {
  report_game(*factory_, result);
  report_robots(fleet_->stats(), *floor_, result);
  if (physics_) {
    result.steps = physics_->gate().steps();
    result.physics_hash = hash_text(physics_->physics_hash());
  }
}

Expected<std::unique_ptr<WorldReplay>> replay(const Scenario& scenario, const std::filesystem::path& models,
                                              const std::string& log) {
  auto plan = floor_plan_of(scenario.world.get<WorldConfig>(), scenario.seed);
  if (!plan) return plan.error();
  auto options = model_options(scenario, models);
  if (!options) return options.error();
  auto physics = sim::PhysicsReplay::load(*plan, *options, log);
  if (!physics) return physics.error();
  return std::unique_ptr<WorldReplay>(
      std::make_unique<FloorReplay>(*std::move(plan), scenario.physics_step, *std::move(physics)));
}

}  // namespace cxlab::rcll
