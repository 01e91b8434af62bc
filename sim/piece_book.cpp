#include "sim/piece_book.h"

#include <algorithm>
#include <cassert>

namespace cxlab::sim {

const Piece* PieceBook::find(PieceId id) const { return const_cast<PieceBook*>(this)->find(id); }

Piece* PieceBook::find(PieceId id) {
  const auto found = std::ranges::lower_bound(pieces_, id, {}, &Piece::id);
  return found != pieces_.end() && found->id == id ? &*found : nullptr;
}

Piece& PieceBook::at(PieceId id) {
  Piece* piece = find(id);
  assert(piece && "the piece is in play");
  return *piece;
}

Piece& PieceBook::add(const Stack& stack, StationId from, const Vec3& position) {
  return pieces_.emplace_back(Piece{PieceId{++last_id_}, stack, Holder::kDispenser, static_cast<int>(from), position});
}

void PieceBook::pass(Piece& piece, Holder to, int to_index, SimTime now) {
  changes_.push_back({piece.id, piece.holder, to, piece.holder_index, to_index, piece.position_in_world, now});
  piece.holder = to;
  piece.holder_index = to_index;
}

void PieceBook::remove(PieceId id) {
  std::erase_if(pieces_, [id](const Piece& piece) { return piece.id == id; });
}

void PieceBook::begin_advance() {
  changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(visible_));
  visible_ = 0;
}

}  // namespace cxlab::sim
