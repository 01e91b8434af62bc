#include "scenarios/rcll/rules/storage.h"

namespace cxlab::rcll {

Storage Storage::at_start() {
  Storage storage;
  int shelf = 0;
  for (const BaseColor base : {BaseColor::kRed, BaseColor::kSilver, BaseColor::kBlack})
    for (const CapColor cap : {CapColor::kGrey, CapColor::kBlack})
      storage.at({shelf++, 1}) = Content{stack_of({.base = base, .rings = {}, .cap = cap})};
  return storage;
}

bool Storage::exists(const Slot& slot) {
  return slot.shelf >= 0 && slot.shelf < kShelves && slot.slot >= 0 && slot.slot < kSlots;
}

std::optional<Storage::Content>& Storage::at(const Slot& slot) {
  return contents_[static_cast<std::size_t>(slot.shelf * kSlots + slot.slot)];
}

const std::optional<Storage::Content>& Storage::at(const Slot& slot) const {
  return contents_[static_cast<std::size_t>(slot.shelf * kSlots + slot.slot)];
}

std::optional<Storage::Slot> Storage::blocker(const Slot& slot) const {
  if (slot.slot % 2 == 0) return std::nullopt;
  const Slot front{slot.shelf, slot.slot - 1};
  return at(front) ? std::optional(front) : std::nullopt;
}

std::vector<Storage::Slot> Storage::free_slots(const Slot& except) const {
  std::vector<Slot> free;
  for (int shelf = 0; shelf < kShelves; ++shelf)
    for (int slot = 0; slot < kSlots; ++slot)
      if (const Slot here{shelf, slot}; here != except && !at(here) && !blocker(here)) free.push_back(here);
  return free;
}

}  // namespace cxlab::rcll
