#include "sim/mujoco/physics_gate.h"

#include <cassert>
#include <cmath>
#include <cstdio>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

constexpr int kBaseContype = 4, kPartContype = 16, kPieceConaffinity = 101;
/// Parked pieces wait here, one beside the other, without weight and without collisions.
const Vec3 kParking(0, -100, -10), kParkingPitch(0.1, 0, 0);
/// Share of a held piece's weight that its grip carries. The rest draws a piece out of fingers that hardly touch it.
constexpr double kCarried = 0.99;
constexpr std::int64_t kStepsPerHash = 2;

}  // namespace

PhysicsGate::PhysicsGate(FactoryModel factory, const FloorPlan& plan, PhysicsLog* log)
    : factory_(std::move(factory)),
      data_(mj_makeData(factory_.model.get())),
      hash_(XXH3_createState()),
      log_(log),
      controls_(index_of(factory_.model->nu)),
      lights_(factory_.stations.size()) {
  XXH3_64bits_reset(hash_.get());
  mjModel* m = factory_.model.get();
  for (const StationIds& station : factory_.stations)
    if (station.belt >= 0) m->geom_surfacevel[6 * station.belt] = 0;
  const int body = factory_.pieces.front().body;
  piece_inverse_weight_[0] = m->body_invweight0[2 * body];
  piece_inverse_weight_[1] = m->body_invweight0[2 * body + 1];
  for (std::size_t i = 0; i < factory_.pieces.size(); ++i) {
    Eigen::Map<Vec3> parked(m->qpos0 + factory_.pieces[i].qpos);
    parked = kParking + static_cast<double>(i) * kParkingPitch;
  }
  mj_resetData(m, data_.get());
  for (std::size_t i = 0; i < factory_.robots.size(); ++i) move_base(factory_.robots[i], plan.robots[i].pose_in_world);
}

Status PhysicsGate::step() {
  mj_step(factory_.model.get(), data_.get());
  ++steps_;
  for (const int body : woken_)
    for (int i = 0; i < 6; ++i) data_->xfrc_applied[6 * body + i] = 0;
  woken_.clear();
  if (steps_ % kStepsPerHash == 0) {
    XXH3_64bits_update(hash_.get(), data_->qpos, sizeof(mjtNum) * index_of(factory_.model->nq));
    XXH3_64bits_update(hash_.get(), data_->qvel, sizeof(mjtNum) * index_of(factory_.model->nv));
  }
  for (int w = 0; w < mjNWARNING; ++w) {
    if (data_->warning[w].number == 0) continue;
    char text[160];
    std::snprintf(text, sizeof text, "world diverged at %.3f s: %s", data_->time,
                  mju_warningText(w, static_cast<size_t>(data_->warning[w].lastinfo)));
    return run_error(text).with_code("world_diverged");
  }
  return {};
}

void PhysicsGate::write(const PhysicsWrite& write) {
  if (log_) log_->record(write);
  mjModel* m = factory_.model.get();
  mjData* d = data_.get();
  const auto& v = write.values;
  switch (write.kind) {
    case WriteKind::kControl:
      controls_[index_of(write.index)] = static_cast<std::int64_t>(v[0]);
      d->ctrl[write.index] = v[0] * kControlUnit;
      return;
    case WriteKind::kBeltSpeed: m->geom_surfacevel[6 * factory_.stations[index_of(write.index)].belt] = v[0]; return;
    case WriteKind::kShape: apply_shape(factory_.pieces[index_of(write.index)], write); return;
    case WriteKind::kPlace:
      move_piece(factory_.pieces[index_of(write.index)], {v[0], v[1], v[2] + kPieceOrigin}, 0);
      return;
    case WriteKind::kPark: {
      const PieceIds& piece = factory_.pieces[index_of(write.index)];
      apply_shape(piece, {});
      move_piece(piece, kParking + write.index * kParkingPitch, 1);
      return;
    }
    case WriteKind::kWake: {
      // A negative zero wakes a sleeping body and changes nothing else (MuJoCo: Sleeping islands, Waking).
      const int body = factory_.pieces[index_of(write.index)].body;
      d->xfrc_applied[6 * body] = -0.0;
      woken_.push_back(body);
      return;
    }
    case WriteKind::kLights:
      lights_[index_of(write.index)] = {static_cast<Light>(v[0]), static_cast<Light>(v[1]), static_cast<Light>(v[2])};
      return;
    case WriteKind::kSetDown: move_base(factory_.robots[index_of(write.index)], {v[0], v[1], v[2]}); return;
    case WriteKind::kCarry: m->body_gravcomp[factory_.pieces[index_of(write.index)].body] = v[0] * kCarried; return;
  }
}

