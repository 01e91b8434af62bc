#include "sim/mujoco/mujoco_world.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace cxlab::sim {
namespace {

// docs/models.md: what robots can do.
constexpr double kMaxSpeed = 0.7, kMaxAcceleration = 0.4, kMaxBraking = 1.5;         // m/s, m/s2
constexpr double kMaxTurn = 1.4, kMaxTurnAcceleration = 1.6, kMaxTurnBraking = 3.2;  // rad/s, rad/s2
constexpr double kAxisSpeed = 0.1;                                                   // m/s
constexpr double kReleaseHeight = 0.0002;  ///< a new piece appears this high above its place

/// A new holder counts when it was seen in so many ticks on end: a piece that is gripped while it still stands on the
/// belt, or bounces once, changes hands once.
constexpr int kHolderTicks = 3;
/// Who touches whom is kept in bits.
constexpr std::size_t kMaxRobots = 32;

double approach(double from, double to, double most) { return from + std::clamp(to - from, -most, most); }

}  // namespace

Expected<std::unique_ptr<MujocoWorld>> MujocoWorld::create(FloorPlan plan, const ModelOptions& options,
                                                           PhysicsTap* tap) {
  if (plan.robots.size() > kMaxRobots)
    return input_error(std::to_string(plan.robots.size()) + " robots: at most " + std::to_string(kMaxRobots));
  auto factory = build_factory(plan, options);
  if (!factory) return factory.error();
  return std::unique_ptr<MujocoWorld>(new MujocoWorld(std::move(plan), std::move(*factory), tap));
}

MujocoWorld::MujocoWorld(FloorPlan plan, FactoryModel factory, PhysicsTap* tap)
    : plan_(std::move(plan)),
      gate_(std::move(factory), plan_),
      step_(gate_.model().opt.timestep),
      tracks_(gate_.factory().pieces.size()),
      motions_(plan_.robots.size()),
      belts_(plan_.stations.size()),
      slide_counts_(plan_.stations.size()) {
  gate_.set_tap(tap);
  pieces_.reserve(tracks_.size());
  slid_.reserve(tracks_.size());
}

// --- moving on -------------------------------------------------------------------------------------------------

Status MujocoWorld::advance(SimTime tick) {
  const SimTime step = from_seconds(step_);
  if (tick.count() <= 0 || tick % step != SimTime{})
    return input_error("tick " + std::to_string(to_seconds(tick)) + " s is not a whole number of physics steps of " +
                       std::to_string(step_) + " s");
  changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(told_changes_));
  for (std::size_t i = 0; i < motions_.size(); ++i) drive(motions_[i], gate_.factory().robots[i], to_seconds(tick));
  for (auto n = tick / step; n > 0; --n) {
    if (Status s = gate_.step(); !s) return s;
    now_ += step;
    count_robot_contacts();
    read_piece_contacts();
    stop_arrived_belts();
  }
  update_pieces();
  told_changes_ = changes_.size();
  return {};
}

// Limits of speed and acceleration: commands are wishes, the motors get ramps.
void MujocoWorld::drive(Motion& m, const RobotIds& ids, double dt) {
  const double speed = std::hypot(m.vx, m.vy);
  double dvx = m.want_vx - m.vx, dvy = m.want_vy - m.vy;
  if (const double change = std::hypot(dvx, dvy); change > kMaxBraking * dt) {
    dvx *= kMaxBraking * dt / change;
    dvy *= kMaxBraking * dt / change;
  }
  m.vx += dvx;
  m.vy += dvy;
  const double most = std::min(kMaxSpeed, speed + kMaxAcceleration * dt);
  if (const double now = std::hypot(m.vx, m.vy); now > most) {
    m.vx *= most / now;
    m.vy *= most / now;
  }
  const bool faster = std::abs(m.want_omega) > std::abs(m.omega) && m.want_omega * m.omega >= 0;
  m.omega = approach(m.omega, m.want_omega, (faster ? kMaxTurnAcceleration : kMaxTurnBraking) * dt);
  m.axes.x = approach(m.axes.x, m.want_axes.x, kAxisSpeed * dt);
  m.axes.y = approach(m.axes.y, m.want_axes.y, kAxisSpeed * dt);
  m.axes.z = approach(m.axes.z, m.want_axes.z, kAxisSpeed * dt);
  m.opening = approach(m.opening, m.want_opening, kAxisSpeed * dt);
  gate_.control(ids.actuator[kAxisX], m.vx);
  gate_.control(ids.actuator[kAxisY], m.vy);
  gate_.control(ids.actuator[kAxisYaw], m.omega);
  gate_.control(ids.actuator[kAxisForward], m.axes.x);
  gate_.control(ids.actuator[kAxisLeft], m.axes.y);
  gate_.control(ids.actuator[kAxisUp], m.axes.z);
  gate_.control(ids.actuator[kAxisFingerLeft], kRobot.fingers_open - m.opening);
  gate_.control(ids.actuator[kAxisFingerRight], kRobot.fingers_open - m.opening);
}

