#include "planner/manager/condition_text.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

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

class ConditionWriter {
 public:
  ConditionWriter(const Domain& domain, const std::vector<Object>& objects, std::span<const ObjectId> bound)
      : domain_(domain), objects_(objects) {
    for (const ObjectId object : bound) names_.push_back(objects[static_cast<std::size_t>(object)].name);
  }

  std::string text(const Condition& c) {
    using Kind = Condition::Kind;
    switch (c.kind) {
      case Kind::kAtom: return call(domain_.predicates[static_cast<std::size_t>(c.predicate)].name, c.terms);
      case Kind::kSame: return "(" + term(c.terms[0]) + " == " + term(c.terms[1]) + ")";
      case Kind::kCompare: return comparison(c);
      case Kind::kNot:
        return c.operands[0].kind == Kind::kNot ? text(c.operands[0].operands[0]) : "(not " + text(c.operands[0]) + ")";
      case Kind::kAnd: return joined(c, " and ", "true");
      case Kind::kOr: return joined(c, " or ", "false");
      case Kind::kImply: return "(" + text(c.operands[0]) + " implies " + text(c.operands[1]) + ")";
      case Kind::kForall:
      case Kind::kExists: {
        const std::string variables = declared(c.variables);  // before they are read
        return (c.kind == Kind::kForall ? "Forall (" : "Exists (") + variables + ") " + text(c.operands[0]);
      }
    }
    return {};
  }

 private:
  std::string term(const Term& t) const {
    return t.is_variable ? names_[static_cast<std::size_t>(t.index)] : objects_[static_cast<std::size_t>(t.index)].name;
  }

  std::string call(const std::string& name, const std::vector<Term>& terms) const {
    if (terms.empty()) return name;
    std::string text = name + "(";
    for (std::size_t i = 0; i < terms.size(); ++i) text += (i > 0 ? ", " : "") + term(terms[i]);
    return text + ")";
  }

  std::string joined(const Condition& c, const char* word, const char* none) {
    if (c.operands.empty()) return none;
    std::string text = "(";
    for (std::size_t i = 0; i < c.operands.size(); ++i) text += (i > 0 ? word : "") + this->text(c.operands[i]);
    return text + ")";
  }

  /// Greater is written as less, sides exchanged.
  std::string comparison(const Condition& c) const {
    const std::string left = expression(c.sides[0]), right = expression(c.sides[1]);
    switch (c.comparison) {
      case Comparison::kLess: return "(" + left + " < " + right + ")";
      case Comparison::kLessEqual: return "(" + left + " <= " + right + ")";
      case Comparison::kEqual: return "(" + left + " == " + right + ")";
      case Comparison::kGreaterEqual: return "(" + right + " <= " + left + ")";
      case Comparison::kGreater: return "(" + right + " < " + left + ")";
    }
    return {};
  }

  std::string expression(const Expression& e) const {
    using Kind = Expression::Kind;
    const char* sign = "";
    switch (e.kind) {
      case Kind::kConstant: return fraction(e.value);
      case Kind::kFunction: return call(domain_.functions[static_cast<std::size_t>(e.function)].name, e.terms);
      case Kind::kDuration: return "duration";
      case Kind::kTotalTime: return "total-time";
      case Kind::kNegate: return "(-1 * " + expression(e.operands[0]) + ")";
      case Kind::kAdd: sign = " + "; break;
      case Kind::kSubtract: sign = " - "; break;
      case Kind::kMultiply: sign = " * "; break;
      case Kind::kDivide: sign = " / "; break;
    }
    std::string text = "(";
    for (std::size_t i = 0; i < e.operands.size(); ++i) text += (i > 0 ? sign : "") + expression(e.operands[i]);
    return text + ")";
  }

  std::string declared(const std::vector<Variable>& variables) {
    std::string text;
    for (const Variable& variable : variables) {
      const auto slot = static_cast<std::size_t>(variable.slot);
      if (names_.size() <= slot) names_.resize(slot + 1);
      names_[slot] = variable.name.substr(1);
      text += (text.empty() ? "" : ", ") + type(variable.types) + ' ' + names_[slot];
    }
    return text;
  }

  std::string type(const std::vector<TypeId>& types) const {
    if (types.size() == 1) {
      const Type& type = domain_.types[static_cast<std::size_t>(types[0])];
      const bool written = !type.parents.empty() && (type.parents[0] != Domain::kObjectType || object_is_a_type());
      return type.name + (written ? " - " + domain_.types[static_cast<std::size_t>(type.parents[0])].name : "");
    }
    std::string text = "(either";
    for (const TypeId t : types) text += ' ' + domain_.types[static_cast<std::size_t>(t)].name;
    return text + ")";
  }

  /// Whether something may be any object; only then `object` is written as a supertype.
  bool object_is_a_type() const {
    const auto any = [](const auto& item) {
      return std::any_of(item.parameters.begin(), item.parameters.end(),
                         [](const Variable& v) { return v.types == std::vector{Domain::kObjectType}; });
    };
    return std::any_of(domain_.predicates.begin(), domain_.predicates.end(), any) ||
           std::any_of(domain_.functions.begin(), domain_.functions.end(), any) ||
           std::any_of(domain_.actions.begin(), domain_.actions.end(), any);
  }

  const Domain& domain_;
  const std::vector<Object>& objects_;
  std::vector<std::string> names_;  // by slot
};

}  // namespace

std::string framework_text(const Condition& condition, const Domain& domain, const std::vector<Object>& objects,
                           std::span<const ObjectId> bound) {
  return ConditionWriter(domain, objects, bound).text(condition);
}

}  // namespace cxlab::planner
