#include "sim/ledger/ledger_world.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace cxlab::sim {

LedgerWorld::LedgerWorld(FloorPlan plan)
    : World(std::move(plan)), belts_(plan_.stations.size()), lights_(plan_.stations.size()) {
  for (const RobotStart& robot : plan_.robots) motions_.push_back({{robot.pose_in_world}, {0}, {}, {}, 0});
}

// --- What one can see

const Piece* LedgerWorld::held_by(RobotId robot) const {
  const auto it = std::ranges::find_if(pieces_, [&](const Piece& p) { return p.is_with(Holder::kGripper, robot); });
  return it != pieces_.end() ? &*it : nullptr;
}

Pose2 LedgerWorld::pose_at(RobotId robot, SimTime t) const {
  const Motion& motion = motions_[index_of(robot)];
  if (motion.path.size() == 1 || t >= motion.arrival) return motion.path.back();
  const double part = std::max(0.0, to_seconds(t - motion.departure) / to_seconds(motion.arrival - motion.departure));
  const double s = part * motion.reached.back();
  const auto next = std::ranges::upper_bound(motion.reached, s);
  if (next == motion.reached.end()) return motion.path.back();
  const auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, next - motion.reached.begin()));
  const double length = motion.reached[i] - motion.reached[i - 1];
  const double f = length > 0 ? (s - motion.reached[i - 1]) / length : 1;
  const Vec2 at = between(motion.path[i - 1].position(), motion.path[i].position(), f);
  const double turn = wrap_angle(motion.path.back().yaw - motion.path.front().yaw);
  return {at.x(), at.y(), wrap_angle(motion.path.front().yaw + part * turn)};
}

Vec3 LedgerWorld::gripper_in_world(RobotId robot) const {
  return transform(pose_at(robot, floor_time()), {kRobot.home_forward, 0, kRobot.carried_height});
}

