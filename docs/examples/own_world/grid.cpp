#include "grid.h"

#include <cx/base/random.h>
#include <scenarios/result.h>

#include <algorithm>
#include <array>
#include <deque>

namespace grid {
namespace {

using namespace cxlab;

struct Cell {
  int row = 0, column = 0;
  bool operator==(const Cell&) const = default;
};

struct Config {
  std::vector<std::string> map{"SG"};  ///< a text a row, a character a cell: # wall, G goal, S start, . free
  double step_s = 0.5;                 ///< how long a step takes

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("map", map);
    keys("step_s", step_s);
  }
  int rows() const { return static_cast<int>(map.size()); }
  int columns() const { return static_cast<int>(map.front().size()); }
  /// Around the map are walls.
  char at(Cell cell) const {
    if (cell.row < 0 || cell.row >= rows() || cell.column < 0 || cell.column >= columns()) return '#';
    return map[static_cast<std::size_t>(cell.row)][static_cast<std::size_t>(cell.column)];
  }
  std::vector<Cell> cells(char kind) const {
    std::vector<Cell> out;
    for (Cell cell; cell.row < rows(); ++cell.row)
      for (cell.column = 0; cell.column < columns(); ++cell.column)
        if (at(cell) == kind) out.push_back(cell);
    return out;
  }
};

Status validate(const Config& config) {
  for (std::size_t row = 0; row < config.map.size(); ++row) {
    const std::string& cells = config.map[row];
    const std::string here = "map[" + std::to_string(row) + "]: ";
    if (cells.empty() || cells.size() != config.map.front().size())
      return input_error(here +
                         found_expected(std::to_string(cells.size()) + " cells",
                                        row == 0 ? "some" : std::to_string(config.columns()) + " as in the first row"));
    if (const std::size_t wrong = cells.find_first_not_of("#.SG"); wrong != std::string::npos)
      return input_error(here + found_text(cells.substr(wrong, 1), "# (wall), . (free), S (start) or G (goal)"));
  }
  if (config.map.empty()) return input_error("map: expected at least one row");
  const auto goals = config.cells('G').size(), starts = config.cells('S').size();
  if (goals != 1) return input_error("map: " + found_expected(std::to_string(goals) + " goals (G)", "one"));
  if (starts > 1) return input_error("map: " + found_expected(std::to_string(starts) + " starts (S)", "at most one"));
  if (starts + config.cells('.').size() == 0) return input_error("map: expected a cell to start from, S or .");
  return config.step_s > 0 ? Status() : Status(input_error("step_s: expected more than 0"));
}

struct Direction {
  std::string_view name;
  int rows, columns;
};
constexpr std::array kDirections{Direction{"north", -1, 0}, Direction{"east", 0, 1}, Direction{"south", 1, 0},
                                 Direction{"west", 0, -1}, Direction{"stay", 0, 0}};

/// Serves /grid/move, and is the referee: the game is over at the goal.
class Robot final : public Server, public Referee {
 public:
  static Expected<std::unique_ptr<Robot>> make(const StageSetup& setup) {
    const auto type = setup.bus.registry().service("grid/srv/Move");
    if (!type) return type.error();
    std::unique_ptr<Robot> robot(new Robot(setup, *(*type)->response));
    const auto served = setup.bus.serve(robot->self_, "/grid/move", **type,
                                        [to = robot.get()](const bus::Delivery& d) { to->requests_.push_back(d); });
    if (!served) return served.error();
    return robot;
  }

