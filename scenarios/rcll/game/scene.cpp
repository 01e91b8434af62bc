#include "scenarios/rcll/game/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {
namespace {

using Shape = Solid::Shape;

// Numbers of entities. Those that move most are the shortest in the file.
constexpr std::uint32_t kNeverChanged = 1;  // a revision
constexpr double kFingertip = 0.002;        // m between a piece and the middle of a fingertip that holds it
constexpr EntityId kRobots = 1, kMachines = 32, kField = 64, kWalls = 65, kPieces = 100;
EntityId number(sim::RobotId id) { return kRobots + static_cast<EntityId>(id); }
EntityId number(sim::StationId id) { return kMachines + static_cast<EntityId>(id); }
EntityId number(sim::PieceId id) { return kPieces + static_cast<EntityId>(id); }

// Colours as in models/factory.xml.
constexpr std::uint32_t kGround = 0x9c9fa5, kWall = 0x8c9199, kBody = 0xcccfd4, kDark = 0x29292e, kLine = 0xf2f2f2;
constexpr std::uint32_t kTeamColours[]{0x00c7db, 0xe01a9e}, kInsertion[]{0x0d7380, 0x80145c};
constexpr std::uint32_t kBases[]{0, 0xd91414, 0x0f0f0f, 0xc7ccd4, 0xccebff};
constexpr std::uint32_t kRings[]{0, 0x1a40e6, 0x1aa633, 0xff800d, 0xfae61a};
constexpr std::uint32_t kCaps[]{0, 0x0a0a0a, 0x8c8f94};
constexpr std::uint32_t kRobotColours[2][3]{{0xfabf1a, 0x59d959, 0x668cff}, {0xff4dcc, 0xbf1a80, 0xffa6e6}};

std::uint32_t colour_of_kind(std::string_view kind) {
  if (kind == "BS") return 0x3352bf;
  if (kind == "CS") return 0xf28c1a;
  if (kind == "RS") return 0x409e47;
  if (kind == "SS") return 0x804da6;
  return 0x8c5933;
}

template <std::size_t n>
std::uint32_t colour(const std::uint32_t (&colours)[n], std::uint8_t which) {
  return colours[which < n ? which : 0];
}

std::array<double, 3> cylinder(double radius, double height) { return {2 * radius, 2 * radius, height}; }

std::string field_look(const sim::FloorPlan& plan) {
  const double length = plan.max_x - plan.min_x, width = plan.max_y - plan.min_y;
  std::vector<Solid> solids{{Shape::kBox, {length, width, 0.01}, {0, 0, -0.01}, kGround},
                            {Shape::kBox, {0.04, width, 0.001}, {}, kLine}};
  for (const Team team : kTeams)
    solids.push_back({Shape::kBox,
                      {3, 1, 0.001},
                      {(length / 2 - 1.5) * (team == Team::kCyan ? 1 : -1), 0.5 - width / 2, 0},
                      kInsertion[static_cast<std::size_t>(team)]});
  return look_of(solids);
}

std::string machine_look(const sim::Station& station, const sim::Lights& lights) {
  constexpr double kDepth = 2 * sim::kMachine.half_depth, kWidth = 2 * sim::kMachine.half_width, kHeight = 0.86;
  const std::uint32_t kind = colour_of_kind(station.kind);
  std::vector<Solid> solids{
      {Shape::kBox, {kDepth, kWidth, kHeight}, {}, kBody},
      {Shape::kBox,
       {kDepth + 0.004, kWidth + 0.004, 0.12},
       {0, 0, 0.71},
       kTeamColours[static_cast<std::size_t>(team_of(station))]},
      {Shape::kBox, {0.33, 0.26, 0.006}, {0, -0.205, kHeight}, kind},
      {Shape::kBox, {0.064, 0.13, 0.024}, {0, sim::kMachine.belt_y, 0.988}, kind},
  };
  if (station.has_belt)
    solids.push_back({Shape::kBox,
                      {2 * sim::kMachine.belt_half_length, 0.045, sim::kMachine.working_height - kHeight},
                      {0, sim::kMachine.belt_y, kHeight},
                      kDark});
  if (station.kind == "CS")
    solids.push_back({Shape::kBox, {0.12, 0.295, 0.01}, {sim::kMachine.shelf_x, 0.175, 0.888}, kind});
  if (station.kind == "RS")
    solids.push_back({Shape::kBox, {0.12, 0.08, 0.01}, {0.1, sim::kMachine.slide_y, 0.888}, kind});
  const auto light = [&](sim::Light on, double z, std::uint32_t lit, std::uint32_t dark) {
    solids.push_back({Shape::kCylinder,
                      cylinder(0.03, 0.04),
                      {-0.12, 0.3, z},
                      on == sim::Light::kOff ? dark : lit,
                      on == sim::Light::kBlink});
  };
  light(lights.green, 0.98, 0x0dd926, 0x0a3d11);
  light(lights.yellow, 1.02, 0xffcc00, 0x4d3d00);
  light(lights.red, 1.06, 0xff0d0d, 0x4d0a0a);
  return look_of(solids);
}

/// "PROCESSING yellow green", "BROKEN red-blink yellow-blink": the state, and the lights that are not off.
std::string machine_text(MachineState state, const sim::Lights& lights) {
  std::string text(to_string(state));
  const auto light = [&](sim::Light on, const char* name) {
    if (on == sim::Light::kOff) return;
    (text += ' ') += name;
    if (on == sim::Light::kBlink) text += "-blink";
  };
  light(lights.red, "red");
  light(lights.yellow, "yellow");
  light(lights.green, "green");
  return text;
}

/// The opposite of `machine_text`.
sim::Lights lights_in(const Entity& machine) {
  sim::Lights lights;
  std::istringstream words(machine.state);
  for (std::string word; words >> word;) {
    const std::size_t end = word.find("-blink");
    const sim::Light how = end == word.npos ? sim::Light::kOn : sim::Light::kBlink;
    const std::string_view colour = std::string_view(word).substr(0, end);
    if (colour == "red") lights.red = how;
    if (colour == "yellow") lights.yellow = how;
    if (colour == "green") lights.green = how;
  }
  return lights;
}

std::string robot_look(const sim::RobotStart& robot, std::size_t number_in_team) {
  const std::uint32_t colour = kRobotColours[static_cast<std::size_t>(team_of(robot))][number_in_team % 3];
  const Solid solids[]{{Shape::kCylinder, cylinder(sim::kRobot.hull_radius, 0.2), {0, 0, 0.03}, kDark},
                       {Shape::kCylinder, cylinder(sim::kRobot.hull_radius + 0.001, 0.05), {0, 0, 0.175}, colour},
                       {Shape::kBox, {0.18, 0.22, 0.52}, {-0.06, 0, 0.23}, kBody},
                       {Shape::kCylinder, cylinder(0.18, 0.02), {0, 0, 0.75}, kDark},
                       {Shape::kCylinder, cylinder(0.15, 0.024), {0, 0, 0.751}, colour},
                       {Shape::kBox, {0.06, 0.06, 0.06}, {0.205, 0, 0.1}, kLine}};
  return look_of(solids);
}

}  // namespace

