#include "planner/pddl/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace cxlab::planner {
namespace {

const char* comparison_text(Comparison comparison) {
  switch (comparison) {
    case Comparison::kLess: return "<";
    case Comparison::kLessEqual: return "<=";
    case Comparison::kEqual: return "=";
    case Comparison::kGreaterEqual: return ">=";
    case Comparison::kGreater: return ">";
  }
  return "=";
}

const char* effect_verb(Effect::Kind kind) {
  switch (kind) {
    case Effect::Kind::kAssign: return "assign";
    case Effect::Kind::kIncrease: return "increase";
    case Effect::Kind::kDecrease: return "decrease";
    case Effect::Kind::kScaleUp: return "scale-up";
    case Effect::Kind::kScaleDown: return "scale-down";
    default: return "";
  }
}

}  // namespace

std::string types_text(const Domain& domain, const std::vector<TypeId>& types) {
  if (types.size() == 1) return domain.types[types[0]].name;
  std::string text = "(either";
  for (const TypeId type : types) text += " " + domain.types[type].name;
  return text + ")";
}

std::string number_text(double number) {
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed);
  if (code == std::errc{}) return {buffer, end};
  const auto [longer_end, _] = std::to_chars(buffer, buffer + sizeof buffer, number);
  return {buffer, longer_end};
}

std::string time_text(double seconds) {
  if (!(std::abs(seconds) < 1e7)) return number_text(seconds);
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.9f", seconds);
  std::string text = buffer;
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

Printer Printer::inside(const std::vector<Variable>& variables) const {
  Printer printer = *this;
  printer.name_variables(variables);
  return printer;
}

std::string Printer::term(const Term& term) const {
  if (!term.is_variable) return (*objects_)[term.index].name;
  return term.index < static_cast<int>(names_.size()) ? names_[term.index] : "?" + std::to_string(term.index);
}

std::string Printer::terms(const std::string& name, const std::vector<Term>& terms) const {
  std::string text = "(" + name;
  for (const Term& item : terms) text += " " + term(item);
  return text + ")";
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

std::string Printer::fact(PredicateId predicate, std::span<const ObjectId> objects) const {
  std::string text = "(" + domain_->predicates[predicate].name;
  for (const ObjectId object : objects) text += " " + (*objects_)[object].name;
  return text + ")";
}

std::string Printer::function(FunctionId function, std::span<const ObjectId> objects) const {
  std::string text = "(" + domain_->functions[function].name;
  for (const ObjectId object : objects) text += " " + (*objects_)[object].name;
  return text + ")";
}

std::string Printer::expression(const Expression& expression) const {
  using Kind = Expression::Kind;
  const char* verb = "";
  switch (expression.kind) {
    case Kind::kConstant: return number_text(expression.value);
    case Kind::kFunction: return terms(domain_->functions[expression.function].name, expression.terms);
    case Kind::kDuration: return "?duration";
    case Kind::kTotalTime: return "(total-time)";
    case Kind::kAdd: verb = "+"; break;
    case Kind::kSubtract:
    case Kind::kNegate: verb = "-"; break;
    case Kind::kMultiply: verb = "*"; break;
    case Kind::kDivide: verb = "/"; break;
  }
  std::string text = std::string("(") + verb;
  for (const Expression& operand : expression.operands) text += " " + this->expression(operand);
  return text + ")";
}

std::string Printer::condition(const Condition& condition) const {
  using Kind = Condition::Kind;
  const char* verb = "";
  switch (condition.kind) {
    case Kind::kAtom: return terms(domain_->predicates[condition.predicate].name, condition.terms);
    case Kind::kSame: return terms("=", condition.terms);
    case Kind::kCompare:
      return std::string("(") + comparison_text(condition.comparison) + " " + expression(condition.sides[0]) + " " +
             expression(condition.sides[1]) + ")";
    case Kind::kForall:
    case Kind::kExists:
      return std::string(condition.kind == Kind::kForall ? "(forall (" : "(exists (") +
             inside(condition.variables).variables(condition.variables) + ") " +
             inside(condition.variables).condition(condition.operands[0]) + ")";
    case Kind::kNot: verb = "not"; break;
    case Kind::kAnd: verb = "and"; break;
    case Kind::kOr: verb = "or"; break;
    case Kind::kImply: verb = "imply"; break;
  }
  std::string text = std::string("(") + verb;
  for (const Condition& operand : condition.operands) text += " " + this->condition(operand);
  return text + ")";
}

std::string Printer::effect(const Effect& effect) const {
  const Printer& printer = *this;
  std::string text;
  if (effect.kind == Effect::Kind::kAdd || effect.kind == Effect::Kind::kDelete) {
    text = printer.terms(domain_->predicates[effect.predicate].name, effect.terms);
    if (effect.kind == Effect::Kind::kDelete) text = "(not " + text + ")";
    return text;
  }
  std::string value = printer.expression(effect.value);
  if (effect.time == Effect::Time::kContinuous) value = "(* #t " + value + ")";
  return std::string("(") + effect_verb(effect.kind) + " " +
         printer.terms(domain_->functions[effect.function].name, effect.terms) + " " + value + ")";
}

}  // namespace cxlab::planner
