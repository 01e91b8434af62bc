#include "scenarios/rcll/world.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "cx/base/file.h"
#include "cx/journal/hash_text.h"
#include "cx/journal/run_folder.h"
#include "scenarios/floor/sections.h"
#include "scenarios/rcll/floor_view.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/result.h"
#include "scenarios/rcll/game/scene.h"
#include "scenarios/rcll/metrics.h"
#include "scenarios/rcll/page/events.h"
#include "scenarios/rcll/page/page.h"
#include "scenarios/rcll/questions/questions.h"
#include "scenarios/rcll/refbox/refbox_server.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/story/board.h"
#include "sim/ledger/ledger_world.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/skills/fleet.h"

namespace cxlab::rcll {

namespace {

/// Every zone of the field by its name; a robot that stands there faces +y.
sim::Fleet::Places zone_places() {
  sim::Fleet::Places places;
  for (const Team half : kTeams)
    for (int column = 1; column <= kColumns; ++column)
      for (int row = 1; row <= kRows; ++row) {
        const Zone zone{half, column, row};
        places[to_string(zone)] = centre_of(zone, 90);
      }
  return places;
}

Expected<sim::ModelOptions> model_options(const Scenario& scenario, const std::filesystem::path& models) {
  if (!is_folder(models)) return resource_error("there is no folder of models at " + models.string());
  sim::ModelOptions options;
  options.models = models;
  options.step = to_seconds(scenario.physics_step);
  return options;
}

/// The board of a recorded run, at any time; none where the run has no journal.
Expected<BoardAt> recorded_board(const Scenario& scenario, const std::filesystem::path& journal) {
  if (!is_file(journal)) return BoardAt();
  auto board = RecordedBoard::load(scenario.world.get<WorldConfig>(), journal);
  if (!board) return board.error();
  return BoardAt([board = *std::move(board)](SimTime t) { return board.at(t); });
}

class FloorReplay final : public WorldReplay {
 public:
  FloorReplay(sim::FloorPlan plan, const ReplaySetup& setup, sim::PhysicsReplay physics)
      : plan_(std::move(plan)), setup_(setup), physics_(std::move(physics)) {}
  Status advance_to(SimTime t) override { return physics_.advance_to(t / setup_.scenario.physics_step); }
  std::string hash() const override { return hash_text(physics_.hash()); }
  Expected<std::unique_ptr<View>> view(int width, int height) const override {
    auto board = recorded_board(setup_.scenario, setup_.journal);
    if (!board) return board.error();
    return view_of_physics(plan_, physics_.gate(), *std::move(board), width, height);
  }

 private:
  sim::FloorPlan plan_;
  ReplaySetup setup_;
  sim::PhysicsReplay physics_;
};

/// A recorded game without physics.
class SceneOfGame final : public RecordedWorld {
 public:
  SceneOfGame(sim::FloorPlan plan, sim::ModelOptions options, SceneSetup setup)
      : plan_(std::move(plan)), options_(std::move(options)), setup_(std::move(setup)) {}
  Status advance_to(SimTime t) override {
    auto scene = setup_.scenes.at(t);
    if (!scene) return scene.error();
    scene_ = *std::move(scene);
    return {};
  }
  Expected<std::unique_ptr<View>> view(int width, int height) const override {
    auto board = recorded_board(setup_.scenario, setup_.journal);
    if (!board) return board.error();
    return view_of_scene(plan_, options_, [this](SimTime) { return scene_; }, *std::move(board), width, height);
  }

 private:
  sim::FloorPlan plan_;
  sim::ModelOptions options_;
  SceneSetup setup_;
  Scene scene_;
};

/// A game: field, robots with their skills, machines, referee.
class GameStage final : public Stage {
 public:
  Status build(const StageSetup& setup);
  std::string take_inputs() override { return physics_log_.take(); }
  void report(Result& result) const override;

 private:
  Status build_physics(const StageSetup& setup, sim::FloorPlan plan);
  Status build_ledger(const StageSetup& setup, sim::FloorPlan plan);
  bool is_known(sim::RobotId robot, sim::StationId station) const;
  Status add_fleet(const StageSetup& setup, Expected<std::unique_ptr<sim::Fleet>> fleet);

