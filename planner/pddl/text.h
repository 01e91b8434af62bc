#pragma once
// Model back to PDDL text: for messages, for files, and for plans.

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

// The words of the language by kind; empty for kinds that are written in another way.
inline constexpr std::array<std::string_view, 9> kConditionWords = {"",   "",      "",       "not",   "and",
                                                                    "or", "imply", "forall", "exists"};
inline constexpr std::array<std::string_view, 9> kExpressionWords = {"", "", "+", "-", "*", "/", "-", "", ""};
inline constexpr std::array<std::string_view, 5> kComparisonWords = {"<", "<=", "=", ">=", ">"};
inline constexpr std::array<std::string_view, 7> kEffectWords = {"",         "",         "assign",    "increase",
                                                                 "decrease", "scale-up", "scale-down"};

template <class Kind, std::size_t n>
std::optional<Kind> kind_of(const std::array<std::string_view, n>& words, std::string_view word) {
  const auto found = std::find(words.begin(), words.end(), word);
  if (word.empty() || found == words.end()) return std::nullopt;
  return static_cast<Kind>(found - words.begin());
}
template <class Kind, std::size_t n>
std::string text_of(const std::array<std::string_view, n>& words, Kind kind) {
  return std::string(words[static_cast<std::size_t>(kind)]);
}

/// Writes parts of actions and problems. Slots are written as in `names`: variables, or the objects bound to them.
class Printer {
 public:
  Printer(const Domain& domain, const ById<Object>& objects) : domain_(&domain), objects_(&objects) {}

  /// Writes parameters as variables: `?x`.
  void name_variables(const std::vector<Variable>& parameters);
  /// Writes slots 0, 1, ... as these objects.
  void name_objects(std::span<const ObjectId> objects);

  std::string condition(const Condition& condition) const;
  std::string expression(const Expression& expression) const;
  /// Without its variables, time and condition: `(not (p ?x))`. Name its variables first.
  std::string effect(const Effect& effect) const;
  /// `?x ?y - type ?z - (either a b)`
  std::string variables(const std::vector<Variable>& variables) const;

 private:
  std::string term(const Term& term) const;
  std::string terms(const std::string& name, const std::vector<Term>& terms) const;

  const Domain* domain_;
  const ById<Object>* objects_;
  ById<std::string> names_;
};

/// `(head a b)`
template <class Items, class Text>
std::string list_text(std::string_view head, const Items& items, Text text_of, const char* before = " ") {
  std::string text = "(" + std::string(head);
  for (const auto& item : items) text += before + text_of(item);
  return text + ")";
}
std::string ground_text(const std::string& name, std::span<const ObjectId> arguments, const ById<Object>& objects);
/// `block`, `(either a b)`
std::string types_text(const Domain& domain, const std::vector<TypeId>& types);
/// A number as short as it can be read back without loss: 5, 0.1.
std::string number_text(double number);
/// A time in seconds with three decimals, or up to nine where three lose something: 5.000, 33.333333333.
std::string time_text(double seconds);

/// The whole domain or problem as PDDL that parses to the same model.
std::string to_pddl(const Domain& domain);
std::string to_pddl(const Domain& domain, const Problem& problem);

}  // namespace cxlab::planner
