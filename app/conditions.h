#pragma once
// The conditions of a rule as they were written, and how far a fact is from one. It reads what can be compared without
// running CLIPS: constants. Variables, tests and function calls are left open.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/engine/engine.h"

namespace cxlab::app {

/// A word or a list of a rule's text.
struct Term {
  std::string word;  ///< empty for a list; strings keep their quotes
  std::vector<Term> items;
  bool is_list = false;
  std::string text() const;
};

/// One pattern of a left-hand side.
struct Condition {
  Term pattern;          ///< (template ...)
  bool negated = false;  ///< inside (not ...)
  std::string template_name() const { return pattern.items.empty() ? std::string() : pattern.items.front().word; }
  /// Words like ?order that the pattern names.
  std::vector<std::string> variables() const;
};

/// The patterns of `defrule` in order; those of a rule with (or ...) are all of them, one after the other.
std::vector<Condition> conditions_of(const std::string& defrule);

/// How a fact fails a pattern.
struct Mismatch {
  std::string slot;  ///< "implied" for an ordered fact
  std::string found, expected;
};
/// Slots of `fact` that certainly do not match.
std::vector<Mismatch> mismatches(const Condition& condition, const FactCopy& fact);

}  // namespace cxlab::app