void MujocoWorld::count_robot_contacts() {
  const mjData& d = gate_.data();
  const auto& uses = gate_.factory().geoms;
  std::uint64_t robots[kMaxRobots] = {};
  std::uint64_t statics = 0;
  for (int c = 0; c < d.ncon; ++c) {
    const GeomUse a = uses[at_index(d.contact[c].geom[0])], b = uses[at_index(d.contact[c].geom[1])];
    if (a.role != GeomRole::kHull && b.role != GeomRole::kHull) continue;
    if (a.role == GeomRole::kHull && b.role == GeomRole::kHull) {
      robots[a.index] |= std::uint64_t{1} << b.index;
      robots[b.index] |= std::uint64_t{1} << a.index;
    } else {
      statics |= std::uint64_t{1} << (a.role == GeomRole::kHull ? a.index : b.index);
    }
  }
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    Motion& m = motions_[i];
    m.robot_contacts += static_cast<std::uint32_t>(std::popcount(robots[i] & ~m.touching_robots));
    m.touching_robots = robots[i];
    const bool touches = (statics >> i) & 1;
    if (touches && !m.touching_static) ++m.static_contacts;
    m.touching_static = touches;
  }
}

void MujocoWorld::stop_arrived_belts() {
  for (std::size_t s = 0; s < belts_.size(); ++s) {
    if (belts_[s].speed == 0) continue;
    const StationId station = static_cast<StationId>(s);
    const double sign = belts_[s].speed > 0 ? 1 : -1;
    bool arrived = false;
    for (const Piece& piece : pieces_) {
      const int body = body_of(piece.id);
      Track& track = tracks_[at_index(body)];
      const Vec3 here = inverse_transform(plan_.station(station).pose_in_world, underside_of(body));
      const bool on = std::abs(here.y - kMachine.belt_y) < kSpotTolerance.across_belt &&
                      std::abs(here.x) < kMachine.belt_half_length &&
                      std::abs(here.z - kMachine.working_height) < kSpotTolerance.height &&
                      piece.holder != Holder::kGripper;
      if (on && track.belt == static_cast<int>(s) && sign * (belts_[s].stop_x - track.belt_x) > 0 &&
          sign * (belts_[s].stop_x - here.x) <= 0)
        arrived = true;
      if (on) {
        track.belt = static_cast<int>(s);
        track.belt_x = here.x;
      } else if (track.belt == static_cast<int>(s)) {
        track.belt = -1;
      }
    }
    if (arrived) stop_belt(station);
  }
}

// --- who holds what --------------------------------------------------------------------------------------------

void MujocoWorld::note_support(Track& track, GeomUse other) {
  switch (other.role) {
    case GeomRole::kBelt:
      track.support = Holder::kBelt;
      track.support_index = other.index;
      return;
    case GeomRole::kShelf:
      track.support = Holder::kSlot;
      track.support_index = other.index;
      return;
    case GeomRole::kSlide:
      track.support = Holder::kSlide;
      track.support_index = other.index;
      return;
    case GeomRole::kFloor:
    case GeomRole::kFieldWall:
    case GeomRole::kMachineBody:
      // Guides and cheeks touch from the side: what carries it has the say.
      if (track.support == Holder::kDispenser) track.support = Holder::kFloor;
      return;
    default: return;
  }
}

// A piece that fell asleep has no contacts any more: what it touched last is what carries it.
void MujocoWorld::read_piece_contacts() {
  const mjData& d = gate_.data();
  const FactoryModel& factory = gate_.factory();
  const std::int64_t step = gate_.steps();
  const auto renew = [step](Track& track) {
    if (track.read_at == step) return;
    track.read_at = step;
    track.left = track.right = 0;
    track.support = Holder::kDispenser;
    track.support_index = -1;
    track.touches_other = false;
  };
  for (const Piece& piece : pieces_) {
    const int body = body_of(piece.id);
    if (d.body_awake[factory.pieces[at_index(body)].body]) renew(tracks_[at_index(body)]);
  }
  const auto is_piece = [](GeomUse use) {
    return use.role == GeomRole::kPieceBase || use.role == GeomRole::kPiecePart;
  };
  for (int c = 0; c < d.ncon; ++c) {
    GeomUse a = factory.geoms[at_index(d.contact[c].geom[0])], b = factory.geoms[at_index(d.contact[c].geom[1])];
    if (!is_piece(a)) std::swap(a, b);
    if (!is_piece(a)) continue;
    Track& track = tracks_[at_index(a.index)];
    renew(track);
    if (is_piece(b)) {
      Track& other = tracks_[at_index(b.index)];
      renew(other);
      track.touches_other = other.touches_other = true;
    } else if (b.role == GeomRole::kFingerLeft) {
      track.left |= 1u << b.index;
    } else if (b.role == GeomRole::kFingerRight) {
      track.right |= 1u << b.index;
    } else {
      note_support(track, b);
    }
  }
}

