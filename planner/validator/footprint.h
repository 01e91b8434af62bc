#pragma once
// What a happening reads and writes, to see whether two interfere.

#include <optional>
#include <string>
#include <vector>

#include "planner/validator/validator.h"

namespace cxlab::planner {

class Footprint {
 public:
  explicit Footprint(const Validator& validator) : validator_(&validator) {}

  /// Adds all that `condition` names with this binding, whether or not the rest of it is known: so does VAL.
  void read(const Condition& condition, Frame& frame);
  /// Adds what the condition of an effect reads. What can never change is evaluated first, and parts that are then
  /// known read nothing.
  void read_guard(const Condition& condition, Frame& frame) { gather(condition, frame); }
  void read(const Expression& expression, const Frame& frame);
  void write(const std::vector<Change>& changes);

  /// The fact or number over which two happenings interfere; empty if they do not.
  static std::string interference(const Footprint& a, const Footprint& b);

 private:
  /// What can never change is known.
  using Known = std::optional<bool>;
  Known gather_atom(const Condition& condition, Frame& frame);
  Known gather(const Condition& condition, Frame& frame);
  Known gather_many(const Condition& condition, Frame& frame);
  /// One of the facts, or numbers, from which a derived fact that is read is computed; null: there is none.
  const Fact* derived_from(ById<char> Symbols::* kind, const std::vector<Fact>& facts) const;
  static std::string one_way(const Footprint& reader, const Footprint& writer);

  const Validator* validator_;
  // Functions are kept as Fact, too, with their id as `predicate`.
  std::vector<Fact> reads_, adds_, deletes_;
  std::vector<Fact> number_reads_, assigned_, increased_;
  std::vector<PredicateId> derived_reads_;
};

}  // namespace cxlab::planner
