#pragma once
// The pieces in play and who holds them: what both kinds of world note down in the same way.

#include <span>
#include <vector>

#include "sim/world.h"

namespace cxlab::sim {

class PieceBook {
 public:
  std::span<const Piece> pieces() const { return pieces_; }  ///< by id
  std::span<Piece> pieces() { return pieces_; }
  const Piece* find(PieceId id) const;  ///< nullptr when out of play
  Piece* find(PieceId id);
  Piece& at(PieceId id);  ///< of a piece in play

  /// A new piece comes out of the station's dispenser. The reference holds until the next `add` or `remove`.
  Piece& add(const Stack& stack, StationId from, const Vec3& position);
  /// Gives the piece a new holder and notes the change with the piece's position.
  void pass(Piece& piece, Holder to, int to_index, SimTime now);
  void remove(PieceId id);

  /// Changes noted before the last `end_advance` and after the one before it (WorldView::changes).
  std::span<const HolderChange> changes() const { return {changes_.data(), visible_}; }
  void begin_advance();
  void end_advance() { visible_ = changes_.size(); }

 private:
  std::vector<Piece> pieces_;
  std::int32_t last_id_ = 0;
  std::vector<HolderChange> changes_;
  std::size_t visible_ = 0;
};

}  // namespace cxlab::sim
