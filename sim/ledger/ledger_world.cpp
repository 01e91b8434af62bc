#include "sim/ledger/ledger_world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace cxlab::sim {
namespace {

/// Underside of a held piece, in the robot's frame.
constexpr Vec3 kCarried{kRobot.home_forward, 0, kRobot.carried_height};

template <class Id>
int index_of(Id id) {
  return static_cast<int>(id);
}

}  // namespace

LedgerWorld::LedgerWorld(FloorPlan plan)
    : plan_(std::move(plan)),
      belts_(plan_.stations.size()),
      lights_(plan_.stations.size()),
      slide_counts_(plan_.stations.size(), 0),
      motions_(plan_.robots.size()) {
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    motions_[i].path = {plan_.robots[i].pose_in_world};
    motions_[i].reached = {0};
  }
}

Piece* LedgerWorld::find_piece(PieceId id) {
  const auto it = std::ranges::lower_bound(pieces_, id, {}, &Piece::id);
  return it != pieces_.end() && it->id == id ? &*it : nullptr;
}

const Piece* LedgerWorld::find(PieceId id) const { return const_cast<LedgerWorld*>(this)->find_piece(id); }

Piece* LedgerWorld::held_by(RobotId robot) {
  const auto it = std::ranges::find_if(
      pieces_, [&](const Piece& p) { return p.holder == Holder::kGripper && p.holder_index == index_of(robot); });
  return it != pieces_.end() ? &*it : nullptr;
}

Pose2 LedgerWorld::pose_at(RobotId robot, SimTime t) const {
  const Motion& motion = motions_[static_cast<std::size_t>(robot)];
  if (motion.path.size() == 1 || t >= motion.arrival) return motion.path.back();
  const double part = std::max(0.0, to_seconds(t - motion.departure) / to_seconds(motion.arrival - motion.departure));
  const double s = part * motion.reached.back();
  const auto next = std::ranges::upper_bound(motion.reached, s);
  if (next == motion.reached.end()) return motion.path.back();
  const auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, next - motion.reached.begin()));
  const double length = motion.reached[i] - motion.reached[i - 1];
  const double f = length > 0 ? (s - motion.reached[i - 1]) / length : 1;
  const Pose2& a = motion.path[i - 1];
  const Pose2& b = motion.path[i];
  const double turn = wrap_angle(motion.path.back().yaw - motion.path.front().yaw);
  return {a.x + f * (b.x - a.x), a.y + f * (b.y - a.y), wrap_angle(motion.path.front().yaw + part * turn)};
}

Vec3 LedgerWorld::gripper_in_world(RobotId robot) const { return transform(pose_at(robot, now_), kCarried); }

RobotState LedgerWorld::robot(RobotId id) const {
  const Motion& motion = motions_[static_cast<std::size_t>(id)];
  RobotState state;
  state.pose_in_world = pose_at(id, now_);
  if (motion.path.size() > 1 && now_ >= motion.departure && now_ < motion.arrival) {
    const SimTime step = std::min<SimTime>(SimTime{1'000'000}, motion.arrival - now_);
    const Pose2 next = pose_at(id, now_ + step);
    const double dt = to_seconds(step);
    state.vx = (next.x - state.pose_in_world.x) / dt;
    state.vy = (next.y - state.pose_in_world.y) / dt;
    state.omega = wrap_angle(next.yaw - state.pose_in_world.yaw) / dt;
  }
  if (const Piece* piece = held_by(id))
    state.held = piece->id;
  else
    state.finger_opening = kRobot.fingers_open;
  return state;
}

double LedgerWorld::x_on_belt(const Piece& piece) const {
  return inverse_transform(plan_.stations[static_cast<std::size_t>(piece.holder_index)].pose_in_world,
                           piece.position_in_world)
      .x;
}

const Piece* LedgerWorld::at(SpotId id) const {
  const Spot& spot = plan_.spot(id);
  switch (spot.kind) {
    case SpotKind::kBeltInput:
    case SpotKind::kBeltOutput: return on_belt(spot.station, spot.rest_in_station.x);
    case SpotKind::kShelf: {
      const auto it = std::ranges::find_if(
          pieces_, [&](const Piece& p) { return p.holder == Holder::kSlot && p.holder_index == index_of(id); });
      return it != pieces_.end() ? &*it : nullptr;
    }
    case SpotKind::kSlide: return nullptr;  // what is put there slides in at once
  }
  return nullptr;
}

const Piece* LedgerWorld::on_belt(StationId id, double x) const {
  const Piece* nearest = nullptr;
  double best = kSpotTolerance.along_belt;
  for (const Piece& piece : pieces_) {
    if (piece.holder != Holder::kBelt || piece.holder_index != index_of(id)) continue;
    const double distance = std::abs(x_on_belt(piece) - x);
    if (distance <= best) {
      best = distance;
      nearest = &piece;
    }
  }
  return nearest;
}

