#pragma once
// Mutants of rule files: each is a file with one small change of a rule, function or global, as a mistake would make
// it.
//
//   const std::vector<Mutant> mutants = mutants_of({{"clips/door.clp", text}});
//   const std::string other = mutated(text, mutants.front());

#include <cstddef>
#include <string>
#include <vector>

namespace cxlab::lab {

/// What a mutant changes.
enum class Change {
  kCondition,   ///< a condition of a rule is dropped
  kConstraint,  ///< a slot or field of a condition, or a part of it, is dropped
  kNegation,    ///< a condition, constraint or test is turned into its opposite by `not`, `~`, or without them
  kConnective,  ///< `and` and `or` change places
  kComparison,  ///< a comparison becomes its opposite, or moves its bound
  kArithmetic,  ///< `+` and `-`, `*` and `/`, `min` and `max` change places
  kNumber,      ///< 1 more; from 10 on, and with a decimal point, twice as much; 0.0 becomes 1.0
  kSymbol,      ///< another symbol or text, one of the same slot where one is known
  kAction,      ///< an action, or a fact of it, is dropped
  kSlot,        ///< a slot of an action is not set
  kSalience,    ///< turned round: the rule comes after those that it came before
};
const char* to_string(Change change);

struct RuleText {
  std::string name;  ///< of the file, the same on every machine
  std::string text;
  bool changed = true;  ///< else it only shows which templates and symbols there are
};

struct Mutant {
  std::string id;  ///< 8 hex digits of what is changed: the same where other parts of the file have changed
  Change change{};
  std::size_t file = 0;   ///< index of its `RuleText`
  std::string kind;       ///< "defrule", "deffunction", "defglobal"
  std::string construct;  ///< its name
  int line = 0;           ///< of the change
  int defined = 0;        ///< line of the construct
  /// These bytes of the file are replaced by `text`.
  std::size_t begin = 0, end = 0;
  std::string text;
  std::string before, after;  ///< the change in one line each; `after` is empty where all of `before` is dropped
  bool acts = false;          ///< an action of a rule: nothing is otherwise where the rule does not fire

  /// `(>= ?now ?at) -> (< ?now ?at)`, `without (held-up)`.
  std::string what() const;
};

/// All mutants, by file and place. A comment `; mutate: skip` spares what begins on its line, or on the next one if it
/// stands alone; on the first line of a construct the whole construct, and of a function all calls, too. What only
/// prints is not changed.
std::vector<Mutant> mutants_of(const std::vector<RuleText>& files);

/// The text of the file with the change.
std::string mutated(const std::string& text, const Mutant& mutant);
/// The change as a unified diff of the file.
std::string diff_of(const RuleText& file, const Mutant& mutant);

/// Rules that are or call what a mutant changes, by name without module, also through other functions and globals.
std::vector<std::string> rules_that_use(const std::vector<RuleText>& files, const Mutant& mutant);

}  // namespace cxlab::lab
