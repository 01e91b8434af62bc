#include "sim/mujoco/mujoco_world.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

constexpr double kReleaseHeight = 0.0002;  ///< a new piece appears this high above its place
constexpr double kPlaceHeight = 0.06;      ///< a piece nearer than that above or below a place takes it up

/// A new holder counts after so many ticks in a row. So a piece that a gripper takes while it still stands on the belt,
/// or that bounces once, changes hands only once.
constexpr int kHolderTicks = 3;

/// Whether a point in a station's frame is on its belt.
bool on_belt_at(const Vec3& here) {
  return std::abs(here.y() - kMachine.belt_y) <= kSpotTolerance.across_belt &&
         std::abs(here.z() - kMachine.working_height) <= kSpotTolerance.height;
}

}  // namespace

Expected<std::unique_ptr<MujocoWorld>> MujocoWorld::create(FloorPlan plan, const ModelOptions& options,
                                                           PhysicsLog* log) {
  if (plan.robots.size() > Contacts::kMaxRobots)
    return input_error(std::to_string(plan.robots.size()) + " robots: at most " + std::to_string(Contacts::kMaxRobots));
  auto factory = build_factory(plan, options);
  if (!factory) return factory.error();
  return std::unique_ptr<MujocoWorld>(new MujocoWorld(std::move(plan), std::move(*factory), log));
}

MujocoWorld::MujocoWorld(FloorPlan plan, FactoryModel factory, PhysicsLog* log)
    : World(std::move(plan)),
      gate_(std::move(factory), plan_, log),
      contacts_(gate_.factory()),
      motors_(plan_.robots.size()),
      step_(gate_.model().opt.timestep),
      bodies_(gate_.factory().pieces.size()),
      held_(plan_.robots.size()),
      belts_(plan_.stations.size()) {}

// --- Time

Status MujocoWorld::advance(SimTime tick) {
  const SimTime step = from_seconds(step_);
  if (tick.count() <= 0 || tick % step != SimTime{})
    return input_error("tick " + std::to_string(to_seconds(tick)) + " s is not a whole number of physics steps of " +
                       std::to_string(step_) + " s");
  begin_changes();
  motors_.drive(gate_, to_seconds(tick));
  contacts_.begin_tick();
  for (auto n = tick / step; n > 0; --n) {
    if (Status s = gate_.step(); !s) return s;
    now_ += step;
    contacts_.read(gate_);
    stop_arrived_belts();
  }
  update_pieces();
  end_changes();
  return {};
}

void MujocoWorld::stop_arrived_belts() {
  for (std::size_t s = 0; s < belts_.size(); ++s) {
    const auto [speed, stop_x] = belts_[s];
    if (speed == 0) continue;
    const auto station = static_cast<StationId>(s);
    const int number = static_cast<int>(s);
    const double sign = speed > 0 ? 1 : -1;
    bool arrived = false;
    for (const Piece& piece : pieces_) {
      Body& body = bodies_[body_of(piece.id)];
      const Vec3 here = in_station(station, underside_of(body_of(piece.id)));
      if (piece.holder != Holder::kGripper && on_belt_at(here) && std::abs(here.x()) < kMachine.belt_half_length) {
        const bool was_before = body.belt == number && sign * (stop_x - body.belt_x) > 0;
        if (was_before && sign * (stop_x - here.x()) <= 0) arrived = true;
        body.belt = number;
        body.belt_x = here.x();
      } else if (body.belt == number) {
        body.belt = -1;
      }
    }
    if (arrived) stop_belt(station);
  }
}

// --- Who holds what

void MujocoWorld::update_pieces() {
  held_.assign(held_.size(), std::nullopt);
  std::vector<PieceId> slid;
  for (Piece& piece : pieces_) {
    piece.position_in_world = underside_of(body_of(piece.id));
    update_holder(piece);
    const auto robot = contacts_.of_piece(body_of(piece.id)).holder();
    if (robot) held_[index_of(*robot)] = piece.id;
    carry(piece, robot.has_value());
    if (slid_in(piece)) slid.push_back(piece.id);
  }
  for (const PieceId id : slid) {
    Piece& paid = piece(id);
    const auto station = static_cast<StationId>(contacts_.of_piece(body_of(id)).station);
    if (paid.holder != Holder::kSlide) {
      const SpotId spot = nearest_spot(station, SpotKind::kSlide, paid.position_in_world);
      pass(paid, Holder::kSlide, static_cast<int>(spot));
    }
    slid_[index_of(station)].push_back(paid.held_by);
    take_out(id);
  }
}

