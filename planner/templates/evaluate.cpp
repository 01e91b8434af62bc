// Expressions.

#include <algorithm>
#include <cmath>

#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {
namespace {

constexpr int kDeepestRun = 1000;

std::optional<std::int64_t> whole_power(std::int64_t base, std::int64_t exponent) {
  std::int64_t result = 1;
  while (exponent > 0) {
    if ((exponent & 1) != 0 && __builtin_mul_overflow(result, base, &result)) return std::nullopt;
    exponent >>= 1;
    if (exponent > 0 && __builtin_mul_overflow(base, base, &base)) return std::nullopt;
  }
  return result;
}

/// Python's x // y: of what is left without the rest, for x / y may round up to a whole number.
double floor_quotient(double x, double y) {
  const double rest = std::fmod(x, y);
  const double quotient = (x - rest) / y - (rest != 0 && (y < 0) != (rest < 0) ? 1 : 0);
  if (quotient == 0) return std::copysign(0.0, x / y);
  return std::floor(quotient) + (quotient - std::floor(quotient) > 0.5 ? 1 : 0);
}

}  // namespace

bool Interpreter::require(const Value& value) {
  if (failed()) return false;
  if (!value.is_undefined()) return true;
  const std::string& name = value.undefined_name();
  fail(name.find(' ') == std::string::npos ? "'" + name + "' is undefined" : name);
  return false;
}

const Value* Interpreter::find_variable(const std::string& name, Scope& scope) {
  bool inside = true;  // of the template or block that runs
  for (Scope* level = &scope; level != nullptr; level = level->outer.get()) {
    if (const Value* found = level->find(name)) return found;
    if (level->of_rendering) inside = false;
    if (inside && std::find(level->hidden.begin(), level->hidden.end(), name) != level->hidden.end()) return nullptr;
  }
  return nullptr;
}

Value Interpreter::look_up(const std::string& name, Rendering& rendering, const ScopePtr& scope) {
  if (const Value* found = find_variable(name, *scope)) return *found;
  return name == "self" ? self_of(rendering, scope) : Value::undefined(name);
}

Value Interpreter::evaluate(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  using Kind = Expression::Kind;
  if (failed() || !spend(1)) return {};
  line_ = expression.line;
  const struct Depth {
    explicit Depth(int& depth) : depth(++depth) {}
    ~Depth() { --depth; }
    int& depth;
  } level(depth_);
  if (depth_ > kDeepestRun)
    return fail("templates, macros and expressions are nested more than " + std::to_string(kDeepestRun) + " deep");
  const auto operand = [&](std::size_t i) { return evaluate(*expression.operands[i], rendering, scope); };
  switch (expression.kind) {
    case Kind::kLiteral: return expression.value;
    case Kind::kName: return look_up(expression.name, rendering, scope);
    case Kind::kList:
    case Kind::kTuple:
    case Kind::kDict:
    case Kind::kConcat: return evaluate_literal(expression, rendering, scope);
    case Kind::kNegate:
    case Kind::kPlus: return evaluate_sign(expression, rendering, scope);
    case Kind::kNot: return !operand(0).truth();
    case Kind::kAnd: {
      const Value left = operand(0);
      return left.truth() ? operand(1) : left;
    }
    case Kind::kOr: {
      const Value left = operand(0);
      return left.truth() ? left : operand(1);
    }
    case Kind::kBinary: {
      const Value left = operand(0);
      const Value right = operand(1);
      line_ = expression.line;
      return failed() ? Value{} : binary(expression.name, left, right);
    }
    case Kind::kCompare: return evaluate_compare(expression, rendering, scope);
    case Kind::kCondition:
      if (operand(1).truth()) return operand(0);
      return expression.operands[2] ? operand(2) : Value::undefined("the inline if-expression has no else part");
    case Kind::kAttribute: {
      const Value subject = operand(0);
      return failed() ? Value{} : attribute(subject, expression.name);
    }
    case Kind::kSubscript: {
      const Value subject = operand(0);
      if (failed()) return {};
      if (expression.operands[1]->kind == Kind::kSlice)
        return slice(subject, *expression.operands[1], rendering, scope);
      const Value index = operand(1);
      return failed() ? Value{} : item(subject, index);
    }
    case Kind::kSlice: return fail("found a slice outside of brackets");
    case Kind::kCall: return evaluate_call(expression, rendering, scope);
    case Kind::kFilter: {
      const Value subject = expression.operands[0] ? operand(0) : *filter_body_;
      const Call call = arguments(expression, rendering, scope);
      line_ = expression.line;
      return failed() ? Value{} : apply_filter(*this, expression.name, subject, call);
    }
    case Kind::kTest: {
      const Value subject = operand(0);
      const Call call = arguments(expression, rendering, scope);
      line_ = expression.line;
      return failed() ? Value{} : Value(apply_test(*this, expression.name, subject, call));
    }
  }
  return {};
}

