#include "scenarios/rcll/stage.h"

#include <cstdio>

#include "scenarios/rcll/floor_plan.h"
#include "scenarios/rcll/layout.h"
#include "scenarios/rcll/machine_faults.h"
#include "sim/ledger/ledger_world.h"

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

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

Expected<sim::ModelOptions> model_options(const Scenario& scenario, const std::filesystem::path& models) {
  if (!std::filesystem::is_directory(models))
    return resource_error("there is no folder of models at " + models.string());
  sim::ModelOptions options;
  options.models = models;
  options.step = to_seconds(scenario.physics_step);
  return options;
}

Expected<std::unique_ptr<GameStage>> GameStage::create(const Scenario& scenario, const std::filesystem::path& models,
                                                       bus::Bus& bus, RecordSink& sink) {
  auto stage = std::make_unique<GameStage>();
  if (Status s = stage->build(scenario, models, bus, sink); !s) return s.error();
  return stage;
}

Status GameStage::build(const Scenario& scenario, const std::filesystem::path& models, bus::Bus& bus,
                        RecordSink& sink) {
  step_ = scenario.physics_step;
  auto plan = floor_plan_of(scenario.rcll, scenario.seed);
  if (!plan) return plan.error();
  if (scenario.tier == Tier::kPhysics) {
    auto options = model_options(scenario, models);
    if (!options) return options.error();
    auto made = sim::MujocoWorld::create(*plan, *options, &physics_log_);
    if (!made) return made.error();
    physics_ = made->get();
    floor_ = physics_;
    files = physics_->model_files();
    worlds.push_back(*std::move(made));
    auto fleet = sim::Fleet::create(*physics_, *physics_, zone_places(), bus, sink, {scenario.faults, scenario.seed});
    if (!fleet) return fleet.error();
    fleet_ = fleet->get();
    servers.push_back(*std::move(fleet));
  } else {
    auto ledger = std::make_unique<sim::LedgerWorld>(*plan);
    floor_ = ledger.get();
    auto fleet = sim::Fleet::create(*ledger, *ledger, scenario.timed, scenario.seed, zone_places(), bus, sink,
                                    {scenario.faults, scenario.seed});
    if (!fleet) return fleet.error();
    fleet_ = fleet->get();
    worlds.push_back(std::move(ledger));
    servers.push_back(*std::move(fleet));
  }
  auto factory = Factory::make(scenario.rcll, scenario.seed, *floor_, bus, sink);
  if (!factory) return factory.error();
  factory_ = factory->get();
  auto faults = MachineFaults::make(scenario.faults, scenario.seed, factory_->machines(), *floor_, sink);
  if (!faults) return faults.error();
  servers.push_back(*std::move(faults));
  servers.push_back(*std::move(factory));
  referee = factory_;
  return {};
}

void GameStage::report(Result& result) const {
  const GameReferee& game = factory_->referee();
  for (const Team team : kTeams) {
    TeamResult out{std::string(to_string(team)), game.score(team).total(), {}};
    for (std::size_t kind = 0; kind < kPointKinds; ++kind)
      out.by_kind.emplace_back(to_string(static_cast<PointKind>(kind)), game.score(team).by_kind[kind]);
    result.teams.push_back(std::move(out));
  }
  const auto team = static_cast<std::size_t>(factory_->team());
  for (const OrderState& state : game.orders()) {
    OrderResult out{state.order.id,
                    std::string(to_string(state.order.complexity)),
                    to_seconds(state.released.value_or(factory_->clock().at(state.order.activate_at))),
                    {},
                    false,
                    state.points[team]};
    if (state.delivered_at[team]) out.delivered_at = to_seconds(*state.delivered_at[team]);
    out.correct = state.delivered[team] > 0;
    result.orders.push_back(std::move(out));
  }
  for (const Delivery& d : game.deliveries())
    result.deliveries.push_back(
        {d.order, std::string(to_string(d.team)), to_seconds(d.at), d.correct, d.late_s, d.points});
  int index = 0;
  for (const sim::RobotStats& s : fleet_->stats()) {
    const auto contacts = floor_->robot(sim::RobotId{index++}).robot_contacts;
    result.robots.push_back({s.name, s.busy_s, s.drive_s, s.wait_s, s.skills, s.failures, static_cast<int>(contacts)});
  }
  if (physics_) {
    result.steps = physics_->gate().steps();
    result.physics_hash = hex(physics_->physics_hash());
  }
}

Expected<std::unique_ptr<Stage>> make_stage(const Scenario& scenario, const std::filesystem::path& models,
                                            bus::Bus& bus, RecordSink& sink) {
  auto stage = GameStage::create(scenario, models, bus, sink);
  if (!stage) return stage.error();
  return std::unique_ptr<Stage>(*std::move(stage));
}

}  // namespace cxlab::rcll
