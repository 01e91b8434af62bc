#include "sim/mujoco/contacts.h"

namespace cxlab::sim {
namespace {

bool is_piece(GeomUse use) { return use.role == GeomRole::kPieceBase || use.role == GeomRole::kPiecePart; }

}  // namespace

Contacts::Contacts(const FactoryModel& factory) : hulls_(factory.robots.size()), pieces_(factory.pieces.size()) {}

void Contacts::begin_tick() {
  for (Hull& hull : hulls_) hull.in_tick = 0;
}

void Contacts::read(const PhysicsGate& gate) {
  const mjData& data = gate.data();
  const FactoryModel& factory = gate.factory();
  step_ = gate.steps();
  for (std::size_t body = 0; body < pieces_.size(); ++body)
    if (gate.is_awake(body)) renewed(body);
  for (int i = 0; i < data.ncon; ++i) {
    const GeomUse a = factory.geoms[index_of(data.contact[i].geom[0])];
    const GeomUse b = factory.geoms[index_of(data.contact[i].geom[1])];
    if (a.role == GeomRole::kHull) note_hull(a, b);
    if (b.role == GeomRole::kHull) note_hull(b, a);
    if (is_piece(a)) note_piece(a, b);
    if (is_piece(b)) note_piece(b, a);
  }
  count_new();
}

PieceTouch& Contacts::renewed(std::size_t body) {
  PieceState& piece = pieces_[body];
  if (piece.step != step_) piece = {step_, {}};
  return piece.touch;
}

void Contacts::note_hull(GeomUse hull, GeomUse other) {
  if (other.role == GeomRole::kHull)
    hulls_[index_of(hull.index)].robots |= 1u << other.index;
  else
    hulls_[index_of(hull.index)].statics = true;
}

void Contacts::note_piece(GeomUse piece, GeomUse other) {
  PieceTouch& touch = renewed(index_of(piece.index));
  const auto support = [&](Holder kind) {
    touch.support = kind;
    touch.station = other.index;
  };
  switch (other.role) {
    case GeomRole::kFingerLeft: touch.left |= 1u << other.index; return;
    case GeomRole::kFingerRight: touch.right |= 1u << other.index; return;
    case GeomRole::kPieceBase:
    case GeomRole::kPiecePart: touch.other_piece = true; return;
    case GeomRole::kBelt: return support(Holder::kBelt);
    case GeomRole::kShelf: return support(Holder::kSlot);
    case GeomRole::kSlide: return support(Holder::kSlide);
    case GeomRole::kFloor:
    case GeomRole::kFieldWall:
    case GeomRole::kMachineBody:
      // Guides and cheeks touch from the side: the part that carries the piece counts.
      if (!touch.supported()) touch.support = Holder::kFloor;
      return;
    case GeomRole::kNone:
    case GeomRole::kHull: return;
  }
}

void Contacts::count_new() {
  for (Hull& hull : hulls_) {
    hull.with_robots += static_cast<std::uint32_t>(std::popcount(hull.robots & ~hull.robots_before));
    if (hull.statics && !hull.statics_before) ++hull.with_statics;
    hull.in_tick |= hull.robots;
    hull.robots_before = hull.robots;
    hull.statics_before = hull.statics;
    hull.robots = 0;
    hull.statics = false;
  }
}

}  // namespace cxlab::sim