void MujocoWorld::update_holder(Piece& piece) {
  Body& body = bodies_[body_of(piece.id)];
  const Place place = place_of(piece);
  if (place == Place{piece.holder, piece.holder_index}) {
    body.seen_ticks = 0;
    return;
  }
  if (place != body.seen) body.seen_ticks = 0;
  body.seen = place;
  if (++body.seen_ticks < kHolderTicks) return;
  body.seen_ticks = 0;
  pass(piece, place.holder, place.index);
}

/// A grip carries the weight of what is in it. The friction of MuJoCo acts on velocities alone: a held piece would
/// creep down, and fall after some minutes.
void MujocoWorld::carry(const Piece& piece, bool gripped) {
  Body& body = bodies_[body_of(piece.id)];
  const bool on = gripped && piece.holder == Holder::kGripper;
  // A carried piece has no weight, so it can sleep in the air when the fingers open. An awake piece is seen to touch
  // nothing, and falls.
  if (body.carried && !gate_.is_awake(body_of(piece.id))) gate_.wake(body_of(piece.id));
  if (on == body.carried) return;
  body.carried = on;
  gate_.carry(body_of(piece.id), on);
}

/// Where its contacts say that it is. One that is gripped and still stands on something stays where it was.
MujocoWorld::Place MujocoWorld::place_of(const Piece& piece) const {
  const PieceTouch& touch = contacts_.of_piece(body_of(piece.id));
  if (const auto robot = touch.holder()) return {Holder::kGripper, static_cast<int>(*robot)};
  const bool on_a_heap = touch.other_piece && piece.position_in_world.z() < kMachine.working_height / 2;
  if (!touch.gripped() && !touch.supported() && on_a_heap) return {Holder::kFloor, -1};
  if (touch.gripped() || !touch.supported()) return {piece.holder, piece.holder_index};
  const auto spot = [&](SpotKind kind) {
    return static_cast<int>(nearest_spot(static_cast<StationId>(touch.station), kind, piece.position_in_world));
  };
  if (touch.support == Holder::kSlot) return {touch.support, spot(SpotKind::kShelf)};
  if (touch.support == Holder::kSlide) return {touch.support, spot(SpotKind::kSlide)};
  return {touch.support, touch.station};
}

bool MujocoWorld::slid_in(const Piece& piece) const {
  const PieceTouch& touch = contacts_.of_piece(body_of(piece.id));
  if (touch.support != Holder::kSlide || touch.gripped()) return false;
  const Vec3 here = in_station(static_cast<StationId>(touch.station), piece.position_in_world);
  return here.x() < kMachine.slide_counted_x;
}

// --- What one can see

Vec3 MujocoWorld::in_station(StationId station, const Vec3& point) const {
  return inverse_transform(plan_.station(station).pose_in_world, point);
}

Vec3 MujocoWorld::underside_of(std::size_t body) const {
  const mjtNum* q = gate_.data().qpos + gate_.factory().pieces[body].qpos;
  const Eigen::Quaterniond rotation(q[3], q[4], q[5], q[6]);
  return Eigen::Map<const Vec3>(q) - kPieceOrigin * (rotation * Vec3::UnitZ());
}

Pose3 MujocoWorld::pose_of(std::size_t body) const {
  const mjtNum* q = gate_.data().qpos + gate_.factory().pieces[body].qpos;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(q[3], q[4], q[5], q[6]));
  return {underside_of(body), wrap_angle(turn.angle()) * turn.axis()};
}