// --- Time

SimTime LedgerWorld::next_event() const {
  SimTime next = kNever;
  for (const Belt& b : belts_) next = std::min(next, b.arrival);
  return next;
}

Status LedgerWorld::advance(SimTime tick) {
  changes_ = std::exchange(booked_, {});
  const SimTime end = now_ + tick;
  for (;;) {
    const SimTime next = std::min(end, next_event());
    const SimTime step = std::max(SimTime{}, next - now_);
    for (std::size_t i = 0; i < belts_.size(); ++i) carry(static_cast<StationId>(i), step);
    now_ += step;
    carry_held_pieces();
    bool arrived = false;
    for (std::size_t i = 0; i < belts_.size(); ++i)
      if (belts_[i].arrival <= now_) {
        arrive(static_cast<StationId>(i));
        arrived = true;
      }
    if (!arrived && now_ >= end) return {};
  }
}

void LedgerWorld::carry(StationId id, SimTime duration) {
  const Belt& b = belt(id);
  if (b.speed == 0 || duration <= SimTime{}) return;
  const Pose2& frame = plan_.station(id).pose_in_world;
  for (Piece& piece : pieces_)
    if (piece.holder == Holder::kBelt && piece.holder_index == index_of(id))
      piece.position_in_world = transform(
          frame, {x_on_belt(piece) + b.speed * to_seconds(duration), kMachine.belt_y, kMachine.working_height});
}

void LedgerWorld::carry_held_pieces() {
  for (Piece& piece : pieces_)
    if (piece.holder == Holder::kGripper)
      piece.position_in_world = gripper_in_world(static_cast<RobotId>(piece.holder_index));
}

/// When the first piece comes to the place where the belt stops, or falls over the belt's end.
void LedgerWorld::plan_arrival(StationId id) {
  Belt& b = belt(id);
  b.arrival = kNever;
  if (b.speed == 0) return;
  const double forward = b.speed > 0 ? 1 : -1;
  double way = std::numeric_limits<double>::infinity();
  for (const Piece& piece : pieces_) {
    if (piece.holder != Holder::kBelt || piece.holder_index != index_of(id)) continue;
    const double x = x_on_belt(piece) * forward;
    const double to_stop = b.stop_x * forward - x;
    const bool stops = to_stop >= -kSpotTolerance.along_belt && b.stop_x * forward <= kMachine.belt_half_length;
    way = std::min(way, std::max(0.0, stops ? to_stop : kMachine.belt_half_length - x));
  }
  if (std::isfinite(way)) b.arrival = now_ + from_seconds(way / std::abs(b.speed));
}

void LedgerWorld::arrive(StationId id) {
  Belt& b = belt(id);
  const double forward = b.speed > 0 ? 1 : -1;
  constexpr double kSame = 1e-6;  // m: rounding of times to ns
  bool stops = false;
  for (Piece& piece : pieces_) {
    if (piece.holder != Holder::kBelt || piece.holder_index != index_of(id)) continue;
    const double x = x_on_belt(piece);
    if (std::abs(x - b.stop_x) <= kSame ||
        ((x - b.stop_x) * forward > 0 && (x - b.stop_x) * forward <= kSpotTolerance.along_belt)) {
      stops = true;
    } else if (x * forward >= kMachine.belt_half_length - kSame) {
      const Vec3 below{piece.position_in_world.x, piece.position_in_world.y, 0};
      pass(piece, Holder::kFloor, -1, below, changes_);
    }
  }
  if (stops) b.speed = 0;
  plan_arrival(id);
}

// --- Machines

Expected<PieceId> LedgerWorld::add(const Stack& stack, Holder holder, int index, const Vec3& position, int from_index) {
  const PieceId id{++last_id_};
  pieces_.push_back({id, stack, Holder::kDispenser, from_index, position});
  pass(pieces_.back(), holder, index, position, booked_);
  return id;
}

Expected<PieceId> LedgerWorld::dispense(StationId station, double x, const Stack& stack) {
  const Station& where = plan_.station(station);
  for (const Piece& piece : pieces_)
    if (piece.holder == Holder::kBelt && piece.holder_index == index_of(station) &&
        std::abs(x_on_belt(piece) - x) < 2 * kPiece.radius)
      return negative(where.name + ": a piece lies where one should be dispensed").with_code("place_taken");
  const Vec3 position = transform(where.pose_in_world, {x, kMachine.belt_y, kMachine.working_height});
  auto id = add(stack, Holder::kBelt, index_of(station), position, index_of(station));
  plan_arrival(station);
  return id;
}

Expected<PieceId> LedgerWorld::dispense(SpotId shelf, const Stack& stack) {
  const Spot& spot = plan_.spot(shelf);
  if (at(shelf)) return negative(spot.name + ": a piece lies where one should be dispensed").with_code("place_taken");
  const Vec3 position = transform(plan_.station(spot.station).pose_in_world, spot.rest_in_station);
  return add(stack, Holder::kSlot, index_of(shelf), position, index_of(spot.station));
}

