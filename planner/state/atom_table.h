#pragma once
// Ground atoms and their numbers.

#include <span>
#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// Ground atoms, numbered in the order in which they were added.
class AtomTable {
 public:
  /// The number of an atom, or -1.
  int find(PredicateId predicate, std::span<const ObjectId> objects) const;
  /// The number of the atom, added if it is new.
  int insert(PredicateId predicate, std::span<const ObjectId> objects);

  int size() const { return static_cast<int>(predicates_.size()); }
  PredicateId predicate(int atom) const { return predicates_[atom]; }
  std::span<const ObjectId> objects(int atom) const {
    return {objects_.data() + begin_[atom], objects_.data() + begin_[atom + 1]};
  }

 private:
  std::size_t slot(PredicateId predicate, std::span<const ObjectId> objects) const;
  void grow();

  ById<PredicateId> predicates_;
  ById<std::size_t> begin_ = {0};
  std::vector<ObjectId> objects_;
  std::vector<int> slots_ = std::vector<int>(64, -1);  ///< open addressing; size is a power of two
};

}  // namespace cxlab::planner