void MujocoWorld::update_pieces() {
  for (Motion& m : motions_) m.held_body = -1;
  slid_.clear();
  for (Piece& piece : pieces_) {
    const int body = body_of(piece.id);
    piece.position_in_world = underside_of(body);
    Track& track = tracks_[at_index(body)];
    update_holder(piece, track);
    const std::uint32_t both = track.left & track.right;
    if (both && track.support == Holder::kDispenser && !track.touches_other)
      motions_[at_index(std::countr_zero(both))].held_body = body;
    if (slid_in(piece, track)) slid_.push_back(piece.id);
  }
  for (const PieceId id : slid_) {
    const int station = tracks_[at_index(body_of(id))].support_index;
    ++slide_counts_[at_index(station)];
    Piece& piece = *find_mutable(id);
    const int spot = slide_spot(static_cast<StationId>(station));
    if (piece.holder != Holder::kSlide) change_holder(piece, Holder::kSlide, spot);
    take_out(id);
  }
}

void MujocoWorld::update_holder(Piece& piece, Track& track) {
  Holder seen = piece.holder;
  int seen_index = piece.holder_index;
  const std::uint32_t both = track.left & track.right;
  if (both) {
    // Gripped and still standing on something: it stays where it was.
    if (track.support == Holder::kDispenser && !track.touches_other) {
      seen = Holder::kGripper;
      seen_index = std::countr_zero(both);
    }
  } else if (track.support != Holder::kDispenser) {
    seen = track.support;
    seen_index = track.support_index;
    const StationId station = static_cast<StationId>(track.support_index);
    if (seen == Holder::kSlot)
      seen_index =
          nearest_shelf_spot(station, inverse_transform(plan_.station(station).pose_in_world, piece.position_in_world));
    if (seen == Holder::kSlide) seen_index = slide_spot(station);
  }
  if (seen == piece.holder && seen_index == piece.holder_index) {
    track.candidate_ticks = 0;
    return;
  }
  if (track.candidate_ticks == 0 || seen != track.candidate || seen_index != track.candidate_index) {
    track.candidate = seen;
    track.candidate_index = seen_index;
    track.candidate_ticks = 0;
  }
  if (++track.candidate_ticks < kHolderTicks) return;
  track.candidate_ticks = 0;
  change_holder(piece, seen, seen_index);
}

bool MujocoWorld::slid_in(const Piece& piece, const Track& track) const {
  if (track.support != Holder::kSlide || (track.left & track.right)) return false;
  const Pose2& frame = plan_.stations[at_index(track.support_index)].pose_in_world;
  return inverse_transform(frame, piece.position_in_world).x < kMachine.slide_counted_x;
}

void MujocoWorld::change_holder(Piece& piece, Holder to, int to_index) {
  changes_.push_back({piece.id, piece.holder, to, piece.holder_index, to_index, piece.position_in_world, now_});
  piece.holder = to;
  piece.holder_index = to_index;
}

// --- queries ---------------------------------------------------------------------------------------------------

