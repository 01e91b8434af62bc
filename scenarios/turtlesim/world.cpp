#include "scenarios/turtlesim/world.h"

#include <algorithm>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/journal/hash_text.h"
#include "scenarios/result.h"
#include "scenarios/turtlesim/node.h"
#include "sim/box2d/turtle_picture.h"

namespace cxlab::turtlesim {

namespace {

class CanvasView final : public View {
 public:
  CanvasView(const sim::TurtleWorld& world, int side) : world_(world), side_(side) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (camera != "canvas") return input_error("found no camera '" + std::string(camera) + "', expected: canvas");
    picture_ = sim::draw_turtles(world_, side_);
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {"canvas"}; }

 private:
  const sim::TurtleWorld& world_;
  int side_;
  sim::Picture picture_;
};

/// The canvas as the largest square in the picture.
Expected<std::unique_ptr<View>> view_of_canvas(const sim::TurtleWorld& world, int width, int height) {
  constexpr int kLeast = 16, kMost = 4096;
  if (std::min(width, height) < kLeast || std::max(width, height) > kMost)
    return usage_error("found a size of " + std::to_string(width) + " x " + std::to_string(height) +
                       ": expected 16 x 16 to 4096 x 4096");
  return std::unique_ptr<View>(std::make_unique<CanvasView>(world, std::min(width, height)));
}

class CanvasReplay final : public WorldReplay {
 public:
  CanvasReplay(const sim::TurtleWorldOptions& options, SimTime tick, const std::string& log)
      : turtles_(options, log), tick_(tick) {}
  Status advance_to(SimTime t) override { return turtles_.advance_to(tick_not_before(t, tick_)); }
  std::string hash() const override { return hash_text(turtles_.world().hash()); }
  Expected<std::unique_ptr<View>> view(int width, int height) const override {
    return view_of_canvas(turtles_.world(), width, height);
  }

 private:
  sim::TurtleReplay turtles_;
  SimTime tick_;
};

sim::TurtleWorldOptions world_options(const Config& config, SimTime step) {
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  const sim::Colour background{byte(config.background_r), byte(config.background_g), byte(config.background_b)};
  return {.step = step, .start = config.start, .background = background, .collisions = config.collisions};
}

/// Puts world and node on the stage.
Expected<const TurtlesimNode*> set_up(const Config& config, SimTime step, sim::TurtleLog* log, const StageSetup& setup,
                                      Stage& stage) {
  auto world = std::make_unique<sim::TurtleWorld>(world_options(config, step), log);
  auto node = TurtlesimNode::create(config, *world, setup.bus, setup.sink, setup.log);
  if (!node) return node.error();
  const TurtlesimNode* made = node->get();
  stage.views.push_back([made](int width, int height) { return view_of_canvas(made->world(), width, height); });
  stage.scenes.push_back([made](SceneList& list) { made->list(list); });
  stage.worlds.push_back(std::move(world));
  stage.servers.push_back(*std::move(node));
  return made;
}

Json turtle_json(const TurtleStory& t) {
  return {{"name", t.name},   {"alive", t.alive},     {"x", t.x},
          {"y", t.y},         {"theta", t.theta},     {"driven_m", t.driven_m},
          {"walls", t.walls}, {"touches", t.touches}, {"teleports", t.teleports}};
}

/// The world of a scenario of kind turtlesim: its writes are logged, its turtles are in the result.
class TurtleStage final : public Stage {
 public:
  Status build(const StageSetup& setup) {
    auto node = set_up(setup.scenario.world.get<Config>(), setup.scenario.physics_step, &writes_, setup, *this);
    if (!node) return node.error();
    node_ = *node;
    return {};
  }
  std::string take_inputs() override { return writes_.take(); }
  void report(Result& result) const override {
    Json turtles = Json::array();
    for (const TurtleStory& story : node_->stories()) turtles.push_back(turtle_json(story));
    result.set("turtles", json_text(turtles));
    result.steps = node_->world().steps();
    result.physics_hash = hash_text(node_->world().hash());
  }

 private:
  sim::TurtleLog writes_;
  const TurtlesimNode* node_ = nullptr;  // owned as server
};

Expected<std::unique_ptr<Stage>> make_stage(const StageSetup& setup) {
  auto stage = std::make_unique<TurtleStage>();
  if (Status s = stage->build(setup); !s) return s.error();
  return std::unique_ptr<Stage>(std::move(stage));
}

/// A canvas beside another world: on the stage, but neither logged nor in the result.
Status add_node(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  auto node = set_up(spec.get<Config>(), sim::TurtleWorldOptions().step, nullptr, setup, stage);
  return node ? Status() : Status(node.error());
}

Expected<std::unique_ptr<WorldReplay>> replay(const ReplaySetup& setup) {
  const Scenario& scenario = setup.scenario;
  return std::unique_ptr<WorldReplay>(std::make_unique<CanvasReplay>(
      world_options(scenario.world.get<Config>(), scenario.physics_step), scenario.tick, setup.log));
}

constexpr ResultSection kSections[]{{.key = "turtles", .what = "what each turtle did", .initial = "[]", .sample = [] {
                                       return json_text(Json::array({turtle_json({})}));
                                     }}};
constexpr Metric kMetrics[]{
    {.name = "walls",
     .what = "how often turtles came to a wall",
     .from = "turtles.*.walls",
     .more_is_better = false,
     .title = "walls"},
    {.name = "touches",
     .what = "how often turtles began to touch another",
     .from = "turtles.*.touches",
     .more_is_better = false,
     .title = "touches"},
    {.name = "driven_m",
     .what = "how far turtles drove, in all",
     .from = "turtles.*.driven_m",
     .unit = "m",
     .title = "driven"},
    {.name = "teleports", .what = "how often turtles were teleported", .from = "turtles.*.teleports"},
};

Expected<RunPage> page_of(const AskedRun&, const Result& result) {
  PageTable table{"Turtles", {"turtle", "x", "y", "driven", "walls", "touches", "teleports"}, {}};
  const Json all = parse_json(result.to_json());
  for (const Json& turtle : all["turtles"]) {
    const auto number = [&turtle](const char* key, int digits) {
      return fixed_text(turtle[key].get<double>(), digits);
    };
    table.rows.push_back({turtle["name"].get<std::string>() + (turtle["alive"].get<bool>() ? "" : " (killed)"),
                          number("x", 2), number("y", 2), number("driven_m", 1) + " m", number("walls", 0),
                          number("touches", 0), number("teleports", 0)});
  }
  RunPage page;
  if (!table.rows.empty()) page.parts.emplace_back(std::move(table));
  return page;
}

constexpr Tier kTiers[]{Tier::kPhysics};
constexpr std::string_view kName = "turtlesim", kWhat = "turtles on a canvas (docs/reference/turtlesim.md)";

}  // namespace

constinit const WorldKind kWorld{
    .name = kName,
    .what = kWhat,
    .settings = settings_of<Config>(),
    .tick = sim::TurtleWorldOptions().step,
    .physics_step = sim::TurtleWorldOptions().step,
    .tiers = kTiers,
    .any_tick = true,
    .make_stage = make_stage,
    .replay = replay,
    .sections = kSections,
    .metrics = kMetrics,
    .page = page_of,
};

constinit const NodeKind kNode{.name = kName, .what = kWhat, .settings = settings_of<Config>(), .add = add_node};

}  // namespace cxlab::turtlesim
