#include "cx/explain/evaluator.h"

#include <algorithm>

namespace cxlab::explain {

namespace {

void collect(const Term& term, std::vector<std::string>& names) {
  for (const Term& item : term.items) collect(item, names);
  if (term.kind != Token::Kind::kWord) return;
  const std::size_t mark = term.text.find('?');
  if (mark > 1 || (mark == 1 && term.text[0] != '$')) return;
  const std::string name = term.text.substr(mark + 1);
  if (name.empty() || name[0] == '*') return;
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

std::vector<std::string> variables_of(const Term& expression) {
  std::vector<std::string> names;
  collect(expression, names);
  return names;
}

Evaluator::~Evaluator() {
  for (const auto& [text, function] : functions_)
    if (function.made) (void)engine_.undefine("deffunction", function.name);
}

const Evaluator::Function& Evaluator::function_of(const Term& expression) {
  std::string text = expression.print();
  if (const auto known = functions_.find(text); known != functions_.end()) return known->second;
  Function function{module_ + "::explain-" + std::to_string(functions_.size()), variables_of(expression), {}};
  std::string parameters;
  for (const std::string& variable : function.variables) parameters += (parameters.empty() ? "?" : " ?") + variable;
  function.made = engine_.build("(deffunction " + function.name + " (" + parameters + ") " + text + ")");
  return functions_.emplace(std::move(text), std::move(function)).first->second;
}

Expected<Value> Evaluator::value(const Term& expression, const Bindings& bindings) {
  const Function& function = function_of(expression);
  if (!function.made) return function.made.error();
  std::vector<Value> arguments;
  for (const std::string& variable : function.variables) {
    const Value* value = bindings.find(variable);
    if (!value) return input_error("?" + variable + " has no value");
    arguments.push_back(*value);
  }
  auto result = engine_.call(function.name, arguments);
  engine_.take_errors();  // reported here, not by the next run
  return result;
}

}  // namespace cxlab::explain
