#pragma once
// The shelves of a storage station: six with eight slots each. An odd slot lies behind the even one before it, which
// blocks it when it is filled.

#include <array>
#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/rcll/rules/types.h"
#include "sim/world.h"

namespace cxlab::rcll {

class Storage {
 public:
  static constexpr int kShelves = 6, kSlots = 8;
  struct Slot {
    int shelf = 0;  ///< 0..5
    int slot = 0;   ///< 0..7
    friend auto operator<=>(const Slot&, const Slot&) = default;
  };
  struct Content {
    sim::Stack stack;
    std::string description = {};            ///< what its team says of it
    std::optional<sim::PieceId> piece = {};  ///< that was stored; none: it lies there since the game began
  };

  /// As a game begins: shelf k has one C0 in slot 1: red, silver, black bases with a grey, then a black cap.
  static Storage at_start();

  static bool exists(const Slot& slot);
  /// The content of a slot, which must exist; an empty optional means an empty slot.
  std::optional<Content>& at(const Slot& slot);
  const std::optional<Content>& at(const Slot& slot) const;
  /// The filled slot that one must empty first.
  std::optional<Slot> blocker(const Slot& slot) const;
  /// Empty slots that nothing blocks, in order, without `except`.
  std::vector<Slot> free_slots(const Slot& except) const;

 private:
  std::array<std::optional<Content>, kShelves * kSlots> contents_;
};

}  // namespace cxlab::rcll
