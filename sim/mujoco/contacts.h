#pragma once
// The contacts between bodies, read after each physics step.

#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/mujoco/physics_gate.h"

namespace cxlab::sim {

/// What a piece touches. A sleeping piece has no contacts: what it touched last still holds.
struct PieceTouch {
  std::uint32_t left = 0, right = 0;    ///< robots whose finger touches it, as bits
  Holder support = Holder::kDispenser;  ///< belt, slot, slide or floor; kDispenser = nothing supports it
  int station = -1;                     ///< of that belt, shelf or slide
  bool other_piece = false;

  bool gripped() const { return (left & right) != 0; }
  bool supported() const { return support != Holder::kDispenser; }
  /// The robot that holds it by both fingers, off everything else.
  std::optional<RobotId> holder() const {
    if (!gripped() || supported() || other_piece) return std::nullopt;
    return static_cast<RobotId>(std::countr_zero(left & right));
  }
};

class Contacts {
 public:
  static constexpr std::size_t kMaxRobots = 32;  ///< robots are kept in bits

  explicit Contacts(const FactoryModel& factory);

  /// Before the steps of a tick.
  void begin_tick();
  /// After each step.
  void read(const PhysicsGate& gate);
  /// The piece in that body of the pool is a new one.
  void forget_piece(std::size_t body) { pieces_[body].touch = {}; }

  const PieceTouch& of_piece(std::size_t body) const { return pieces_[body].touch; }
  /// Robots that this one has touched since the tick began, as bits.
  std::uint32_t touching(RobotId robot) const { return hulls_[index_of(robot)].in_tick; }
  /// New contacts since the start.
  std::uint32_t with_robots(RobotId robot) const { return hulls_[index_of(robot)].with_robots; }
  std::uint32_t with_statics(RobotId robot) const { return hulls_[index_of(robot)].with_statics; }

 private:
  struct Hull {
    std::uint32_t robots = 0, robots_before = 0;  ///< touched in this step and in the one before, as bits
    std::uint32_t in_tick = 0;
    bool statics = false, statics_before = false;
    std::uint32_t with_robots = 0, with_statics = 0;
  };
  struct PieceState {
    std::int64_t step = -1;  ///< of `touch`
    PieceTouch touch;
  };
  /// The piece's touch in this step, empty at first.
  PieceTouch& renewed(std::size_t body);
  void note_hull(GeomUse hull, GeomUse other);
  void note_piece(GeomUse piece, GeomUse other);
  void count_new();

  std::int64_t step_ = 0;
  std::vector<Hull> hulls_;         ///< by robot
  std::vector<PieceState> pieces_;  ///< by body of the pool
};

}  // namespace cxlab::sim