void PhysicsGate::control(int actuator, double value) {
  const std::int64_t units = std::llround(value / kControlUnit);
  if (units == controls_[index_of(actuator)]) return;
  write({steps_, WriteKind::kControl, actuator, {static_cast<double>(units)}});
}

void PhysicsGate::belt_speed(StationId station, double speed) {
  write({steps_, WriteKind::kBeltSpeed, static_cast<int>(station), {speed}});
}

void PhysicsGate::shape(std::size_t body, const Stack& stack) {
  write({steps_,
         WriteKind::kShape,
         static_cast<int>(body),
         {static_cast<double>(stack.base), static_cast<double>(stack.rings[0]), static_cast<double>(stack.rings[1]),
          static_cast<double>(stack.rings[2]), static_cast<double>(stack.cap)}});
}

void PhysicsGate::place(std::size_t body, const Vec3& underside) {
  write({steps_, WriteKind::kPlace, static_cast<int>(body), {underside.x(), underside.y(), underside.z()}});
}

void PhysicsGate::park(std::size_t body) { write({steps_, WriteKind::kPark, static_cast<int>(body), {}}); }

void PhysicsGate::wake(std::size_t body) { write({steps_, WriteKind::kWake, static_cast<int>(body), {}}); }

void PhysicsGate::carry(std::size_t body, bool on) {
  write({steps_, WriteKind::kCarry, static_cast<int>(body), {on ? 1.0 : 0.0}});
}

void PhysicsGate::lights(StationId station, const Lights& lights) {
  write({steps_,
         WriteKind::kLights,
         static_cast<int>(station),
         {static_cast<double>(lights.red), static_cast<double>(lights.yellow), static_cast<double>(lights.green)}});
}

void PhysicsGate::set_down(RobotId robot, const Pose2& to) {
  write({steps_, WriteKind::kSetDown, static_cast<int>(robot), {to.x, to.y, to.yaw}});
}

void PhysicsGate::move_base(const RobotIds& robot, const Pose2& to) {
  const double pose[] = {to.x, to.y, to.yaw};
  for (const RobotAxis axis : {kAxisX, kAxisY, kAxisYaw}) {
    data_->qpos[robot.qpos[axis]] = pose[axis];
    data_->qvel[robot.dof[axis]] = data_->qacc_warmstart[robot.dof[axis]] = 0;
  }
}

void PhysicsGate::apply_slot(int geom, const std::vector<int>& materials, int colour, int contype) {
  mjModel* m = factory_.model.get();
  const int material = colour > 0 && index_of(colour) < materials.size() ? materials[index_of(colour)] : -1;
  m->geom_contype[geom] = colour > 0 ? contype : 0;
  m->geom_conaffinity[geom] = colour > 0 ? kPieceConaffinity : 0;
  m->geom_matid[geom] = material;
  for (int i = 0; i < 4; ++i)
    m->geom_rgba[4 * geom + i] = material >= 0 ? m->mat_rgba[4 * material + i] : (colour > 0 ? 1.0f : 0.0f);
}

// The parts' mass is counted at the base's centre: the body's frame stays the frame of its inertia, which MuJoCo fixes
// when it compiles a model.
void PhysicsGate::apply_shape(const PieceIds& piece, const PhysicsWrite& write) {
  mjModel* m = factory_.model.get();
  const auto colour = [&](int slot) { return static_cast<int>(write.values[index_of(slot)]); };
  int rings = 0;
  apply_slot(piece.geoms[kSlotBase], factory_.base_materials, colour(kSlotBase), kBaseContype);
  for (int slot = kSlotRing1; slot <= kSlotRing3; ++slot) {
    apply_slot(piece.geoms[index_of(slot)], factory_.ring_materials, colour(slot), kPartContype);
    if (colour(slot) > 0) ++rings;
  }
  const int cap = piece.geoms[kSlotCap];
  const bool has_cap = colour(kSlotCap) > 0;
  apply_slot(cap, factory_.cap_materials, colour(kSlotCap), kPartContype);
  m->geom_size[3 * cap + 1] = kPiece.cap_height / 2;
  m->geom_pos[3 * cap + 2] = kPieceOrigin + rings * kPiece.ring_height + kPiece.cap_height / 2;

  const bool in_play = colour(kSlotBase) > 0;
  m->body_contype[piece.body] = in_play ? kBaseContype | kPartContype : 0;
  m->body_conaffinity[piece.body] = in_play ? kPieceConaffinity : 0;

  const double mass = kPiece.base_mass + kPiece.part_mass * (rings + (has_cap ? 1 : 0));
  const double height = kPiece.base_height + kPiece.ring_height * rings + (has_cap ? kPiece.cap_height : 0);
  const double across = mass * (3 * kPiece.radius * kPiece.radius + height * height) / 12;
  m->body_mass[piece.body] = m->body_subtreemass[piece.body] = mass;
  m->body_inertia[3 * piece.body] = m->body_inertia[3 * piece.body + 1] = across;
  m->body_inertia[3 * piece.body + 2] = mass * kPiece.radius * kPiece.radius / 2;
  for (int i = 0; i < 2; ++i)
    m->body_invweight0[2 * piece.body + i] = piece_inverse_weight_[i] * kPiece.base_mass / mass;
}