  /// Takes requests; the first of them begins.
  Status act(SimTime now) override {
    if (requests_.empty()) begun_ = now;
    bus_.deliver(self_);
    return {};
  }
  /// A step is done: answers its request, and begins the next.
  Status sense(SimTime now) override {
    if (now < next_due()) return {};
    const bus::Delivery& request = requests_.front();
    const std::string& wanted = request.message->view().text("direction");
    bus::Message answer(response_);
    if (const auto found = std::ranges::find(kDirections, wanted, &Direction::name); found != kDirections.end()) {
      const bool moved = move(*found);
      answer->set("moved", moved);
      data_.begin().field("event", moved ? "step" : "bump").field("to", wanted).field("begin_s", to_seconds(begun_));
      sink_.write(stream_, now, RecordKind::kReferee, data_);
    } else {
      answer->set("error", "direction: " + found_text(wanted, "north, east, south, west or stay"));
    }
    answer->set("row", at_.row).set("column", at_.column).set("at_goal", over());
    bus_.respond(request.endpoint, request, std::make_shared<const bus::Message>(std::move(answer)));
    requests_.pop_front();
    begun_ = now;
    return {};
  }
  Status judge(SimTime) override { return {}; }
  SimTime next_due() const override { return requests_.empty() ? kNever : begun_ + from_seconds(config_.step_s); }
  bool over() const override { return config_.at(at_) == 'G'; }

  const Config& config() const { return config_; }
  const std::vector<Cell>& way() const { return way_; }
  int bumps() const { return bumps_; }

 private:
  Robot(const StageSetup& setup, const bus::MessageType& response)
      : config_(setup.scenario.world.get<Config>()), bus_(setup.bus), sink_(setup.sink), response_(response) {
    auto starts = config_.cells('S');
    if (starts.empty()) starts = config_.cells('.');
    at_ = starts[RandomStream(setup.scenario.seed, "grid/start").below(starts.size())];
    way_ = {at_};
    stream_ = sink_.open_stream("node/grid");
    self_ = bus_.join(bus::ParticipantKind::kNode, {"grid", "/", {}}, stream_);
  }
  bool move(const Direction& direction) {
    const Cell to{at_.row + direction.rows, at_.column + direction.columns};
    if (config_.at(to) == '#') return ++bumps_, false;
    if (to != at_) way_.push_back(at_ = to);
    return true;
  }

  Config config_;
  bus::Bus& bus_;
  RecordSink& sink_;
  const bus::MessageType& response_;
  StreamId stream_{};
  RecordData data_;
  bus::ParticipantId self_{};
  std::deque<bus::Delivery> requests_;  ///< the first is carried out
  SimTime begun_{};                     ///< when the first began
  Cell at_;
  std::vector<Cell> way_;  ///< all cells since the start
  int bumps_ = 0;
};

class GridView final : public View {
 public:
  GridView(const Robot& robot, int width, int height)
      : robot_(robot), side_(std::max(1, std::min(width / robot.config().columns(), height / robot.config().rows()))) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (camera != "grid") return input_error("camera: " + found_text(camera, "grid"));
    picture_ = {robot_.config().columns() * side_, robot_.config().rows() * side_, {}};
    for (int y = 0; y < picture_.height; ++y)
      for (int x = 0; x < picture_.width; ++x)
        std::ranges::copy(colour_of({y / side_, x / side_}), std::back_inserter(picture_.rgb));
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {"grid"}; }

 private:
  std::array<std::uint8_t, 3> colour_of(Cell cell) const {
    if (cell == robot_.way().back()) return {200, 60, 40};
    if (robot_.config().at(cell) == 'G') return {60, 160, 80};
    if (robot_.config().at(cell) == '#') return {70, 70, 80};
    if (std::ranges::count(robot_.way(), cell) > 0) return {250, 215, 160};
    return {240, 240, 235};
  }
  const Robot& robot_;
  int side_;  ///< of a cell, in pixels
  sim::Picture picture_;
};

/// Each step and each bump costs a point.
std::string section_of(int steps, int bumps, bool reached) {
  return R"({"steps": )" + std::to_string(steps) + R"(, "bumps": )" + std::to_string(bumps) + R"(, "reached": )" +
         (reached ? "true" : "false") + R"(, "points": )" + std::to_string(-steps - bumps) + '}';
}

/// What a run adds to result.json, and what `bench` compares: points first.
constexpr ResultSection kSections[]{
    {.key = "grid", .what = "how the robot came to the goal", .initial = "{}", .sample = [] {
       return section_of(0, 0, false);
     }}};
