#pragma once
// The journal's data of each existing fact.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cxlab {

/// A hash table from the address of a fact; only ever asked for one fact, so that addresses reach no result.
class FactTable {
 public:
  struct Entry {
    const void* fact = nullptr;
    std::uint64_t number = 0;  ///< counted over the life of the environment
    std::uint64_t record = 0;  ///< of its assert or last modify, in the stream of the environment
  };

  FactTable() : slots_(64) {}

  Entry& insert(const void* fact) {
    if (2 * ++size_ > slots_.size()) grow();
    Entry& entry = slots_[find_slot(fact)];
    entry.fact = fact;
    return entry;
  }

  Entry* find(const void* fact) {
    Entry& entry = slots_[find_slot(fact)];
    return entry.fact == nullptr ? nullptr : &entry;
  }

  void erase(const void* fact) {
    std::size_t hole = find_slot(fact);
    if (slots_[hole].fact == nullptr) return;
    --size_;
    // Shift back what a search would no longer reach over the hole.
    for (std::size_t i = next(hole); slots_[i].fact != nullptr; i = next(i)) {
      const std::size_t home = home_of(slots_[i].fact);
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
  std::size_t home_of(const void* fact) const {
    return (reinterpret_cast<std::uintptr_t>(fact) * 0x9e3779b97f4a7c15ULL >> 20) & (slots_.size() - 1);
  }
  std::size_t next(std::size_t i) const { return (i + 1) & (slots_.size() - 1); }

  std::size_t find_slot(const void* fact) const {
    std::size_t i = home_of(fact);
    while (slots_[i].fact != nullptr && slots_[i].fact != fact) i = next(i);
    return i;
  }

  void grow() {
    std::vector<Entry> old(2 * slots_.size());
    old.swap(slots_);
    for (const Entry& entry : old) {
      if (entry.fact != nullptr) slots_[find_slot(entry.fact)] = entry;
    }
  }

  std::vector<Entry> slots_;
  std::size_t size_ = 0;
};

}  // namespace cxlab
