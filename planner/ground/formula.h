#pragma once
// A ground condition in negation normal form, on its way to conjunctions.

#include <cstdint>
#include <vector>

namespace cxlab::planner {

struct Formula {
  enum class Kind : std::uint8_t { kTrue, kFalse, kFact, kComparison, kAnd, kOr };
  Kind kind = Kind::kTrue;
  int index = -1;
  std::vector<Formula> parts;
};

inline Formula truth(bool value) { return {value ? Formula::Kind::kTrue : Formula::Kind::kFalse, -1, {}}; }

/// kAnd or kOr of the parts, flat and without what decides nothing.
Formula join(Formula::Kind kind, std::vector<Formula> parts);

/// Conjunctions of which one must hold. A disjunction stays a part of its conjunction where splitting would give more
/// than `most` of them. Empty if the formula is false.
std::vector<Formula> alternatives(const Formula& from, std::size_t most);

}  // namespace cxlab::planner