  sim::PhysicsLog physics_log_;
  sim::World* floor_ = nullptr;          // owned as world
  sim::MujocoWorld* physics_ = nullptr;  // the same, in the physics tier
  sim::Fleet* fleet_ = nullptr;          // owned as server, as the factory
  Factory* factory_ = nullptr;
  std::optional<BoardKeeper> board_;  // for pictures
};

/// Servers in the order referee box on the network, robots, factory.
Status GameStage::build(const StageSetup& setup) {
  const Scenario& scenario = setup.scenario;
  const WorldConfig& config = scenario.world.get<WorldConfig>();
  const auto game = game_of(scenario);
  if (!game) return game.error();
  if (!setup.run_folder.empty())
    if (Status s = replace_file(setup.run_folder / "game.yaml", to_yaml(*game)); !s) return s;
  sim::FloorPlan plan = floor_plan_of(config, game->layout);
  const Status built =
      scenario.tier == Tier::kPhysics ? build_physics(setup, std::move(plan)) : build_ledger(setup, std::move(plan));
  if (!built) return built;
  auto factory = Factory::make(config, *game, scenario.seed, *floor_, setup.bus, setup.sink, faults_of(scenario));
  if (!factory) return factory.error();
  factory_ = factory->get();
  board_.emplace(config);
  factory_->events().listen([this](SimTime t, const Event& event) { board_->apply(t, event); });
  if (setup.log)
    factory_->on_warning([log = setup.log, &bus = setup.bus](const std::string& text) {
      log->line({bus.now(), cx::LogLevel::kWarn, "factory", text, {}});
    });
  servers.push_back(*std::move(factory));
  if (setup.network) {
    auto refbox = RefboxServer::make(config, *floor_, *factory_, setup);
    if (!refbox) return refbox.error();
    servers.insert(servers.begin(), *std::move(refbox));
  }
  referee = factory_;
  scenes.push_back(
      [scene = std::make_shared<GameScene>(*floor_, *factory_, *fleet_)](SceneList& list) { scene->list(list); });
  if (config.exploration && *named<Information>(config.information) == Information::kLeague)
    fleet_->ask_whether_known([this](sim::RobotId robot, sim::StationId station) { return is_known(robot, station); });
  return {};
}

Status GameStage::build_physics(const StageSetup& setup, sim::FloorPlan plan) {
  const Scenario& scenario = setup.scenario;
  auto options = model_options(scenario, setup.models);
  if (!options) return options.error();
  auto made = sim::MujocoWorld::create(std::move(plan), *options, &physics_log_);
  if (!made) return made.error();
  physics_ = made->get();
  floor_ = physics_;
  files = physics_->model_files();
  worlds.push_back(*std::move(made));
  views.push_back([this](int width, int height) {
    return view_of_physics(
        physics_->plan(), physics_->gate(), [this](SimTime t) { return board_->at(t); }, width, height);
  });
  return add_fleet(setup, sim::Fleet::create(*physics_, *physics_, zone_places(), setup.bus, setup.sink,
                                             {faults_of(scenario), scenario.seed}));
}

Status GameStage::build_ledger(const StageSetup& setup, sim::FloorPlan plan) {
  const Scenario& scenario = setup.scenario;
  auto made = std::make_unique<sim::LedgerWorld>(std::move(plan));
  sim::LedgerWorld& ledger = *made;
  floor_ = &ledger;
  worlds.push_back(std::move(made));
  views.push_back([this, &scenario, models = setup.models](int width, int height) -> Expected<std::unique_ptr<View>> {
    auto options = model_options(scenario, models);
    if (!options) return options.error();
    const auto seen = [&lister = scenes.front(), list = std::make_shared<SceneList>()](SimTime t) {
      list->update({&lister, 1});
      return list->at(t);
    };
    return view_of_scene(floor_->plan(), *options, seen, [this](SimTime t) { return board_->at(t); }, width, height);
  });
  return add_fleet(setup, sim::Fleet::create(ledger, ledger, timed_of(scenario), scenario.seed, zone_places(),
                                             setup.bus, setup.sink, {faults_of(scenario), scenario.seed}));
}

Status GameStage::add_fleet(const StageSetup& setup, Expected<std::unique_ptr<sim::Fleet>> fleet) {
  if (!fleet) return fleet.error();
  fleet_ = fleet->get();
  servers.push_back(*std::move(fleet));
  const WorldConfig& config = setup.scenario.world.get<WorldConfig>();
  if (!config.exploration) return {};
  return fleet_->watch(setup.bus, from_seconds(config.setup_s + Exploration::kLength));
}

/// As far as its team can know: a robot of the team has read a marker, the referee has told, or exploration is over.
bool GameStage::is_known(sim::RobotId robot, sim::StationId station) const {
  const sim::FloorPlan& plan = floor_->plan();
  const Team team = team_of(plan.robot(robot));
  const Exploration& exploration = factory_->referee().exploration();
  if (exploration.over(floor_->floor_time())) return true;
  if (team_of(plan.station(station)) == team && exploration.finding(station).complete()) return true;
  for (std::size_t i = 0; i < plan.robots.size(); ++i)
    if (team_of(plan.robots[i]) == team && fleet_->has_read(static_cast<sim::RobotId>(i), station)) return true;
  return false;
}

void GameStage::report(Result& result) const {
  if (result.wants("teams")) report_teams(*factory_, result);
  if (result.wants("orders") || result.wants("deliveries")) report_orders(*factory_, result);
  if (result.wants("robots")) report_robots(fleet_->stats(), factory_->maintenance().robots(), *floor_, result);
  if (physics_ && result.only.empty()) {
    result.steps = physics_->gate().steps();
    result.physics_hash = hash_text(physics_->physics_hash());
  }
}

Expected<std::unique_ptr<Stage>> make_stage(const StageSetup& setup) {
  auto stage = std::make_unique<GameStage>();
  if (Status s = stage->build(setup); !s) return s.error();
  return std::unique_ptr<Stage>(std::move(stage));
}

Expected<std::unique_ptr<WorldReplay>> replay(const ReplaySetup& setup) {
  const WorldConfig& config = setup.scenario.world.get<WorldConfig>();
  const auto game = game_of(setup.scenario);
  if (!game) return game.error();
  sim::FloorPlan plan = floor_plan_of(config, game->layout);
  auto options = model_options(setup.scenario, setup.models);
  if (!options) return options.error();
  auto physics = sim::PhysicsReplay::load(plan, *options, setup.log);
  if (!physics) return physics.error();
  return std::unique_ptr<WorldReplay>(std::make_unique<FloorReplay>(std::move(plan), setup, *std::move(physics)));
}

Expected<std::unique_ptr<RecordedWorld>> show(SceneSetup setup) {
  const auto game = game_of(setup.scenario);
  if (!game) return game.error();
  auto options = model_options(setup.scenario, setup.models);
  if (!options) return options.error();
  sim::FloorPlan plan = floor_plan_of(setup.scenario.world.get<WorldConfig>(), game->layout);
  return std::unique_ptr<RecordedWorld>(
      std::make_unique<SceneOfGame>(std::move(plan), *std::move(options), std::move(setup)));
}

constexpr const SectionKind* kReads[]{&kTimedSection, &kFaultsSection};
constexpr std::string_view kFiles[]{"game"};
constexpr Tier kTiers[]{Tier::kPhysics, Tier::kTimed};

}  // namespace

Expected<Game> game_of(const Scenario& scenario) {
  WorldConfig config = scenario.world.get<WorldConfig>();
  if (const auto file = scenario.world_files.find("game"); file != scenario.world_files.end())
    config.game = file->second.path.string();
  return game_of(config, scenario.seed);
}

constinit const WorldKind kWorld{
    .name = "rcll",
    .what = "a game of the Logistics League (docs/reference/rcll.md)",
    .settings = settings_of<WorldConfig>(),
    .reads = kReads,
    .files = kFiles,
    .games_key = kFiles[0],
    .set_defaults =
        [](Scenario& scenario) {
          const WorldConfig& config = scenario.world.get<WorldConfig>();
          const double overtimes = choices_of(named<Rules>(config.rules).value_or(Rules{})).sudden_death ? 2 : 1;
          double seconds = config.setup_s + config.production_s + overtimes * config.overtime_s + config.post_game_s;
          for (const PauseConfig& pause : config.pauses) seconds += pause.seconds;
          scenario.duration = from_seconds(seconds);
        },
    .tiers = kTiers,
    .make_stage = make_stage,
    .replay = replay,
    .show = show,
    .sections = kSections,
    .metrics = kMetrics,
    .questions = kQuestions,
    .happened = happened,
    .page = page_of,
};

}  // namespace cxlab::rcll