Pose3 MujocoWorld::pose_in_holder(const Piece& piece) const {
  const Pose3 pose = pose_of(body_of(piece.id));
  if (piece.holder == Holder::kGripper) {
    const mjtNum* q = gate_.data().qpos;
    const RobotIds& ids = gate_.factory().robots[static_cast<std::size_t>(piece.holder_index)];
    return relative_to(pose_in_space({q[ids.qpos[kAxisX]], q[ids.qpos[kAxisY]], q[ids.qpos[kAxisYaw]]}), pose);
  }
  if (const auto station = piece.station(plan_))
    return relative_to(pose_in_space(plan_.station(*station).pose_in_world), pose);
  return pose;
}

RobotState MujocoWorld::robot(RobotId id) const {
  const mjData& d = gate_.data();
  const RobotIds& ids = gate_.factory().robots[index_of(id)];
  const auto q = [&](RobotAxis axis) { return d.qpos[ids.qpos[axis]]; };
  const auto v = [&](RobotAxis axis) { return d.qvel[ids.dof[axis]]; };
  RobotState state;
  state.pose_in_world = {q(kAxisX), q(kAxisY), wrap_angle(q(kAxisYaw))};
  state.vx = v(kAxisX);
  state.vy = v(kAxisY);
  state.omega = v(kAxisYaw);
  state.gripper = {q(kAxisForward), q(kAxisLeft), q(kAxisUp)};
  state.finger_opening = kRobot.fingers_open - (q(kAxisFingerLeft) + q(kAxisFingerRight)) / 2;
  state.held = held_[index_of(id)];
  state.touching = contacts_.touching(id);
  state.robot_contacts = contacts_.with_robots(id);
  state.static_contacts = contacts_.with_statics(id);
  return state;
}

const Piece* MujocoWorld::at(SpotId id) const {
  const Spot& spot = plan_.spot(id);
  if (spot.kind == SpotKind::kSlide) return nullptr;
  for (const Piece& piece : pieces_) {
    if (piece.holder == Holder::kGripper) continue;
    const Vec3 off = in_station(spot.station, piece.position_in_world) - spot.rest_in_station;
    if (std::abs(off.z()) > kSpotTolerance.height) continue;
    if (spot.kind == SpotKind::kShelf
            ? off.head<2>().norm() <= kSpotTolerance.shelf
            : std::abs(off.x()) <= kSpotTolerance.along_belt && std::abs(off.y()) <= kSpotTolerance.across_belt)
      return &piece;
  }
  return nullptr;
}

const Piece* MujocoWorld::on_belt(StationId id, double x) const {
  const Piece* nearest = nullptr;
  double least = kSpotTolerance.along_belt;
  for (const Piece& piece : pieces_) {
    if (piece.holder == Holder::kGripper) continue;
    const Vec3 here = in_station(id, piece.position_in_world);
    if (!on_belt_at(here)) continue;
    if (const double distance = std::abs(here.x() - x); distance <= least) {
      least = distance;
      nearest = &piece;
    }
  }
  return nearest;
}

/// Across the station: slots lie side by side. The station has a spot of that kind.
SpotId MujocoWorld::nearest_spot(StationId station, SpotKind kind, const Vec3& point) const {
  const double y = in_station(station, point).y();
  std::optional<std::size_t> nearest;
  const auto off = [&](std::size_t i) { return std::abs(y - plan_.spots[i].rest_in_station.y()); };
  for (std::size_t i = 0; i < plan_.spots.size(); ++i)
    if (plan_.spots[i].station == station && plan_.spots[i].kind == kind && (!nearest || off(i) < off(*nearest)))
      nearest = i;
  return static_cast<SpotId>(nearest.value());
}

// --- Verbs of machines

