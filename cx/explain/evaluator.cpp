#include "cx/explain/evaluator.h"

#include <algorithm>

#include "cx/base/number_text.h"

namespace cxlab::explain {

namespace {

/// `x` of `?x` and `$?x`; empty for anything else and for globals.
std::string variable_of(const Term& term) {
  if (term.kind != Token::Kind::kWord) return {};
  const std::size_t mark = term.text.starts_with("$?") ? 2 : term.text.starts_with('?') ? 1 : 0;
  return mark == 0 || term.text.substr(mark).starts_with('*') ? std::string() : term.text.substr(mark);
}

using Names = std::vector<std::string>;

/// The variables that a call binds itself: `(any-factp ((?f part)) ...)`, `(progn$ (?x ...) ...)`, `(foreach ?x ...)`,
/// `(bind ?x ...)`.
void add_own(const Term& call, Names& names) {
  if (call.items.size() < 2) return;
  const Term& first = call.items[1];
  if (call.head() == "foreach" || call.head() == "bind") names.push_back(variable_of(first));
  if (!first.is_list() || first.items.empty()) return;
  if (!first.items[0].is_list()) names.push_back(variable_of(first.items[0]));
  for (const Term& member : first.items)
    if (member.is_list() && !member.items.empty()) names.push_back(variable_of(member.items[0]));
}

void collect(const Term& term, Names own, Names& names) {
  if (term.is_list()) {
    add_own(term, own);
    for (const Term& item : term.items) collect(item, own, names);
    return;
  }
  const std::string name = variable_of(term);
  const auto is_own = [&](const std::string& bound) {
    return !bound.empty() && (name == bound || name == bound + "-index" || name.starts_with(bound + ':'));
  };
  if (name.empty() || std::any_of(own.begin(), own.end(), is_own)) return;
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

bool is_wanted(const Value& value, const std::string& text) {
  if (value.print() == text || (value.is_text() && value.text() == text)) return true;
  if (value.is(ValueType::kFact)) return text == "f-" + std::to_string(value.fact_index());
  const auto number = read_number<double>(text);
  return number && value.is_number() && value.as_number() == *number;
}

bool Bindings::bind(const std::string& name, Value value) {
  if (wanted_)
    if (const auto wanted = wanted_->find(name); wanted != wanted_->end() && !is_wanted(value, wanted->second))
      return false;
  values_.emplace_back(name, std::move(value));
  return true;
}

std::string Bindings::print(const std::string& name) const {
  if (const Value* value = find(name)) return value->print();
  if (!wanted_) return {};
  const auto wanted = wanted_->find(name);
  return wanted == wanted_->end() ? std::string() : wanted->second;
}

std::vector<std::string> variables_of(const Term& expression) {
  Names names;
  collect(expression, {}, names);
  return names;
}

std::vector<std::string> globals_of(const Term& expression) {
  Names names;
  if (expression.kind == Token::Kind::kWord && expression.text.starts_with("?*"))
    names.push_back(expression.text.substr(1));
  for (const Term& item : expression.items)
    for (std::string& name : globals_of(item))
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
  return names;
}

Evaluator::~Evaluator() {
  engine_.random() = chance_;
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