RobotState LedgerWorld::robot(RobotId id) const {
  const Motion& motion = motions_[index_of(id)];
  const SimTime time = floor_time();
  RobotState state;
  state.pose_in_world = pose_at(id, time);
  if (!halted() && motion.path.size() > 1 && time >= motion.departure && time < motion.arrival) {
    const SimTime step = std::min<SimTime>(SimTime{1'000'000}, motion.arrival - time);
    const Pose2 next = pose_at(id, time + step);
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
  const StationId station{piece.holder_index};
  return inverse_transform(plan_.station(station).pose_in_world, piece.position_in_world).x();
}

const Piece* LedgerWorld::at(SpotId id) const {
  const Spot& spot = plan_.spot(id);
  switch (spot.kind) {
    case SpotKind::kBeltInput:
    case SpotKind::kBeltOutput: return on_belt(spot.station, spot.rest_in_station.x());
    case SpotKind::kShelf: {
      const auto it = std::ranges::find_if(pieces_, [&](const Piece& p) { return p.is_with(Holder::kSlot, id); });
      return it != pieces_.end() ? &*it : nullptr;
    }
    case SpotKind::kSlide: return nullptr;  // a piece that is put there slides in at once
  }
  return nullptr;
}

const Piece* LedgerWorld::on_belt(StationId id, double x) const {
  const Piece* nearest = nullptr;
  double best = kSpotTolerance.along_belt;
  for (const Piece& piece : pieces_) {
    if (!piece.is_with(Holder::kBelt, id)) continue;
    const double distance = std::abs(x_on_belt(piece) - x);
    if (distance <= best) {
      best = distance;
      nearest = &piece;
    }
  }
  return nearest;
}

Pose3 LedgerWorld::pose_in_holder(const Piece& piece) const {
  switch (piece.holder) {
    case Holder::kGripper: return {{kRobot.home_forward, 0, kRobot.carried_height}};
    case Holder::kBelt: return {{x_on_belt(piece), kMachine.belt_y, kMachine.working_height}};
    case Holder::kSlot: return {plan_.spot(SpotId{piece.holder_index}).rest_in_station};
    default: return WorldView::pose_in_holder(piece);
  }
}

std::uint64_t LedgerWorld::way_number(RobotId id) const { return halted() ? 0 : motions_[index_of(id)].way; }

std::uint64_t LedgerWorld::way_number(const Piece& piece) const {
  return halted() || piece.holder != Holder::kBelt ? 0 : belts_[static_cast<std::size_t>(piece.holder_index)].way;
}

std::vector<WayPoint> LedgerWorld::way(RobotId id) const {
  const Motion& motion = motions_[index_of(id)];
  const SimTime now = floor_time();
  const double turn = wrap_angle(motion.path.back().yaw - motion.path.front().yaw);
  std::vector<WayPoint> points;
  if (now > motion.departure) points.push_back({now_, pose_in_space(pose_at(id, now))});
  for (std::size_t i = 0; i < motion.path.size(); ++i) {
    const double part = motion.reached[i] / motion.reached.back();
    const SimTime t = motion.departure + from_seconds(part * to_seconds(motion.arrival - motion.departure));
    const Pose2& at = motion.path[i];
    if (t >= now)
      points.push_back(
          {clock_.when(t), pose_in_space({at.x, at.y, wrap_angle(motion.path.front().yaw + part * turn)})});
  }
  return points;
}

std::vector<WayPoint> LedgerWorld::way(const Piece& piece) const {
  const Belt& belt = belts_[static_cast<std::size_t>(piece.holder_index)];
  const Pose3 now = pose_in_holder(piece);
  Pose3 then = now;
  then.position.x() += belt.speed * to_seconds(belt.arrival - floor_time());
  return {{now_, now}, {clock_.when(belt.arrival), then}};
}

// --- Time

SimTime LedgerWorld::next_event() const {
  return belts_.empty() ? kNever : clock_.when(std::ranges::min(belts_, {}, &Belt::arrival).arrival);
}

Status LedgerWorld::advance(SimTime tick) {
  begin_changes();
  const SimTime end = now_ + tick;
  for (bool arrived = true; arrived || now_ < end;) {
    const SimTime step = std::max(SimTime{}, std::min(end, next_event()) - now_);
    if (!halted())
      for (std::size_t i = 0; i < belts_.size(); ++i) carry(static_cast<StationId>(i), step);
    now_ += step;
    carry_held_pieces();
    arrived = false;
    for (std::size_t i = 0; i < belts_.size(); ++i)
      if (belts_[i].arrival <= floor_time()) {
        arrive(static_cast<StationId>(i));
        arrived = true;
      }
  }
  end_changes();
  return {};
}

void LedgerWorld::carry(StationId id, SimTime duration) {
  const double way = belts_[index_of(id)].speed * to_seconds(duration);
  if (way == 0) return;
  for (Piece& piece : pieces_)
    if (piece.is_with(Holder::kBelt, id))
      piece.position_in_world = transform(plan_.station(id).pose_in_world,
                                          {x_on_belt(piece) + way, kMachine.belt_y, kMachine.working_height});
}

void LedgerWorld::carry_held_pieces() {
  for (Piece& piece : pieces_)
    if (piece.holder == Holder::kGripper)
      piece.position_in_world = gripper_in_world(static_cast<RobotId>(piece.holder_index));
}

/// When the first piece comes to the place where the belt stops, or to the belt's end.
void LedgerWorld::plan_arrival(StationId id) {
  Belt& belt = belts_[index_of(id)];
  belt.arrival = kNever;
  belt.way = 0;
  if (belt.speed == 0) return;
  const double forward = belt.speed > 0 ? 1 : -1;
  double way = std::numeric_limits<double>::infinity();
  for (const Piece& piece : pieces_) {
    if (!piece.is_with(Holder::kBelt, id)) continue;
    const double x = x_on_belt(piece) * forward;
    const double to_stop = belt.stop_x * forward - x;
    const bool stops = to_stop >= -kSpotTolerance.along_belt && belt.stop_x * forward <= kMachine.belt_half_length;
    way = std::min(way, std::max(0.0, stops ? to_stop : kMachine.belt_half_length - x));
  }
  if (!std::isfinite(way)) return;
  belt.arrival = floor_time() + from_seconds(way / std::abs(belt.speed));
  belt.way = ++ways_;
}

void LedgerWorld::arrive(StationId id) {
  Belt& belt = belts_[index_of(id)];
  const double forward = belt.speed > 0 ? 1 : -1;
  constexpr double kSame = 1e-6;  // m: rounding of times to ns
  bool stops = false;
  for (Piece& piece : pieces_) {
    if (!piece.is_with(Holder::kBelt, id)) continue;
    const double x = x_on_belt(piece), beyond = (x - belt.stop_x) * forward;
    if (beyond >= -kSame && beyond <= kSpotTolerance.along_belt) {
      stops = true;
    } else if (x * forward >= kMachine.belt_half_length - kSame) {
      put(piece, Holder::kFloor, -1, {piece.position_in_world.x(), piece.position_in_world.y(), 0});
    }
  }
  if (stops) belt.speed = 0;
  plan_arrival(id);
}

/// The rest of each way happens later than planned, so each way gets a new number.
void LedgerWorld::go_on() {
  World::go_on();
  for (Belt& belt : belts_)
    if (belt.way != 0) belt.way = ++ways_;
  for (Motion& motion : motions_)
    if (motion.way != 0) motion.way = ++ways_;
}

// --- Machines

Expected<PieceId> LedgerWorld::bring_out(const Source& from, double x, const Stack& stack) {
  const Station& where = plan_.station(from.station);
  for (const Piece& piece : pieces_)
    if (piece.is_with(Holder::kBelt, from.station) && std::abs(x_on_belt(piece) - x) < 2 * kPiece.radius)
      return negative(where.name + ": a piece lies where one should be dispensed").with_code("place_taken");
  const Vec3 position = transform(where.pose_in_world, {x, kMachine.belt_y, kMachine.working_height});
  const PieceId id = add_piece(stack, from, position, Holder::kBelt, static_cast<int>(from.station)).id;
  plan_arrival(from.station);
  return id;
}

Expected<PieceId> LedgerWorld::dispense(SpotId shelf, const Stack& stack) {
  const Spot& spot = plan_.spot(shelf);
  if (at(shelf)) return negative(spot.name + ": a piece lies where one should be dispensed").with_code("place_taken");
  return add_piece(stack, {spot.station}, spot.rest_in_world, Holder::kSlot, static_cast<int>(shelf)).id;
}

void LedgerWorld::run_belt(StationId station, double speed, double stop_x) {
  belts_[index_of(station)] = {speed, stop_x, kNever, 0};
  plan_arrival(station);
}

void LedgerWorld::retire(PieceId id, Holder to) {
  Piece& gone = piece(id);
  const int station = gone.holder == Holder::kBelt ? gone.holder_index : -1;
  pass(gone, to, station);
  remove(id);
  if (station >= 0) plan_arrival(static_cast<StationId>(station));
}

void LedgerWorld::put(Piece& moved, Holder to, int to_index, const Vec3& position) {
  moved.position_in_world = position;
  pass(moved, to, to_index);
}

// --- Robots

void LedgerWorld::move_along(RobotId robot, std::span<const Pose2> path, SimTime departure, SimTime arrival) {
  assert(!path.empty() && departure <= arrival);
  Motion& motion = motions_[index_of(robot)];
  motion.path.assign(path.begin(), path.end());
  motion.reached.assign(1, 0);
  for (std::size_t i = 1; i < path.size(); ++i)
    motion.reached.push_back(motion.reached.back() + std::hypot(path[i].x - path[i - 1].x, path[i].y - path[i - 1].y));
  motion.departure = departure;
  motion.arrival = arrival;
  motion.way = motion.reached.back() > 0 ? ++ways_ : 0;
}

void LedgerWorld::stop(RobotId robot) {
  const SimTime time = floor_time();
  motions_[index_of(robot)] = {{pose_at(robot, time)}, {0}, time, time, 0};
}

Status LedgerWorld::grasp(RobotId robot, SpotId from) {
  const Spot& spot = plan_.spot(from);
  if (held_by(robot)) return negative(plan_.robot(robot).name + " holds a piece already").with_code("gripper_full");
  const Piece* there = at(from);
  if (!there) return negative(spot.name + ": no piece to grasp").with_code("no_piece");
  put(piece(there->id), Holder::kGripper, static_cast<int>(robot), gripper_in_world(robot));
  if (spot.kind != SpotKind::kShelf) plan_arrival(spot.station);
  return {};
}

Status LedgerWorld::release(RobotId robot, SpotId to) {
  const Spot& spot = plan_.spot(to);
  const Piece* held = held_by(robot);
  if (!held) return negative(plan_.robot(robot).name + " holds nothing").with_code("gripper_empty");
  if (at(to)) return negative(spot.name + ": a piece lies there already").with_code("place_taken");
  Piece& put_down = piece(held->id);
  switch (spot.kind) {
    case SpotKind::kBeltInput:
    case SpotKind::kBeltOutput:
      put(put_down, Holder::kBelt, static_cast<int>(spot.station), spot.rest_in_world);
      plan_arrival(spot.station);
      break;
    case SpotKind::kShelf: put(put_down, Holder::kSlot, static_cast<int>(to), spot.rest_in_world); break;
    case SpotKind::kSlide:
      put(put_down, Holder::kSlide, static_cast<int>(to), spot.rest_in_world);
      slid_[index_of(spot.station)].push_back(robot);
      remove(put_down.id);
      break;
  }
  return {};
}

void LedgerWorld::drop(RobotId robot) {
  const Piece* held = held_by(robot);
  if (!held) return;
  const Vec3 at = gripper_in_world(robot);
  put(piece(held->id), Holder::kFloor, -1, {at.x(), at.y(), 0});
}

}  // namespace cxlab::sim