Value Interpreter::evaluate_literal(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  std::vector<Value> values;
  for (const auto& operand : expression.operands) values.push_back(evaluate(*operand, rendering, scope));
  if (failed()) return {};
  switch (expression.kind) {
    case Expression::Kind::kList: return Value::list(std::move(values));
    case Expression::Kind::kTuple: return Value::tuple(std::move(values));
    case Expression::Kind::kDict: {
      Value dict = Value::dict();
      for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
        if (may_change(values[i]))
          return fail("found " + values[i].repr() + " as key of a dict, expected what cannot change: no list or dict");
        templates::assign(*dict.as_dict(), values[i], values[i + 1]);
      }
      return dict;
    }
    default: {
      std::string text;
      for (const Value& value : values) text += value.str();
      return spend(1, text.size()) ? Value(std::move(text)) : Value{};
    }
  }
}

Value Interpreter::evaluate_sign(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  const Value value = evaluate(*expression.operands[0], rendering, scope);
  if (!require(value)) return {};
  const bool negative = expression.kind == Expression::Kind::kNegate;
  if (!value.is_number())
    return fail(std::string("bad operand type for unary ") + (negative ? "-" : "+") + ": '" + value.type_name() + "'");
  if (value.is_float()) return negative ? -value.as_float() : value.as_float();
  std::int64_t result = value.as_int();
  if (negative && __builtin_sub_overflow(std::int64_t{0}, result, &result)) return fail("the number is too large");
  return result;
}

Value Interpreter::evaluate_compare(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  Value left = evaluate(*expression.operands[0], rendering, scope);
  for (std::size_t i = 0; i < expression.names.size(); ++i) {
    Value right = evaluate(*expression.operands[i + 1], rendering, scope);
    if (failed() || !compare(expression.names[i], left, right)) return false;
    left = std::move(right);
  }
  return !failed();
}

bool Interpreter::compare(const std::string& operation, const Value& left, const Value& right) {
  if (operation == "==") return left.equals(right);
  if (operation == "!=") return !left.equals(right);
  if (operation == "in") return contains(right, left);
  if (operation == "not in") return !contains(right, left);
  if (!require(left) || !require(right)) return false;
  const auto order = left.order(right);
  if (!order) {
    fail("'" + operation + "' not supported between '" + left.type_name() + "' and '" + right.type_name() + "'");
    return false;
  }
  if (operation == "<") return *order < 0;
  if (operation == "<=") return *order <= 0;
  if (operation == ">") return *order > 0;
  return *order >= 0;
}

bool Interpreter::less(const Value& left, const Value& right) { return compare("<", left, right); }

bool Interpreter::contains(const Value& container, const Value& item) {
  if (container.is_string()) {
    if (!item.is_string()) {
      fail("'in <string>' requires a string, found " + std::string(item.type_name()));
      return false;
    }
    return container.as_string().find(item.as_string()) != std::string::npos;
  }
  if (DictData* dict = container.as_dict()) return find(*dict, item) != nullptr;
  const std::vector<Value> all = items(container);
  return std::any_of(all.begin(), all.end(), [&](const Value& each) { return each.equals(item); });
}

std::vector<Value> Interpreter::items(const Value& subject) {
  if (failed()) return {};
  std::vector<Value> out;
  if (const ListData* list = subject.as_list()) {
    out = list->items;
  } else if (const DictData* dict = subject.as_dict()) {
    for (const auto& [key, value] : dict->entries) out.push_back(key);
  } else if (subject.is_string()) {
    for (std::string& point : code_points(subject.as_string())) out.emplace_back(std::move(point));
  } else if (!subject.is_undefined()) {
    fail("'" + std::string(subject.type_name()) + "' object is not iterable");
  }
  spend(out.size());
  return out;
}

Value Interpreter::attribute(const Value& subject, const std::string& name) {
  if (!require(subject)) return {};
  if (ObjectData* object = subject.as_object()) {
    const Value* field = object->find(name);
    return field != nullptr ? *field : Value::undefined("'" + object->kind + "' has no attribute '" + name + "'");
  }
  if (const ListData* list = subject.as_list()) {
    const auto named = std::find(list->names.begin(), list->names.end(), name);
    if (named != list->names.end()) return list->items[static_cast<std::size_t>(named - list->names.begin())];
  }
  if (has_method(subject, name))
    return Value::function(
        name, [subject, name](Interpreter& self, const Call& call) { return call_method(self, subject, name, call); });
  if (DictData* dict = subject.as_dict())
    if (const Value* value = find(*dict, Value(name))) return *value;
  return Value::undefined("'" + std::string(subject.type_name()) + " object' has no attribute '" + name + "'");
}

