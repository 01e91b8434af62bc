#include "sim/world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace cxlab::sim {
namespace {

template <class Id, class Items>
std::optional<Id> find_by_name(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].name == name) return static_cast<Id>(i);
  return std::nullopt;
}

}  // namespace

void Stack::mount(Part part, std::uint8_t colour) {
  if (part == Part::kCap) {
    cap = colour;
    return;
  }
  const auto free = std::ranges::find(rings, std::uint8_t{0});
  assert(free != rings.end() && "a piece has three rings at most");
  *free = colour;
}

double FloorPlan::clearance(const Vec2& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Station& station : stations) {
    constexpr double kReach = kMachine.half_depth + kMachine.half_width;  // more than to a corner
    if ((station.pose_in_world.position() - p).squaredNorm() > (nearest + kReach) * (nearest + kReach)) continue;
    const Vec3 local = inverse_transform(station.pose_in_world, {p.x(), p.y(), 0});
    nearest = std::min(nearest, std::hypot(std::max(0.0, std::abs(local.x()) - kMachine.half_depth),
                                           std::max(0.0, std::abs(local.y()) - kMachine.half_width)));
  }
  for (const Segment& wall : walls) nearest = std::min(nearest, distance(p, wall) - kWall.half_thickness);
  return nearest;
}

std::optional<SpotId> FloorPlan::find_spot(std::string_view name) const { return find_by_name<SpotId>(spots, name); }

std::optional<StationId> FloorPlan::find_station(std::string_view name) const {
  return find_by_name<StationId>(stations, name);
}

std::vector<Spot> spots_of(const Station& station, StationId id) {
  std::vector<Spot> spots;
  const auto add = [&](const char* suffix, SpotKind kind, double x, double y, double reach) {
    const Vec3 rest(x, y, kMachine.working_height);
    const double side = x > 0 ? 1 : -1, yaw = x > 0 ? std::numbers::pi : 0;
    const auto robot_at = [&](double distance) {
      return compose(station.pose_in_world, {side * (kMachine.half_depth + distance), y, yaw});
    };
    spots.push_back({station.name + suffix, id, kind, rest, transform(station.pose_in_world, rest),
                     robot_at(kStanding.align), robot_at(reach)});
  };
  if (station.has_belt) {
    add("-INPUT", SpotKind::kBeltInput, kMachine.belt_rest_x, kMachine.belt_y, kStanding.belt);
    if (station.kind != "DS")
      add("-OUTPUT", SpotKind::kBeltOutput, -kMachine.belt_rest_x, kMachine.belt_y, kStanding.belt);
  }
  if (station.kind == "CS") {
    const char* slots[] = {"-SHELF-LEFT", "-SHELF-MIDDLE", "-SHELF-RIGHT"};
    for (std::size_t i = 0; i < kMachine.shelf_y.size(); ++i)
      add(slots[i], SpotKind::kShelf, kMachine.shelf_x, kMachine.shelf_y[i], kStanding.shelf);
  }
  if (station.kind == "RS") add("-SLIDE", SpotKind::kSlide, kMachine.slide_rest_x, kMachine.slide_y, kStanding.belt);
  return spots;
}

Vec3 within_strokes(const Vec3& axes) {
  return axes.cwiseMax(Vec3(0, -kRobot.left_stroke, 0))
      .cwiseMin(Vec3(kRobot.forward_stroke, kRobot.left_stroke, kRobot.up_stroke));
}

std::string_view to_string(Holder holder) {
  constexpr std::string_view kNames[]{"dispenser", "gripper", "belt",    "slot", "slide",
                                      "floor",     "gate",    "storage", "crew"};
  return kNames[static_cast<std::size_t>(holder)];
}

std::optional<StationId> Piece::station(const FloorPlan& plan) const {
  if (holder_index < 0) return std::nullopt;
  if (holder == Holder::kBelt) return StationId{holder_index};
  if (holder == Holder::kSlot || holder == Holder::kSlide) return plan.spot(SpotId{holder_index}).station;
  return std::nullopt;
}

Pose3 WorldView::pose_in_holder(const Piece& piece) const {
  if (piece.holder == Holder::kGripper)
    return {inverse_transform(robot(RobotId{piece.holder_index}).pose_in_world, piece.position_in_world)};
  if (const auto station = piece.station(plan_))
    return {inverse_transform(plan_.station(*station).pose_in_world, piece.position_in_world)};
  return {piece.position_in_world};
}

const Piece* WorldView::find(PieceId id) const {
  const auto found = std::ranges::lower_bound(pieces_, id, {}, &Piece::id);
  return found != pieces_.end() && found->id == id ? &*found : nullptr;
}

Piece& WorldView::piece(PieceId id) {
  const Piece* found = find(id);
  assert(found && "the piece is in play");
  return pieces_[static_cast<std::size_t>(found - pieces_.data())];
}

Piece& WorldView::add_piece(const Stack& stack, const Source& from, const Vec3& position, Holder to, int to_index) {
  const PieceId id = from.stored ? *from.stored : PieceId{++last_id_};
  const Holder source = from.stored ? Holder::kStorage : Holder::kDispenser;
  assert(find(id) == nullptr && "the piece is out of play");
  Piece& piece = *pieces_.insert(std::ranges::lower_bound(pieces_, id, {}, &Piece::id),
                                 Piece{id, stack, source, static_cast<int>(from.station), position, {}});
  pass(piece, to, to_index);
  return piece;
}

void WorldView::pass(Piece& piece, Holder to, int to_index) {
  changes_.push_back({piece.id, piece.holder, to, piece.holder_index, to_index, piece.position_in_world, floor_time()});
  if (piece.holder == Holder::kGripper) piece.held_by = RobotId{piece.holder_index};
  piece.holder = to;
  piece.holder_index = to_index;
}

void WorldView::remove(PieceId id) {
  std::erase_if(pieces_, [id](const Piece& piece) { return piece.id == id; });
}

void World::take_off_field(RobotId id, const Pose2& to) {
  if (const auto held = robot(id).held) retire(*held, Holder::kCrew);
  off_field_[index_of(id)] = true;
  set_down(id, to);
}

void World::bring_back(RobotId id, const Pose2& to) {
  off_field_[index_of(id)] = false;
  set_down(id, to);
}

void WorldView::begin_changes() {
  changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(visible_changes_));
  visible_changes_ = 0;
}

}  // namespace cxlab::sim
