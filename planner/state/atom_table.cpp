#include "planner/state/atom_table.h"

#include <algorithm>
#include <cstdint>

namespace cxlab::planner {

std::size_t AtomTable::slot(PredicateId predicate, std::span<const ObjectId> objects) const {
  std::uint64_t hash = std::uint64_t{0x9e3779b97f4a7c15} * static_cast<std::uint64_t>(predicate + 1);
  for (const ObjectId object : objects) {
    hash = (hash ^ static_cast<std::uint64_t>(object + 1)) * std::uint64_t{0xff51afd7ed558ccd};
    hash ^= hash >> 32;
  }
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t at = hash & mask;; at = (at + 1) & mask) {
    const int atom = slots_[at];
    if (atom < 0) return at;
    if (predicates_[atom] == predicate && std::ranges::equal(this->objects(atom), objects)) return at;
  }
}

int AtomTable::find(PredicateId predicate, std::span<const ObjectId> objects) const {
  return slots_[slot(predicate, objects)];
}

int AtomTable::insert(PredicateId predicate, std::span<const ObjectId> objects) {
  if (2 * predicates_.size() >= slots_.size()) grow();
  int& entry = slots_[slot(predicate, objects)];
  if (entry < 0) {
    entry = size();
    predicates_.push_back(predicate);
    objects_.insert(objects_.end(), objects.begin(), objects.end());
    begin_.push_back(objects_.size());
  }
  return entry;
}

void AtomTable::grow() {
  slots_.assign(2 * slots_.size(), -1);
  for (int atom = 0; atom < size(); ++atom) slots_[slot(predicates_[atom], objects(atom))] = atom;
}

Objects::Objects(const std::vector<Term>& terms, const Frame& frame) : size_(terms.size()) {
  if (size_ > kFew) many_.resize(size_);
  ObjectId* out = size_ > kFew ? many_.data() : few_;
  for (const Term& term : terms) *out++ = term.in(frame);
}

}  // namespace cxlab::planner