std::string piece_look(const sim::Stack& stack) {
  std::vector<Solid> solids;
  double z = 0;
  const auto add = [&](double height, double radius, std::uint32_t colour) {
    solids.push_back({Shape::kCylinder, cylinder(radius, height), {0, 0, z}, colour});
    z += height;
  };
  if (stack.base) add(sim::kPiece.base_height, sim::kPiece.radius, colour(kBases, stack.base));
  for (const std::uint8_t ring : stack.rings)
    if (ring) add(sim::kPiece.ring_height, sim::kPiece.radius, colour(kRings, ring));
  if (stack.cap) add(sim::kPiece.cap_height, sim::kPiece.radius, colour(kCaps, stack.cap));
  return look_of(solids);
}

sim::FloorPose floor_pose_of(const Scene& scene, const sim::FloorPlan& plan) {
  sim::FloorPose out;
  for (const sim::RobotStart& robot : plan.robots) {
    sim::RobotState& state = out.robots.emplace_back();
    state.pose_in_world = robot.pose_in_world;
    state.finger_opening = sim::kRobot.fingers_open;
  }
  out.lights.resize(plan.stations.size());
  const auto robot_of = [&](const Entity& entity) -> sim::RobotState* {
    const auto at = std::ranges::find(plan.robots, entity.name, &sim::RobotStart::name);
    return at == plan.robots.end() ? nullptr : &out.robots[static_cast<std::size_t>(at - plan.robots.begin())];
  };
  for (const Entity& entity : scene.entities) {
    const sim::Pose3 pose = scene.in_world(entity);
    if (entity.kind == "robot") {
      if (sim::RobotState* robot = robot_of(entity))
        robot->pose_in_world = {pose.position.x(), pose.position.y(), pose.yaw()};
    } else if (entity.kind == "machine") {
      if (const auto station = plan.find_station(entity.name)) out.lights[sim::index_of(*station)] = lights_in(entity);
    } else if (entity.kind == "piece") {
      out.pieces.push_back({stack_of(entity.state), pose});
      const Entity* carrier = entity.carried_by && entity.place == "gripper" ? scene.find(*entity.carried_by) : nullptr;
      if (sim::RobotState* robot = carrier ? robot_of(*carrier) : nullptr) {
        const sim::Vec3& held = entity.pose.position;
        robot->gripper =
            sim::within_strokes({held.x() - sim::kRobot.home_forward, held.y(), held.z() - sim::kRobot.home_height});
        robot->finger_opening = sim::kPiece.radius + kFingertip;
      }
    }
  }
  return out;
}