Expected<PieceId> MujocoWorld::put_in_play(const Vec3& underside, const Stack& stack, const Source& from, Place to) {
  for (const Piece& piece : pieces_) {
    const Vec3 off = piece.position_in_world - underside;
    if (off.head<2>().norm() < 2 * kPiece.radius && std::abs(off.z()) < kPlaceHeight)
      return run_error(plan_.station(from.station).name + ": the place of a new piece is taken by piece " +
                       std::to_string(static_cast<int>(piece.id)))
          .with_code("place_taken");
  }
  const auto spare = std::ranges::find(bodies_, false, &Body::in_play);
  if (spare == bodies_.end())
    return run_error(plan_.station(from.station).name + ": all " + std::to_string(bodies_.size()) +
                     " pieces are in play")
        .with_code("no_spare_piece");
  *spare = {};
  spare->in_play = true;
  const auto body = static_cast<std::size_t>(spare - bodies_.begin());
  contacts_.forget_piece(body);
  gate_.shape(body, stack);
  gate_.place(body, underside + kReleaseHeight * Vec3::UnitZ());
  const PieceId id = add_piece(stack, from, underside, to.holder, to.index).id;
  bodies_of_pieces_.resize(std::max(bodies_of_pieces_.size(), index_of(id)));
  bodies_of_pieces_[index_of(id) - 1] = body;
  return id;
}

Expected<PieceId> MujocoWorld::bring_out(const Source& from, double x_on_belt, const Stack& stack) {
  const Vec3 place =
      transform(plan_.station(from.station).pose_in_world, {x_on_belt, kMachine.belt_y, kMachine.working_height});
  return put_in_play(place, stack, from, {Holder::kBelt, static_cast<int>(from.station)});
}

Expected<PieceId> MujocoWorld::dispense(SpotId shelf, const Stack& stack) {
  const Spot& spot = plan_.spot(shelf);
  return put_in_play(spot.rest_in_world, stack, {spot.station}, {Holder::kSlot, static_cast<int>(shelf)});
}

void MujocoWorld::run_belt(StationId station, double speed, double stop_x) {
  assert(gate_.factory().stations[index_of(station)].belt >= 0);
  if (speed == 0) return stop_belt(station);
  belts_[index_of(station)] = {speed, stop_x};
  gate_.belt_speed(station, halted() ? 0 : speed);
  for (const Piece& piece : pieces_) {
    Body& body = bodies_[body_of(piece.id)];
    if (body.belt == static_cast<int>(station)) body.belt = -1;
    if (!piece.is_with(Holder::kBelt, station)) continue;
    body.belt = static_cast<int>(station);
    body.belt_x = in_station(station, piece.position_in_world).x();
    gate_.wake(body_of(piece.id));
  }
}

void MujocoWorld::stop_belt(StationId station) {
  Belt& belt = belts_[index_of(station)];
  if (belt.speed == 0) return;
  belt = {};
  gate_.belt_speed(station, 0);
}

void MujocoWorld::mount(PieceId id, Part part, std::uint8_t colour) {
  piece(id).stack.mount(part, colour);
  gate_.shape(body_of(id), piece(id).stack);
}

void MujocoWorld::unmount_cap(PieceId id) {
  piece(id).stack.cap = 0;
  gate_.shape(body_of(id), piece(id).stack);
}

void MujocoWorld::retire(PieceId id, Holder to) {
  Piece& gone = piece(id);
  pass(gone, to, gone.holder == Holder::kBelt ? gone.holder_index : -1);
  take_out(id);
}

void MujocoWorld::take_out(PieceId id) {
  gate_.park(body_of(id));
  bodies_[body_of(id)] = {};
  std::ranges::replace(held_, std::optional(id), std::optional<PieceId>());
  remove(id);
}

void MujocoWorld::set_down(RobotId robot, const Pose2& to) {
  gate_.set_down(robot, to);
  motors_.stand(robot);
}

void MujocoWorld::halt() {
  World::halt();
  motors_.hold(true);
  for (std::size_t i = 0; i < belts_.size(); ++i)
    if (belts_[i].speed != 0) gate_.belt_speed(static_cast<StationId>(i), 0);
}

void MujocoWorld::go_on() {
  World::go_on();
  motors_.hold(false);
  for (std::size_t i = 0; i < belts_.size(); ++i)
    if (const auto [speed, stop_x] = belts_[i]; speed != 0) run_belt(static_cast<StationId>(i), speed, stop_x);
}

void MujocoWorld::set_lights(StationId station, const Lights& lights) {
  if (gate_.lights(station) != lights) gate_.lights(station, lights);
}

}  // namespace cxlab::sim
