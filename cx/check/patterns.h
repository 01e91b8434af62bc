#pragma once
// Patterns and facts slot by slot, as far as they can be compared without values.

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "cx/check/rule_base.h"

namespace cxlab::check {

/// What one slot, or one field of an ordered fact, must be.
struct SlotConstraint {
  std::string text;      ///< as written
  std::string variable;  ///< bound or compared first; may be empty
  std::set<std::string> one_of, none_of;
  bool impossible = false;  ///< as A&B
  bool plain = true;        ///< no more than the above: no call, no other variable
  int unbounded = 0;        ///< 1: `?n&:(> ?n 0)`, any larger number fulfils it, too; -1: any smaller one
  bool any() const { return plain && one_of.empty() && none_of.empty(); }
  bool admits(const std::string& value) const {
    return plain && (one_of.empty() || one_of.contains(value)) && !none_of.contains(value);
  }
  /// Whatever fulfils `other` fulfils this one.
  bool wider_than(const SlotConstraint& other) const;
};

struct PatternSlots {
  std::string name;  ///< of the template
  std::map<std::string, SlotConstraint> slots;
  /// Whatever matches `other` matches this one.
  bool wider_than(const PatternSlots& other) const;
};

/// None where it is no pattern of facts.
std::optional<PatternSlots> slots_of(const Term& pattern);
/// The values of a fact that is asserted, or of the slots that a modify sets (`from` = 2): slot -> its items.
std::map<std::string, std::span<const Term>> values_of(const Term& fact, std::size_t from = 1);
/// Variables of a term, each once.
std::set<std::string> variables_in(const Term& term);
/// How often a term has a variable.
std::size_t count_of(const Term& term, const std::string& variable);

}  // namespace cxlab::check
