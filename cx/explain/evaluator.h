#pragma once
// Evaluates the expressions of a left-hand side, `(> ?x ?y)`, in the environment of its rule.

#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/bindings.h"

namespace cxlab::explain {

class Evaluator {
 public:
  /// `module`: of the rule. The engine outlives this.
  Evaluator(RuleEngine& engine, std::string module) : engine_(engine), module_(std::move(module)) {}
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

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
  std::map<std::string, Function> functions_;  // by the expression's text
};

/// Names of the variables of an expression, each once, without `?` and `$`; globals are none.
std::vector<std::string> variables_of(const Term& expression);

}  // namespace cxlab::explain
