#pragma once
// The left-hand side of a rule as a tree of its conditions.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/explain/pattern.h"

namespace cxlab::explain {

struct Condition {
  enum class Kind { kPattern, kTest, kAnd, kOr, kNot, kExists, kForall };
  Kind kind = Kind::kAnd;
  std::vector<Condition> parts;  ///< of all but patterns and tests; `logical` is an and
  Pattern pattern;
  std::string fact_variable;  ///< of `?f <- (...)`; may be empty
  Term expression;            ///< of a test
  std::string text;           ///< in one line
  int line = 0;
  std::size_t begin = 0, end = 0;  ///< of its characters in the rule, from its fact variable on
};

/// The conditions of a `defrule` in order. Errors have lines within the rule's text, counted from `line`.
Expected<std::vector<Condition>> conditions_of(const std::string& defrule, const std::string& file = {}, int line = 1);

}  // namespace cxlab::explain
