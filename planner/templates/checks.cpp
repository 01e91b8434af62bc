// Tests: what stands behind `is`.

#include <algorithm>

#include "cx/base/expected.h"
#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {
namespace {

const std::vector<std::string>& test_names() {
  static const std::vector<std::string> names = {
      "boolean", "callable", "defined",  "divisibleby", "eq",      "equalto", "even",      "false",
      "filter",  "float",    "ge",       "greaterthan", "gt",      "in",      "integer",   "iterable",
      "le",      "lessthan", "lower",    "lt",          "mapping", "ne",      "none",      "number",
      "odd",     "sameas",   "sequence", "string",      "test",    "true",    "undefined", "upper",
      "==",      "!=",       "<",        "<=",          ">",       ">="};
  return names;
}

std::string canonical(std::string_view name) {
  if (name == "==" || name == "equalto") return "eq";
  if (name == "!=") return "ne";
  if (name == "<" || name == "lessthan") return "lt";
  if (name == "<=") return "le";
  if (name == ">" || name == "greaterthan") return "gt";
  if (name == ">=") return "ge";
  return std::string(name);
}

}  // namespace

bool is_test(std::string_view name) {
  return std::find(test_names().begin(), test_names().end(), name) != test_names().end();
}

std::string test_hint(const std::string& name) { return did_you_mean(name, test_names(), "; "); }

bool apply_test(Interpreter& interpreter, std::string_view written, const Value& subject, const Call& call) {
  if (interpreter.failed() || !interpreter.spend(1)) return false;
  const std::string name = canonical(written);
  const auto has_letters = [&](const std::string& text) { return lower(text) != upper(text); };
  if (name == "defined") return !subject.is_undefined();
  if (name == "undefined") return subject.is_undefined();
  if (name == "none") return subject.is_none();
  if (name == "boolean") return subject.is_bool();
  if (name == "true") return subject.is_bool() && subject.truth();
  if (name == "false") return subject.is_bool() && !subject.truth();
  if (name == "integer") return subject.is_int();
  if (name == "float") return subject.is_float();
  if (name == "number") return subject.is_number();
  if (name == "string") return subject.is_string();
  if (name == "mapping") return subject.as_dict() != nullptr;
  if (name == "sequence" || name == "iterable")
    return subject.is_string() || subject.as_list() != nullptr || subject.as_dict() != nullptr ||
           subject.is_undefined();
  if (name == "callable")
    return subject.is_undefined() || subject.as_function() != nullptr ||
           (subject.as_object() != nullptr && subject.as_object()->call);
  if (name == "lower") return subject.str() == lower(subject.str()) && has_letters(subject.str());
  if (name == "upper") return subject.str() == upper(subject.str()) && has_letters(subject.str());
  if (name == "filter") return is_filter(subject.str());
  if (name == "test") return is_test(subject.str());
  if (name == "even" || name == "odd") {
    const Value rest = interpreter.binary("%", subject, Value(2));
    return !interpreter.failed() && rest.equals(Value(name == "even" ? 0 : 1));
  }
  const Arguments arguments(interpreter, "the test " + name, call, "other");
  if (interpreter.failed() || !arguments.has(0)) {
    interpreter.fail("the test " + name + " takes one argument");
    return false;
  }
  const Value& other = *arguments[0];
  if (name == "eq") return subject.equals(other);
  if (name == "ne") return !subject.equals(other);
  if (name == "lt") return interpreter.less(subject, other);
  if (name == "gt") return interpreter.less(other, subject);
  if (name == "le") return !interpreter.less(other, subject) && !interpreter.failed();
  if (name == "ge") return !interpreter.less(subject, other) && !interpreter.failed();
  if (name == "in") return interpreter.contains(other, subject);
  if (name == "divisibleby") return interpreter.binary("%", subject, other).equals(Value(0)) && !interpreter.failed();
  // sameas: the same object; values without an identity of their own are the same when equal and of one type.
  const bool shared = subject.as_list() != nullptr || subject.as_dict() != nullptr;
  if (shared) return subject.as_list() == other.as_list() && subject.as_dict() == other.as_dict();
  return std::string(subject.type_name()) == other.type_name() && subject.equals(other);
}

}  // namespace cxlab::planner::templates