Value Interpreter::item(const Value& subject, const Value& index) {
  if (!require(subject)) return {};
  const auto position = [&](std::size_t size) -> std::optional<std::size_t> {
    if (!index.is_whole()) return std::nullopt;
    std::int64_t at = index.as_int();
    if (at < 0) at += static_cast<std::int64_t>(size);
    if (at < 0 || at >= static_cast<std::int64_t>(size)) return std::nullopt;
    return static_cast<std::size_t>(at);
  };
  if (const ListData* list = subject.as_list()) {
    if (const auto at = position(list->items.size())) return list->items[*at];
  } else if (DictData* dict = subject.as_dict()) {
    if (const Value* value = find(*dict, index)) return *value;
  } else if (subject.is_string()) {
    auto points = code_points(subject.as_string());
    if (const auto at = position(points.size())) return std::move(points[*at]);
  }
  if (index.is_string()) return attribute(subject, index.as_string());
  return Value::undefined("'" + std::string(subject.type_name()) + " object' has no element " + index.repr());
}

Value Interpreter::slice(const Value& subject, const Expression& bounds, Rendering& rendering, const ScopePtr& scope) {
  if (!subject.is_string() && subject.as_list() == nullptr) {
    require(subject);
    return fail("'" + std::string(subject.type_name()) + "' object cannot be sliced");
  }
  const std::vector<Value> all = items(subject);
  const auto size = static_cast<std::int64_t>(all.size());
  std::optional<std::int64_t> given[3];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!bounds.operands[i]) continue;
    const Value bound = evaluate(*bounds.operands[i], rendering, scope);
    if (failed()) return {};
    if (bound.is_none()) continue;
    if (!bound.is_whole()) return fail("found " + bound.repr() + " in a slice, expected a whole number");
    given[i] = bound.as_int();
  }
  const std::int64_t step = given[2].value_or(1);
  if (step == 0) return fail("slice step cannot be zero");
  const auto place = [&](std::optional<std::int64_t> bound, std::int64_t otherwise) {
    if (!bound) return otherwise;
    const std::int64_t at = *bound < 0 ? *bound + size : *bound;
    return std::clamp<std::int64_t>(at, step < 0 ? -1 : 0, step < 0 ? size - 1 : size);
  };
  const std::int64_t first = place(given[0], step < 0 ? size - 1 : 0);
  const std::int64_t last = place(given[1], step < 0 ? -1 : size);
  std::vector<Value> picked;
  for (std::int64_t i = first; step < 0 ? i > last : i < last;) {
    picked.push_back(all[static_cast<std::size_t>(i)]);
    if (__builtin_add_overflow(i, step, &i)) break;
  }
  if (!subject.is_string())
    return subject.as_list()->tuple ? Value::tuple(std::move(picked)) : Value::list(std::move(picked));
  std::string text;
  for (const Value& point : picked) text += point.as_string();
  return text;
}

Call Interpreter::arguments(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  Call call;
  for (const auto& argument : expression.arguments) call.positional.push_back(evaluate(*argument, rendering, scope));
  if (expression.star)
    for (Value& value : items(evaluate(*expression.star, rendering, scope)))
      call.positional.push_back(std::move(value));
  for (const auto& [name, argument] : expression.named_arguments)
    call.named.emplace_back(name, evaluate(*argument, rendering, scope));
  if (expression.double_star) {
    const Value named = evaluate(*expression.double_star, rendering, scope);
    if (failed()) return call;
    if (named.as_dict() == nullptr) {
      fail("found " + named.repr() + " behind **, expected a dict");
      return call;
    }
    for (const auto& [key, value] : named.as_dict()->entries) call.named.emplace_back(key.str(), value);
  }
  return call;
}

Value Interpreter::evaluate_call(const Expression& expression, Rendering& rendering, const ScopePtr& scope) {
  const Expression& callee = *expression.operands[0];
  if (callee.kind == Expression::Kind::kAttribute) {
    const Value subject = evaluate(*callee.operands[0], rendering, scope);
    if (!require(subject)) return {};
    if (subject.as_object() == nullptr && has_method(subject, callee.name)) {
      const Call call = arguments(expression, rendering, scope);
      line_ = expression.line;
      return failed() ? Value{} : call_method(*this, subject, callee.name, call);
    }
    const Value function = attribute(subject, callee.name);
    const Call call = arguments(expression, rendering, scope);
    line_ = expression.line;
    return failed() ? Value{} : this->call(function, call);
  }
  const Value function = evaluate(callee, rendering, scope);
  const Call call = arguments(expression, rendering, scope);
  line_ = expression.line;
  return failed() ? Value{} : this->call(function, call);
}

