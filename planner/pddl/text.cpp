#include "planner/pddl/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cx/base/number_text.h"

namespace cxlab::planner {

std::string ground_text(const std::string& name, std::span<const ObjectId> arguments, const ById<Object>& objects) {
  return list_text(name, arguments, [&](ObjectId object) { return objects[object].name; });
}

std::string types_text(const Domain& domain, const std::vector<TypeId>& types) {
  if (types.size() == 1) return domain.types[types[0]].name;
  return list_text("either", types, [&](TypeId type) { return domain.types[type].name; });
}

std::string number_text(double number) {
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed);
  if (code == std::errc{}) return {buffer, end};
  return shortest_text(number);
}

std::string time_text(double seconds) {
  if (!(std::abs(seconds) < 1e7)) return number_text(seconds);
  std::string text = fixed_text(seconds, 9);
  while (text.back() == '0' && text[text.size() - 4] != '.') text.pop_back();
  return text == "-0.000" ? "0.000" : text;
}

void Printer::name_variables(const std::vector<Variable>& parameters) {
  for (const Variable& variable : parameters) {
    if (static_cast<int>(names_.size()) <= variable.slot) names_.resize(static_cast<std::size_t>(variable.slot) + 1);
    // A variable may hide an outer one in the file; flattened, both stand side by side.
    std::string name = variable.name;
    for (int copy = 2; std::find(names_.begin(), names_.end(), name) != names_.end(); ++copy)
      name = variable.name + "-" + std::to_string(copy);
    names_[variable.slot] = name;
  }
}

void Printer::name_objects(std::span<const ObjectId> objects) {
  names_.clear();
  for (const ObjectId object : objects) names_.push_back((*objects_)[object].name);
}

std::string Printer::term(const Term& term) const {
  if (!term.is_variable) return (*objects_)[term.index].name;
  return term.index < static_cast<int>(names_.size()) ? names_[term.index] : "?" + std::to_string(term.index);
}

std::string Printer::terms(const std::string& name, const std::vector<Term>& terms) const {
  return list_text(name, terms, [&](const Term& item) { return term(item); });
}

std::string Printer::variables(const std::vector<Variable>& variables) const {
  std::string text;
  for (const Variable& variable : variables) {
    const bool named = variable.slot < static_cast<int>(names_.size()) && !names_[variable.slot].empty();
    text += (text.empty() ? "" : " ") + (named ? names_[variable.slot] : variable.name) + " - " +
            types_text(*domain_, variable.types);
  }
  return text;
}

std::string Printer::expression(const Expression& expression) const {
  using Kind = Expression::Kind;
  if (expression.kind == Kind::kConstant) return number_text(expression.value);
  if (expression.kind == Kind::kFunction) return terms(domain_->functions[expression.function].name, expression.terms);
  if (expression.kind == Kind::kDuration) return "?duration";
  if (expression.kind == Kind::kTotalTime) return "(total-time)";
  return list_text(text_of(kExpressionWords, expression.kind), expression.operands,
                   [&](const Expression& operand) { return this->expression(operand); });
}

std::string Printer::condition(const Condition& condition) const {
  using Kind = Condition::Kind;
  if (condition.kind == Kind::kAtom) return terms(domain_->predicates[condition.predicate].name, condition.terms);
  if (condition.kind == Kind::kSame) return terms("=", condition.terms);
  if (condition.kind == Kind::kCompare)
    return list_text(text_of(kComparisonWords, condition.comparison), condition.sides,
                     [&](const Expression& side) { return expression(side); });
  std::string head = text_of(kConditionWords, condition.kind);
  Printer inside = *this;
  if (condition.kind == Kind::kForall || condition.kind == Kind::kExists) {
    inside.name_variables(condition.variables);
    head += " (" + inside.variables(condition.variables) + ")";
  }
  return list_text(head, condition.operands, [&](const Condition& operand) { return inside.condition(operand); });
}

std::string Printer::effect(const Effect& effect) const {
  if (!effect.is_numeric()) {
    const std::string atom = terms(domain_->predicates[effect.predicate].name, effect.terms);
    return effect.kind == Effect::Kind::kDelete ? "(not " + atom + ")" : atom;
  }
  std::string value = expression(effect.value);
  if (effect.time == Effect::Time::kContinuous) value = "(* #t " + value + ")";
  return "(" + text_of(kEffectWords, effect.kind) + " " +
         terms(domain_->functions[effect.function].name, effect.terms) + " " + value + ")";
}

}  // namespace cxlab::planner