GameScene::GameScene(const sim::World& floor, const Factory& factory, const sim::Fleet& fleet)
    : floor_(floor), factory_(factory), fleet_(fleet), machines_(floor.plan().stations.size()) {
  const sim::FloorPlan& plan = floor.plan();
  for (const sim::Segment& wall : plan.walls) {
    const double length = sim::distance(wall.a, wall.b) + 2 * sim::kWall.half_thickness;
    const Solid solid{Shape::kBox, {length, 2 * sim::kWall.half_thickness, 2 * sim::kWall.half_height}, {}, kWall};
    walls_.push_back(look_of({&solid, 1}));
  }
  std::size_t in_team[2]{};
  for (const sim::RobotStart& robot : plan.robots)
    robots_.push_back(robot_look(robot, in_team[static_cast<std::size_t>(team_of(robot))]++));
}

void GameScene::list(SceneList& list) {
  list_robots(list);
  list_machines(list);
  list_field(list);
  list_pieces(list);
}

void GameScene::list_field(SceneList& list) const {
  const sim::FloorPlan& plan = floor_.plan();
  static const std::string look = field_look(sim::FloorPlan());
  if (list.keep(kField, kNeverChanged, 1 + walls_.size())) return;
  list.put({.number = kField,
            .kind = "field",
            .name = "field",
            .look = look,
            .pose = {{(plan.min_x + plan.max_x) / 2, (plan.min_y + plan.max_y) / 2, 0}},
            .fixed = true,
            .revision = kNeverChanged});
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const sim::Vec2 &a = plan.walls[i].a, &b = plan.walls[i].b;
    list.put({.number = kWalls + static_cast<EntityId>(i),
              .kind = "wall",
              .name = "wall",
              .look = walls_[i],
              .pose = {{(a.x() + b.x()) / 2, (a.y() + b.y()) / 2, 0}, {0, 0, std::atan2(b.y() - a.y(), b.x() - a.x())}},
              .fixed = true,
              .revision = kNeverChanged});
  }
}