Value Interpreter::call(const Value& callee, const Call& call) {
  if (!require(callee)) return {};
  if (const FunctionData* function = callee.as_function()) return function->call(*this, call);
  if (const ObjectData* object = callee.as_object(); object != nullptr && object->call) {
    const Function function = object->call;  // the object may change while it runs
    return function(*this, call);
  }
  return fail("'" + std::string(callee.type_name()) + "' object is not callable");
}

Value Interpreter::evaluate_filters(const Expression& expression, const Value& body, Rendering& rendering,
                                    const ScopePtr& scope) {
  const Value* before = filter_body_;
  filter_body_ = &body;
  Value result = evaluate(expression, rendering, scope);
  filter_body_ = before;
  return result;
}

Value Interpreter::binary(const std::string& operation, const Value& left, const Value& right) {
  if (!require(left) || !require(right)) return {};
  const char o = operation == "**" ? 'p' : operation == "//" ? 'd' : operation[0];
  if (o == '%' && left.is_string()) return format_percent(*this, left.as_string(), right);
  if (o == '+' && left.is_string() && right.is_string()) {
    if (!spend(1, left.as_string().size() + right.as_string().size())) return {};
    return left.as_string() + right.as_string();
  }
  const ListData *a = left.as_list(), *b = right.as_list();
  if (o == '+' && a != nullptr && b != nullptr && a->tuple == b->tuple) {
    std::vector<Value> joined = a->items;
    joined.insert(joined.end(), b->items.begin(), b->items.end());
    if (!spend(joined.size())) return {};
    return a->tuple ? Value::tuple(std::move(joined)) : Value::list(std::move(joined));
  }
  if (o == '*' && left.is_whole() && (right.is_string() || b != nullptr)) return binary(operation, right, left);
  if (o == '*' && right.is_whole() && (left.is_string() || a != nullptr)) {
    const auto times = static_cast<std::size_t>(std::max<std::int64_t>(0, right.as_int()));
    const std::size_t size = left.is_string() ? left.as_string().size() : a->items.size();
    if (size > 0 && times > limits_.output / size)
      return fail("the template makes more than " + std::to_string(limits_.output) + " bytes of text");
    if (!(left.is_string() ? spend(1, size * times) : spend(size * times))) return {};
    if (left.is_string()) {
      std::string text;
      text.reserve(size * times);
      for (std::size_t i = 0; i < times && size > 0; ++i) text += left.as_string();
      return text;
    }
    std::vector<Value> repeated;
    for (std::size_t i = 0; i < times && size > 0; ++i)
      repeated.insert(repeated.end(), a->items.begin(), a->items.end());
    return a->tuple ? Value::tuple(std::move(repeated)) : Value::list(std::move(repeated));
  }
  if (!left.is_number() || !right.is_number())
    return fail("unsupported operand types for " + operation + ": '" + left.type_name() + "' and '" +
                right.type_name() + "'");
  const bool divides = o == '/' || o == 'd' || o == '%';
  if (divides && right.as_float() == 0) return fail("division by zero");
  if (o == '/') return left.as_float() / right.as_float();
  if (left.is_whole() && right.is_whole()) {
    const std::int64_t x = left.as_int(), y = right.as_int();
    std::int64_t result = 0;
    bool fits = true;
    switch (o) {
      case '+': fits = !__builtin_add_overflow(x, y, &result); break;
      case '-': fits = !__builtin_sub_overflow(x, y, &result); break;
      case '*': fits = !__builtin_mul_overflow(x, y, &result); break;
      case 'd':
      case '%':
        if (y == -1) {  // the smallest number divided by -1 overflows
          fits = o == '%' || !__builtin_sub_overflow(std::int64_t{0}, x, &result);
        } else {
          const std::int64_t rest = x % y;
          const bool borrows = rest != 0 && (rest < 0) != (y < 0);
          result = o == 'd' ? x / y - (borrows ? 1 : 0) : rest + (borrows ? y : 0);
        }
        break;
      default: {
        if (y < 0) return std::pow(left.as_float(), right.as_float());
        const auto power = whole_power(x, y);
        fits = power.has_value();
        result = power.value_or(0);
      }
    }
    return fits ? Value(result) : fail("the number is too large");
  }
  const double x = left.as_float(), y = right.as_float();
  switch (o) {
    case '+': return x + y;
    case '-': return x - y;
    case '*': return x * y;
    case 'd': return floor_quotient(x, y);
    case '%': {
      const double rest = std::fmod(x, y);
      if (rest == 0) return std::copysign(0.0, y);
      return (rest < 0) != (y < 0) ? rest + y : rest;
    }
    default: return std::pow(x, y);
  }
}

}  // namespace cxlab::planner::templates
