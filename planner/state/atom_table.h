#pragma once
// Ground atoms and their numbers, and the objects of an atom with variables.

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

/// The objects bound to the slots of an action, rule or goal.
using Frame = ById<ObjectId>;

/// The objects of terms in a frame, without allocation for the usual few.
class Objects {
 public:
  Objects(const std::vector<Term>& terms, const Frame& frame);
  const ObjectId* begin() const { return data(); }
  const ObjectId* end() const { return data() + size_; }

 private:
  static constexpr std::size_t kFew = 12;
  const ObjectId* data() const { return size_ <= kFew ? few_ : many_.data(); }

  std::size_t size_;
  ObjectId few_[kFew];
  std::vector<ObjectId> many_;
};

}  // namespace cxlab::planner