Vec3 MujocoWorld::underside_of(int body) const {
  const mjtNum* q = gate_.data().qpos + gate_.factory().pieces[at_index(body)].qpos;
  // Third column of the rotation: the piece's own up.
  const double w = q[3], x = q[4], y = q[5], z = q[6];
  const Vec3 up{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
  return {q[0] - kPieceOrigin * up.x, q[1] - kPieceOrigin * up.y, q[2] - kPieceOrigin * up.z};
}

Piece* MujocoWorld::find_mutable(PieceId id) {
  const auto found = std::lower_bound(pieces_.begin(), pieces_.end(), id,
                                      [](const Piece& piece, PieceId wanted) { return piece.id < wanted; });
  return found != pieces_.end() && found->id == id ? &*found : nullptr;
}

const Piece* MujocoWorld::find(PieceId id) const { return const_cast<MujocoWorld*>(this)->find_mutable(id); }

RobotState MujocoWorld::robot(RobotId id) const {
  const mjData& d = gate_.data();
  const RobotIds& ids = gate_.factory().robots[at_index(id)];
  const Motion& motion = motions_[at_index(id)];
  const auto q = [&](RobotAxis axis) { return d.qpos[ids.qpos[axis]]; };
  const auto v = [&](RobotAxis axis) { return d.qvel[ids.dof[axis]]; };
  RobotState state;
  state.pose_in_world = {q(kAxisX), q(kAxisY), wrap_angle(q(kAxisYaw))};
  state.vx = v(kAxisX);
  state.vy = v(kAxisY);
  state.omega = v(kAxisYaw);
  state.gripper = {q(kAxisForward), q(kAxisLeft), q(kAxisUp)};
  state.finger_opening = kRobot.fingers_open - (q(kAxisFingerLeft) + q(kAxisFingerRight)) / 2;
  for (const Piece& piece : pieces_)
    if (body_of(piece.id) == motion.held_body) state.held = piece.id;
  state.robot_contacts = motion.robot_contacts;
  state.static_contacts = motion.static_contacts;
  return state;
}

const Piece* MujocoWorld::at(SpotId id) const {
  const Spot& spot = plan_.spot(id);
  if (spot.kind == SpotKind::kSlide) return nullptr;
  const Pose2& frame = plan_.station(spot.station).pose_in_world;
  for (const Piece& piece : pieces_) {
    if (piece.holder == Holder::kGripper) continue;
    const Vec3 here = inverse_transform(frame, piece.position_in_world);
    const double dx = here.x - spot.rest_in_station.x, dy = here.y - spot.rest_in_station.y;
    if (std::abs(here.z - spot.rest_in_station.z) > kSpotTolerance.height) continue;
    if (spot.kind == SpotKind::kShelf
            ? std::hypot(dx, dy) <= kSpotTolerance.shelf
            : std::abs(dx) <= kSpotTolerance.along_belt && std::abs(dy) <= kSpotTolerance.across_belt)
      return &piece;
  }
  return nullptr;
}

const Piece* MujocoWorld::on_belt(StationId id, double x) const {
  const Pose2& frame = plan_.station(id).pose_in_world;
  const Piece* nearest = nullptr;
  double least = kSpotTolerance.along_belt;
  for (const Piece& piece : pieces_) {
    if (piece.holder == Holder::kGripper) continue;
    const Vec3 here = inverse_transform(frame, piece.position_in_world);
    if (std::abs(here.y - kMachine.belt_y) > kSpotTolerance.across_belt ||
        std::abs(here.z - kMachine.working_height) > kSpotTolerance.height)
      continue;
    if (const double distance = std::abs(here.x - x); distance <= least) {
      least = distance;
      nearest = &piece;
    }
  }
  return nearest;
}

int MujocoWorld::nearest_shelf_spot(StationId station, const Vec3& here) const {
  int nearest = -1;
  double least = 1e9;
  for (std::size_t i = 0; i < plan_.spots.size(); ++i) {
    const Spot& spot = plan_.spots[i];
    if (spot.station != station || spot.kind != SpotKind::kShelf) continue;
    if (const double distance = std::abs(here.y - spot.rest_in_station.y); distance < least) {
      least = distance;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

int MujocoWorld::slide_spot(StationId station) const {
  for (std::size_t i = 0; i < plan_.spots.size(); ++i)
    if (plan_.spots[i].station == station && plan_.spots[i].kind == SpotKind::kSlide) return static_cast<int>(i);
  return -1;
}

// --- verbs of machines -----------------------------------------------------------------------------------------

Expected<PieceId> MujocoWorld::put_in_play(const Vec3& underside, const Stack& stack, StationId from, Holder to,
                                           int to_index) {
  for (const Piece& piece : pieces_) {
    const Vec3& p = piece.position_in_world;
    if (std::hypot(p.x - underside.x, p.y - underside.y) < 2 * kPiece.radius && std::abs(p.z - underside.z) < 0.06)
      return run_error(plan_.station(from).name + ": the place of a new piece is taken by piece " +
                       std::to_string(static_cast<int>(piece.id)))
          .with_code("place_taken");
  }
  const auto spare = std::find_if(tracks_.begin(), tracks_.end(), [](const Track& t) { return !t.in_play; });
  if (spare == tracks_.end())
    return run_error(plan_.station(from).name + ": all " + std::to_string(tracks_.size()) + " pieces are in play")
        .with_code("no_spare_piece");
  const int body = static_cast<int>(spare - tracks_.begin());
  *spare = Track{};
  spare->in_play = true;
  bodies_.push_back(body);
  const PieceId id = static_cast<PieceId>(bodies_.size());
  gate_.shape(body, stack);
  gate_.place(body, {underside.x, underside.y, underside.z + kReleaseHeight});
  pieces_.push_back({id, stack, Holder::kDispenser, static_cast<int>(from), underside});
  change_holder(pieces_.back(), to, to_index);
  return id;
}

Expected<PieceId> MujocoWorld::dispense(StationId station, double x_on_belt, const Stack& stack) {
  const Vec3 place =
      transform(plan_.station(station).pose_in_world, {x_on_belt, kMachine.belt_y, kMachine.working_height});
  return put_in_play(place, stack, station, Holder::kBelt, static_cast<int>(station));
}

Expected<PieceId> MujocoWorld::dispense(SpotId shelf, const Stack& stack) {
  const Spot& spot = plan_.spot(shelf);
  const Vec3 place = transform(plan_.station(spot.station).pose_in_world, spot.rest_in_station);
  return put_in_play(place, stack, spot.station, Holder::kSlot, static_cast<int>(shelf));
}

void MujocoWorld::run_belt(StationId station, double speed, double stop_x) {
  assert(gate_.factory().stations[at_index(station)].belt >= 0);
  if (speed == 0) return stop_belt(station);
  belts_[at_index(station)] = {speed, stop_x};
  gate_.belt_speed(station, speed);
  for (const Piece& piece : pieces_) {
    Track& track = tracks_[at_index(body_of(piece.id))];
    if (track.belt == static_cast<int>(station)) track.belt = -1;
    if (piece.holder != Holder::kBelt || piece.holder_index != static_cast<int>(station)) continue;
    track.belt = static_cast<int>(station);
    track.belt_x = inverse_transform(plan_.station(station).pose_in_world, piece.position_in_world).x;
    gate_.wake(body_of(piece.id));
  }
}

void MujocoWorld::stop_belt(StationId station) {
  Belt& belt = belts_[at_index(station)];
  if (belt.speed == 0) return;
  belt = {};
  gate_.belt_speed(station, 0);
}

void MujocoWorld::mount(PieceId id, Part part, std::uint8_t colour) {
  Piece* piece = find_mutable(id);
  assert(piece);
  if (part == Part::kCap) {
    piece->stack.cap = colour;
  } else {
    const auto free = std::find(piece->stack.rings.begin(), piece->stack.rings.end(), 0);
    assert(free != piece->stack.rings.end());
    *free = colour;
  }
  gate_.shape(body_of(id), piece->stack);
}

void MujocoWorld::unmount_cap(PieceId id) {
  Piece* piece = find_mutable(id);
  assert(piece);
  piece->stack.cap = 0;
  gate_.shape(body_of(id), piece->stack);
}

void MujocoWorld::retire(PieceId id, Holder to) {
  Piece* piece = find_mutable(id);
  assert(piece);
  const int station = piece->holder == Holder::kBelt ? piece->holder_index : -1;
  change_holder(*piece, to, station);
  take_out(id);
}

void MujocoWorld::take_out(PieceId id) {
  const int body = body_of(id);
  gate_.park(body);
  tracks_[at_index(body)] = Track{};
  for (Motion& m : motions_)
    if (m.held_body == body) m.held_body = -1;
  pieces_.erase(pieces_.begin() + (find_mutable(id) - pieces_.data()));
  bodies_[at_index(id) - 1] = -1;
}

void MujocoWorld::set_lights(StationId station, const Lights& lights) {
  if (gate_.lights(station) != lights) gate_.lights(station, lights);
}

// --- robots ----------------------------------------------------------------------------------------------------

void MujocoWorld::command_base(RobotId robot, double vx, double vy, double omega) {
  Motion& m = motions_[at_index(robot)];
  const double speed = std::hypot(vx, vy), scale = speed > kMaxSpeed ? kMaxSpeed / speed : 1;
  m.want_vx = vx * scale;
  m.want_vy = vy * scale;
  m.want_omega = std::clamp(omega, -kMaxTurn, kMaxTurn);
}

void MujocoWorld::command_gripper(RobotId robot, const Vec3& axes) {
  motions_[at_index(robot)].want_axes = {std::clamp(axes.x, 0.0, kRobot.forward_stroke),
                                         std::clamp(axes.y, -kRobot.left_stroke, kRobot.left_stroke),
                                         std::clamp(axes.z, 0.0, kRobot.up_stroke)};
}

void MujocoWorld::command_fingers(RobotId robot, double opening) {
  motions_[at_index(robot)].want_opening = std::clamp(opening, kRobot.fingers_squeeze, kRobot.fingers_widest);
}

}  // namespace cxlab::sim
