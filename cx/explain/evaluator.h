#pragma once
// The variables of a left-hand side and its expressions, `(> ?x ?y)`, evaluated in the environment of its rule.

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"

namespace cxlab::explain {

/// Values that a person wants variables to have: `5` is the number, `R1` the symbol, string or instance `R1`, `f-3` the
/// fact. By name, without `?` and `$`.
using Wanted = std::map<std::string, std::string, std::less<>>;
bool is_wanted(const Value& value, const std::string& text);

/// Values of variables. In the order in which they were bound; names are without `?` and `$`.
class Bindings {
 public:
  Bindings() = default;
  /// Takes no other values than those that are wanted, which outlive this.
  explicit Bindings(const Wanted* wanted) : wanted_(wanted) {}

  const Value* find(std::string_view name) const {
    for (const auto& [known, value] : values_)
      if (known == name) return &value;
    return nullptr;
  }
  /// False, and nothing is bound, if another value is wanted.
  bool bind(const std::string& name, Value value);
  /// The value that the variable has or is to have, for a person; empty if it may have any.
  std::string print(const std::string& name) const;
  /// What a `not` binds inside is its own.
  void want_nothing() { wanted_ = nullptr; }
  std::size_t size() const { return values_.size(); }
  /// Forgets those that were bound since there were so many.
  void forget_beyond(std::size_t size) { values_.resize(size); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  std::vector<std::pair<std::string, Value>> values_;
  const Wanted* wanted_ = nullptr;
};

class Evaluator {
 public:
  /// `module`: of the rule. The engine outlives this.
  Evaluator(RuleEngine& engine, std::string module)
      : engine_(engine), module_(std::move(module)), chance_(engine.random()) {}
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  /// `name`: with its stars.
  Expected<Value> global(const std::string& name) { return value(Term{Token::Kind::kWord, '?' + name, {}, 0}, {}); }
  /// The expression's value; an error where CLIPS raises one, or a variable has no value.
  Expected<Value> value(const Term& expression, const Bindings& bindings);

 private:
  /// Each expression is a deffunction of its variables, so that handles and multifields reach it as they are.
  struct Function {
    std::string name;
    std::vector<std::string> variables;
    Status made;
  };
  const Function& function_of(const Term& expression);

  RuleEngine& engine_;
  std::string module_;
  RandomStream chance_;                        // as it was: who looks draws nothing from the rules
  std::map<std::string, Function> functions_;  // by the expression's text
};

/// Names of the variables that an expression takes from patterns, each once, without `?` and `$`: no globals, none that
/// a query or a loop inside binds.
std::vector<std::string> variables_of(const Term& expression);
/// `*limit*` for `?*limit*`, each once.
std::vector<std::string> globals_of(const Term& expression);

}  // namespace cxlab::explain