void PhysicsGate::move_piece(const PieceIds& piece, const Vec3& origin, double gravity_compensation) {
  mjData* d = data_.get();
  const double pose[7] = {origin.x(), origin.y(), origin.z(), 1, 0, 0, 0};
  for (int i = 0; i < 7; ++i) d->qpos[piece.qpos + i] = pose[i];
  for (int i = 0; i < 6; ++i) d->qvel[piece.dof + i] = d->qacc_warmstart[piece.dof + i] = 0;
  factory_.model->body_gravcomp[piece.body] = gravity_compensation;
}

void PhysicsGate::show(RobotId robot, const RobotState& state) {
  const RobotIds& ids = factory_.robots[index_of(robot)];
  move_base(ids, state.pose_in_world);
  const double closed = kRobot.fingers_open - state.finger_opening;
  const double axes[] = {state.gripper.x(), state.gripper.y(), state.gripper.z(), closed, closed};
  for (int axis = kAxisForward; axis < kRobotAxes; ++axis)
    data_->qpos[ids.qpos[index_of(axis)]] = axes[axis - kAxisForward];
}

void PhysicsGate::show(std::size_t body, const Pose3& underside) {
  const double angle = underside.rotation.norm();
  const Vec3 axis = angle > 0 ? Vec3(underside.rotation / angle) : Vec3(Vec3::UnitZ());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis));
  const Vec3 origin = underside.position + turn * Vec3(0, 0, kPieceOrigin);
  const double pose[7] = {origin.x(), origin.y(), origin.z(), turn.w(), turn.x(), turn.y(), turn.z()};
  for (int i = 0; i < 7; ++i) data_->qpos[factory_.pieces[body].qpos + i] = pose[i];
}

Expected<PhysicsReplay> PhysicsReplay::load(const FloorPlan& plan, const ModelOptions& options, std::string_view log) {
  auto factory = build_factory(plan, options);
  if (!factory) return factory.error();
  PhysicsReplay replay(std::make_unique<PhysicsGate>(std::move(*factory), plan), log);
  if (Status s = replay.read_next(); !s) return s.error();
  return replay;
}

Status PhysicsReplay::read_next() {
  auto next = reader_.next();
  if (!next) return next.error();
  next_ = *next;
  if (!next_) return {};
  const FactoryModel& factory = gate_->factory();
  const auto limit = [&]() -> std::size_t {
    switch (next_->kind) {
      case WriteKind::kControl: return index_of(factory.model->nu);
      case WriteKind::kBeltSpeed:
      case WriteKind::kLights: return factory.stations.size();
      case WriteKind::kSetDown: return factory.robots.size();
      default: return factory.pieces.size();
    }
  }();
  const bool no_belt = next_->kind == WriteKind::kBeltSpeed && index_of(next_->index) < limit &&
                       factory.stations[index_of(next_->index)].belt < 0;
  if (index_of(next_->index) >= limit || no_belt) return input_error("physics log: it does not belong to this model");
  return {};
}

Status PhysicsReplay::advance_to(std::int64_t steps) {
  while (gate_->steps() < steps) {
    while (next_ && next_->step == gate_->steps()) {
      gate_->write(*next_);
      if (Status s = read_next(); !s) return s;
    }
    if (Status s = gate_->step(); !s) return s;
  }
  return {};
}

}  // namespace cxlab::sim
