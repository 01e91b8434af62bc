#pragma once
// Filters, tests, methods and global functions by name.

#include <string>
#include <string_view>
#include <vector>

#include "planner/templates/value.h"

namespace cxlab::planner::templates {

bool is_filter(std::string_view name);
/// One of Jinja's, whether it is done here or not.
bool is_known_filter(std::string_view name);
bool is_test(std::string_view name);
/// `; did you mean ...?`, or empty.
std::string filter_hint(const std::string& name);
std::string test_hint(const std::string& name);

Value apply_filter(Interpreter& interpreter, std::string_view name, const Value& subject, const Call& call);
bool apply_test(Interpreter& interpreter, std::string_view name, const Value& subject, const Call& call);

/// Whether values of this kind have the method, as Python's str, list and dict do.
bool has_method(const Value& subject, std::string_view name);
Value call_method(Interpreter& interpreter, const Value& subject, std::string_view name, const Call& call);

/// Whether `value` is the list, dict or object at this address, or holds it somewhere: what holds itself is never
/// freed.
bool reaches(const Value& value, const void* container, int depth = 0);

/// range, dict, namespace, cycler, joiner.
std::vector<std::pair<std::string, Value>> global_functions();

// Formatting, as Python's `"..." % arguments` and `"...".format(arguments)`.

Value format_percent(Interpreter& interpreter, const std::string& format, const Value& argument);
Value format_braces(Interpreter& interpreter, const std::string& format, const Call& call);

/// Arguments by position or name. `names` are separated by spaces; a name without a value gives null.
class Arguments {
 public:
  /// Complains (through the interpreter) about too many or unknown arguments.
  Arguments(Interpreter& interpreter, std::string_view what, const Call& call, std::string_view names);

  const Value* operator[](std::size_t index) const { return values_[index]; }
  bool has(std::size_t index) const { return values_[index] != nullptr; }
  Value get(std::size_t index, Value otherwise) const { return has(index) ? *values_[index] : otherwise; }
  bool truth(std::size_t index, bool otherwise) const { return has(index) ? values_[index]->truth() : otherwise; }
  std::int64_t integer(std::size_t index, std::int64_t otherwise);
  std::string text(std::size_t index, const std::string& otherwise) const {
    return has(index) ? values_[index]->str() : otherwise;
  }

 private:
  Interpreter& interpreter_;
  std::vector<const Value*> values_;
};

}  // namespace cxlab::planner::templates
