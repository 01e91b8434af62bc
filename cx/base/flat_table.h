#pragma once
// A hash table for small entries that are made and erased all the time.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cxlab {

/// Open addressing. An entry has a member `key`, a pointer or a number of its size; the default one is none. Has no
/// order, so that addresses as keys reach no result. References hold until the next insertion or erasure.
template <class Entry>
class FlatTable {
 public:
  using Key = decltype(Entry::key);

  FlatTable() : slots_(64) {}

  /// The new entry of a key that is not there.
  Entry& insert(Key key) {
    if (2 * ++size_ > slots_.size()) {
      std::vector<Entry> old(2 * slots_.size());
      old.swap(slots_);
      for (const Entry& entry : old)
        if (entry.key != Key{}) slots_[slot_of(entry.key)] = entry;
    }
    Entry& entry = slots_[slot_of(key)];
    entry.key = key;
    return entry;
  }
  /// Null if there is none.
  Entry* find(Key key) { return const_cast<Entry*>(static_cast<const FlatTable&>(*this).find(key)); }
  const Entry* find(Key key) const {
    const Entry& entry = slots_[slot_of(key)];
    return entry.key == Key{} ? nullptr : &entry;
  }
  void erase(Key key) {
    std::size_t hole = slot_of(key);
    if (slots_[hole].key == Key{}) return;
    --size_;
    // Shift back what a search would no longer reach over the hole.
    for (std::size_t i = next(hole); slots_[i].key != Key{}; i = next(i)) {
      const std::size_t home = home_of(slots_[i].key);
      const bool stays = hole <= i ? (hole < home && home <= i) : (hole < home || home <= i);
      if (stays) continue;
      slots_[hole] = slots_[i];
      hole = i;
    }
    slots_[hole] = {};
  }
  void clear() {
    slots_.assign(slots_.size(), {});
    size_ = 0;
  }

 private:
  std::size_t home_of(Key key) const {
    return (std::bit_cast<std::uintptr_t>(key) * 0x9e3779b97f4a7c15ULL >> 20) & (slots_.size() - 1);
  }
  std::size_t next(std::size_t i) const { return (i + 1) & (slots_.size() - 1); }
  std::size_t slot_of(Key key) const {
    std::size_t i = home_of(key);
    while (slots_[i].key != Key{} && slots_[i].key != key) i = next(i);
    return i;
  }

  std::vector<Entry> slots_;
  std::size_t size_ = 0;
};

}  // namespace cxlab