constexpr Metric kMetrics[]{
    {.name = "points", .what = "what steps and bumps cost", .from = "grid.points", .title = "points"},
    {.name = "reached",
     .what = "whether the robot found the goal",
     .from = "grid.reached",
     .title = "reached",
     .digits = 2},
    {.name = "steps", .what = "steps to another cell", .from = "grid.steps", .more_is_better = false, .title = "steps"},
    {.name = "bumps", .what = "steps into a wall", .from = "grid.bumps", .more_is_better = false, .title = "bumps"},
};

/// The page of a run: a lane with the steps and bumps of the robot, beside the scene.
Expected<RunPage> page_of(const AskedRun& run, const Result& result) {
  PageLane lane{"robot", {}, {}};
  for (const JournalRecord& record : run.records)
    if (const std::string event(record.data.text("event")); record.stream == "node/grid")
      lane.bars.push_back({PageBar::Shape::kBar, event, record.data.real("begin_s"), to_seconds(record.t),
                           event + ' ' + std::string(record.data.text("to"))});
  RunPage page;
  page.kinds = {{.name = "step", .fill = "#56b4e9", .ink = ""},
                {.name = "bump", .fill = "#d55e00", .ink = "", .hatched = true}};
  page.parts.emplace_back(
      PageTable{"The way to the goal", {"steps", "bumps"}, {{result.at("grid.steps"), result.at("grid.bumps")}}});
  page.parts.emplace_back(
      PageLanes{"What the robot did", {{"step", "steps"}, {"bump", "bumps into a wall"}}, {std::move(lane)}});
  return page;
}

class GridStage final : public Stage {
 public:
  explicit GridStage(std::unique_ptr<Robot> robot) : robot_(*robot) {
    referee = robot.get();
    servers.push_back(std::move(robot));
    views.push_back([this](int width, int height) -> Expected<std::unique_ptr<View>> {
      return std::unique_ptr<View>(std::make_unique<GridView>(robot_, width, height));
    });
    scenes.push_back([this](SceneList& list) { list_entities(list); });
  }
  void report(Result& result) const override {
    const int steps = static_cast<int>(robot_.way().size()) - 1;
    result.set("grid", section_of(steps, robot_.bumps(), robot_.over()));
    result.score_board += (robot_.over() ? "at the goal after " : "not at the goal after ") + std::to_string(steps) +
                          " steps and " + std::to_string(robot_.bumps()) + " bumps\n";
  }

 private:
  /// A cell is a square metre; the first row of the map lies at the top.
  void list_entities(SceneList& list) const {
    const Config& config = robot_.config();
    EntityId number = 0;
    const auto put = [&](const char* kind, Cell cell, const Solid& solid, const std::string& state = {}) {
      const std::string look = look_of({&solid, 1});
      list.put({.number = ++number,
                .kind = kind,
                .name = kind,
                .state = state,
                .look = look,
                .pose = {{cell.column + 0.5, config.rows() - cell.row - 0.5, 0}}});
    };
    put("robot", robot_.way().back(), {Solid::Shape::kCylinder, {0.5, 0.5, 0.5}, {0, 0, 0}, 0xc83c28},
        "bumps " + std::to_string(robot_.bumps()));
    for (const Cell cell : config.cells('G'))
      put("goal", cell, {Solid::Shape::kBox, {1, 1, 0.02}, {0, 0, 0}, 0x3ca050});
    for (const Cell cell : config.cells('#')) put("wall", cell, {Solid::Shape::kBox, {1, 1, 0.8}, {0, 0, 0}, 0x464650});
  }

  const Robot& robot_;
};

}  // namespace

constinit const WorldKind kWorld{
    .name = "grid",
    .what = "a robot that looks for the goal in a grid",
    .settings = settings_of<Config>(),
    .duration = std::chrono::seconds(300),
    .make_stage = [](const StageSetup& setup) -> Expected<std::unique_ptr<Stage>> {
      auto robot = Robot::make(setup);
      if (!robot) return robot.error();
      return std::unique_ptr<Stage>(std::make_unique<GridStage>(*std::move(robot)));
    },
    .sections = kSections,
    .metrics = kMetrics,
    .page = page_of,
};

}  // namespace grid