void LedgerWorld::run_belt(StationId station, double speed, double stop_x) {
  belt(station) = {speed, stop_x, kNever};
  plan_arrival(station);
}

void LedgerWorld::stop_belt(StationId station) { belt(station) = {}; }

void LedgerWorld::mount(PieceId id, Part part, std::uint8_t colour) {
  Piece* piece = find_piece(id);
  assert(piece && "a part is mounted on a piece in play");
  if (part == Part::kCap) {
    piece->stack.cap = colour;
    return;
  }
  const auto free = std::ranges::find(piece->stack.rings, std::uint8_t{0});
  assert(free != piece->stack.rings.end() && "a piece has three rings at most");
  *free = colour;
}

void LedgerWorld::unmount_cap(PieceId id) {
  Piece* piece = find_piece(id);
  assert(piece && "a cap is taken off a piece in play");
  piece->stack.cap = 0;
}

void LedgerWorld::retire(PieceId id, Holder to) {
  Piece* piece = find_piece(id);
  assert(piece && "a piece in play is retired");
  const int station = piece->holder == Holder::kBelt ? piece->holder_index : -1;
  pass(*piece, to, station, piece->position_in_world, booked_);
  remove(id);
  if (station >= 0) plan_arrival(static_cast<StationId>(station));
}

void LedgerWorld::set_lights(StationId station, const Lights& lights) {
  lights_[static_cast<std::size_t>(station)] = lights;
}

void LedgerWorld::pass(Piece& piece, Holder to, int index, const Vec3& position, std::vector<HolderChange>& changes) {
  changes.push_back({piece.id, piece.holder, to, piece.holder_index, index, position, now_});
  piece.holder = to;
  piece.holder_index = index;
  piece.position_in_world = position;
}

void LedgerWorld::remove(PieceId id) {
  std::erase_if(pieces_, [&](const Piece& p) { return p.id == id; });
}

// --- Robots

void LedgerWorld::move_along(RobotId robot, std::span<const Pose2> path, SimTime departure, SimTime arrival) {
  assert(!path.empty() && departure <= arrival);
  Motion& motion = motions_[static_cast<std::size_t>(robot)];
  motion.path.assign(path.begin(), path.end());
  motion.reached.assign(1, 0);
  for (std::size_t i = 1; i < path.size(); ++i)
    motion.reached.push_back(motion.reached.back() + std::hypot(path[i].x - path[i - 1].x, path[i].y - path[i - 1].y));
  motion.departure = departure;
  motion.arrival = arrival;
}

void LedgerWorld::stop(RobotId robot) {
  const Pose2 here = pose_at(robot, now_);
  motions_[static_cast<std::size_t>(robot)] = {{here}, {0}, now_, now_};
}

Status LedgerWorld::grasp(RobotId robot, SpotId from) {
  const Spot& spot = plan_.spot(from);
  const std::string& name = plan_.robots[static_cast<std::size_t>(robot)].name;
  if (held_by(robot)) return negative(name + " holds a piece already").with_code("gripper_full");
  const Piece* there = at(from);
  if (!there) return negative(spot.name + ": no piece to grasp").with_code("no_piece");
  pass(*find_piece(there->id), Holder::kGripper, index_of(robot), gripper_in_world(robot), booked_);
  if (spot.kind != SpotKind::kShelf) plan_arrival(spot.station);
  return {};
}

Status LedgerWorld::release(RobotId robot, SpotId to) {
  const Spot& spot = plan_.spot(to);
  Piece* piece = held_by(robot);
  if (!piece) {
    const std::string& name = plan_.robots[static_cast<std::size_t>(robot)].name;
    return negative(name + " holds nothing").with_code("gripper_empty");
  }
  if (at(to)) return negative(spot.name + ": a piece lies there already").with_code("place_taken");
  const Vec3 rest = transform(plan_.station(spot.station).pose_in_world, spot.rest_in_station);
  switch (spot.kind) {
    case SpotKind::kBeltInput:
    case SpotKind::kBeltOutput:
      pass(*piece, Holder::kBelt, index_of(spot.station), rest, booked_);
      plan_arrival(spot.station);
      break;
    case SpotKind::kShelf: pass(*piece, Holder::kSlot, index_of(to), rest, booked_); break;
    case SpotKind::kSlide:
      pass(*piece, Holder::kSlide, index_of(spot.station), rest, booked_);
      ++slide_counts_[static_cast<std::size_t>(spot.station)];
      remove(piece->id);
      break;
  }
  return {};
}

void LedgerWorld::drop(RobotId robot) {
  Piece* piece = held_by(robot);
  if (!piece) return;
  const Vec3 at = gripper_in_world(robot);
  pass(*piece, Holder::kFloor, -1, {at.x, at.y, 0}, booked_);
}

}  // namespace cxlab::sim
