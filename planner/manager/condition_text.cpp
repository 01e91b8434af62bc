// Conditions as agents of the PDDL manager read them.

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "planner/manager/instance.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

/// A number as a fraction in lowest terms where it is no integer: 2.5 = 5/2.
std::string fraction(double value) {
  const std::string text = number_text(value);
  const std::size_t point = text.find('.'), decimals = point == std::string::npos ? 0 : text.size() - point - 1;
  if (decimals == 0 || text.size() > 17 || text.find('e') != std::string::npos) return text;
  std::int64_t above = 0, below = 1;
  for (const char c : text)
    if (c >= '0' && c <= '9') above = 10 * above + (c - '0');
  for (std::size_t i = 0; i < decimals; ++i) below *= 10;
  const std::int64_t common = std::gcd(above, below);
  return (value < 0 ? "-" : "") + std::to_string(above / common) + "/" + std::to_string(below / common);
}

template <class Items, class Text>
std::string joined(const Items& items, const std::string& between, Text text) {
  std::string all;
  for (const auto& item : items) all += (&item == &items.front() ? "" : between) + text(item);
  return all;
}

class ConditionWriter {
 public:
  ConditionWriter(const Domain& domain, const ById<Object>& objects, std::span<const ObjectId> bound)
      : domain_(domain), objects_(objects) {
    for (const ObjectId object : bound) names_.push_back(objects[object].name);
  }

  std::string text(const Condition& c) {
    using Kind = Condition::Kind;
    const auto operands = [&](const char* word) {
      return "(" + joined(c.operands, word, [&](const Condition& each) { return text(each); }) + ")";
    };
    switch (c.kind) {
      case Kind::kAtom: return call(domain_.predicates[c.predicate].name, c.terms);
      case Kind::kSame: return "(" + term(c.terms[0]) + " == " + term(c.terms[1]) + ")";
      case Kind::kCompare: return comparison(c);
      case Kind::kNot:
        return c.operands[0].kind == Kind::kNot ? text(c.operands[0].operands[0]) : "(not " + text(c.operands[0]) + ")";
      case Kind::kAnd: return c.operands.empty() ? "true" : operands(" and ");
      case Kind::kOr: return c.operands.empty() ? "false" : operands(" or ");
      case Kind::kImply: return operands(" implies ");
      case Kind::kForall:
      case Kind::kExists: {
        const std::string variables = declared(c.variables);  // before they are read
        return (c.kind == Kind::kForall ? "Forall (" : "Exists (") + variables + ") " + text(c.operands[0]);
      }
    }
    return {};
  }

 private:
  const std::string& term(const Term& t) const { return t.is_variable ? names_[t.index] : objects_[t.index].name; }

  std::string call(const std::string& name, const std::vector<Term>& terms) const {
    if (terms.empty()) return name;
    return name + "(" + joined(terms, ", ", [&](const Term& each) { return term(each); }) + ")";
  }

  /// Greater is written as less, sides exchanged.
  std::string comparison(const Condition& c) const {
    const bool exchanged = c.comparison == Comparison::kGreaterEqual || c.comparison == Comparison::kGreater;
    const std::string left = expression(c.sides[exchanged ? 1 : 0]), right = expression(c.sides[exchanged ? 0 : 1]);
    const bool less = c.comparison == Comparison::kLess || c.comparison == Comparison::kGreater;
    return "(" + left + (c.comparison == Comparison::kEqual ? " == " : less ? " < " : " <= ") + right + ")";
  }

  std::string expression(const Expression& e) const {
    using Kind = Expression::Kind;
    if (e.kind == Kind::kConstant) return fraction(e.value);
    if (e.kind == Kind::kFunction) return call(domain_.functions[e.function].name, e.terms);
    if (e.kind == Kind::kDuration) return "duration";
    if (e.kind == Kind::kTotalTime) return "total-time";
    if (e.kind == Kind::kNegate) return "(-1 * " + expression(e.operands[0]) + ")";
    const auto operand = [&](const Expression& each) { return expression(each); };
    return "(" + joined(e.operands, " " + text_of(kExpressionWords, e.kind) + " ", operand) + ")";
  }

  std::string declared(const std::vector<Variable>& variables) {
    return joined(variables, ", ", [&](const Variable& variable) {
      if (static_cast<int>(names_.size()) <= variable.slot) names_.resize(static_cast<std::size_t>(variable.slot) + 1);
      names_[variable.slot] = variable.name.substr(1);
      return type(variable.types) + ' ' + names_[variable.slot];
    });
  }

  std::string type(const std::vector<TypeId>& types) const {
    if (types.size() > 1) return types_text(domain_, types);
    const Type& type = domain_.types[types[0]];
    const bool written = !type.parents.empty() && (type.parents[0] != Domain::kObjectType || object_is_a_type());
    return type.name + (written ? " - " + domain_.types[type.parents[0]].name : "");
  }

  /// Whether something may be any object; only then `object` is written as a supertype.
  bool object_is_a_type() const {
    const auto any = [](const auto& item) {
      return std::ranges::find(item.parameters, std::vector{Domain::kObjectType}, &Variable::types) !=
             item.parameters.end();
    };
    return std::ranges::any_of(domain_.predicates, any) || std::ranges::any_of(domain_.functions, any) ||
           std::ranges::any_of(domain_.actions, any);
  }

  const Domain& domain_;
  const ById<Object>& objects_;
  ById<std::string> names_;  // by slot
};

}  // namespace

std::string framework_text(const Condition& condition, const Domain& domain, const ById<Object>& objects,
                           std::span<const ObjectId> bound) {
  return ConditionWriter(domain, objects, bound).text(condition);
}

}  // namespace cxlab::planner