void GameScene::list_machines(SceneList& list) {
  const sim::FloorPlan& plan = floor_.plan();
  for (const auto& machine : factory_.machines()) {
    const sim::StationId id = machine->id();
    MachineText& known = machines_[sim::index_of(id)];
    const sim::Lights lights = floor_.lights(id);
    if (known.text.empty() || known.state != machine->state() || known.lights != lights) {
      known.state = machine->state();
      known.lights = lights;
      known.text = machine_text(machine->state(), lights);
      const auto [look, is_new] = known.looks.try_emplace({lights.red, lights.yellow, lights.green});
      if (is_new) look->second = machine_look(plan.station(id), lights);
      known.look = &look->second;
      ++known.revision;
    }
    if (list.keep(number(id), known.revision)) continue;
    list.put({.number = number(id),
              .kind = "machine",
              .name = machine->name(),
              .state = known.text,
              .look = *known.look,
              .pose = sim::pose_in_space(plan.station(id).pose_in_world),
              .fixed = true,
              .revision = known.revision});
  }
}

void GameScene::list_robots(SceneList& list) {
  const sim::FloorPlan& plan = floor_.plan();
  for (std::size_t i = 0; i < plan.robots.size(); ++i) {
    const auto id = static_cast<sim::RobotId>(i);
    EntityView robot{.number = number(id),
                     .kind = "robot",
                     .name = plan.robots[i].name,
                     .state = fleet_.doing(id),
                     .look = robots_[i],
                     .way_number = floor_.way_number(id)};
    if (robot.way_number == 0)
      robot.pose = sim::pose_in_space(floor_.robot(id).pose_in_world);
    else if (!list.knows_way(robot.number, robot.way_number))
      robot.way = way_ = floor_.way(id);
    list.put(robot);
  }
}

const GameScene::PieceText& GameScene::text_of(const sim::Piece& piece) {
  const std::size_t at = sim::index_of(piece.id);
  if (at >= pieces_.size()) pieces_.resize(at + 1);
  PieceText& known = pieces_[at];
  const sim::Piece& seen = known.piece;
  const std::uint64_t way = floor_.way_number(piece);
  const bool is_new = known.revision == 0, changed = is_new || seen.stack != piece.stack;
  if (!changed && seen.holder == piece.holder && seen.holder_index == piece.holder_index &&
      seen.position_in_world == piece.position_in_world && known.way == way)
    return known;
  if (is_new) known.name = "piece" + std::to_string(at);
  if (changed) {
    known.text = describe(piece.stack);
    known.look = piece_look(piece.stack);
  }
  known.piece = piece;
  known.way = way;
  ++known.revision;
  return known;
}

void GameScene::list_pieces(SceneList& list) {
  const sim::FloorPlan& plan = floor_.plan();
  for (const sim::Piece& piece : floor_.pieces()) {
    const PieceText& text = text_of(piece);
    // Where it is in a gripper hangs on the robot's pose, too.
    const bool held = piece.holder == sim::Holder::kGripper && piece.holder_index >= 0;
    if (!held && list.keep(number(piece.id), text.revision)) continue;
    EntityView view{.number = number(piece.id),
                    .kind = "piece",
                    .name = text.name,
                    .state = text.text,
                    .look = text.look,
                    .revision = text.revision,
                    .way_number = text.way};
    if (held) {
      view.carried_by = number(sim::RobotId{piece.holder_index});
      view.place = "gripper";
    } else if (const auto station = piece.station(plan)) {
      view.carried_by = number(*station);
      view.place = "belt";
      if (piece.holder != sim::Holder::kBelt) view.place = plan.spot(sim::SpotId{piece.holder_index}).name;
    }
    if (view.way_number == 0)
      view.pose = floor_.pose_in_holder(piece);
    else if (!list.knows_way(view.number, view.way_number))
      view.way = way_ = floor_.way(piece);
    list.put(view);
  }
}

}  // namespace cxlab::rcll
