#pragma once
// A pattern of facts: of a rule's left-hand side, `(job (id ?i) (state OPEN|LATE) (size ?s&:(> ?s 3)))`, or of a story.

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/evaluator.h"

namespace cxlab::explain {

/// What one value of a slot, or with `$?` any number of them, must be.
struct Constraint {
  struct Single {
    enum class Kind { kAny, kConstant, kVariable, kPredicate, kReturnValue };
    Kind kind = Kind::kAny;
    bool negated = false;
    Value constant;
    std::string variable;
    Term expression;
    std::vector<std::string> uses;  ///< variables of the expression
  };
  bool many = false;
  std::string variable;                     ///< that the value is bound to, or equals; may be empty
  std::vector<std::vector<Single>> any_of;  ///< alternatives of what must hold together; none = no more than that
};

/// How a fact fails a pattern.
struct Mismatch {
  std::string slot;  ///< "implied" for an ordered fact
  std::string found, expected;
  bool has_slot = true;
  /// `state is OPEN, not DONE`
  std::string print() const;
};
/// `state is OPEN, not DONE, and id is 3, not 5`
std::string print(const std::vector<Mismatch>& mismatches);

class Pattern {
 public:
  /// Reads a term `(template ...)`; errors have its line.
  static Expected<Pattern> parse(const Term& term, const std::string& file = {});
  /// Reads a pattern of a story: constants, `?` and `$?` only; numbers are equal when their values are (1 and 1.0).
  static Expected<Pattern> parse_plain(const std::string& text, const std::string& file, int line);

  const std::string& template_name() const { return template_name_; }  ///< without its module
  const std::string& module() const { return module_; }                ///< empty where none is written
  /// Whether it stands for instances of classes instead of facts.
  bool is_object() const { return template_name_ == "object"; }
  /// Variables that a match binds, each once.
  std::vector<std::string> binds() const;
  /// Empty for an ordered fact.
  std::vector<std::string> slot_names() const;
  /// How many values, variables and `?` are written in that slot, which the pattern has.
  std::size_t count_in(const std::string& slot) const;
  /// The values that are written in the pattern, with their slots ("implied" for an ordered fact), but those of `~`.
  std::vector<std::pair<std::string, Value>> constants() const;

  /// Calls `found` for each way in which the fact matches, with the new bindings, until it returns true. Returns
  /// whether it did. The bindings are as before afterwards. Expressions hold without an evaluator, or where one of
  /// their variables has no value.
  bool match(const FactCopy& fact, Bindings& bindings, Evaluator* evaluator, const std::function<bool()>& found) const;
  bool matches(const FactCopy& fact, Evaluator* evaluator = nullptr) const;
  /// The slots that do not match, each looked at on its own after those before it.
  std::vector<Mismatch> mismatches(const FactCopy& fact, const Bindings& bindings = {},
                                   Evaluator* evaluator = nullptr) const;

 private:
  struct Slot {
    std::string name;
    std::vector<Constraint> constraints;
    std::string text;
  };
  class Matching;

  std::string module_, template_name_;
  std::vector<Slot> slots_;
  std::vector<Constraint> ordered_;  // of an ordered pattern, or one without slots
  std::string ordered_text_;
  bool loose_numbers_ = false;
};

/// The fact that fails in the fewest slots. Among several, one with a word that may be misspelt comes first. Next comes
/// one that concerns the same thing as the other conditions: its state differs, not its owner. Else it is the last.
struct Nearest {
  const FactCopy* fact = nullptr;  ///< null: there is none of the template
  std::vector<Mismatch> mismatches;
};
Nearest nearest(const Pattern& pattern, std::span<const FactCopy* const> facts, const Bindings& bindings = {},
                Evaluator* evaluator = nullptr);

}  // namespace cxlab::explain
