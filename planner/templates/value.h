#pragma once
// What expressions of templates are made of: values as Python has them.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace cxlab::planner::templates {

class Interpreter;
class Value;

/// Arguments of a call.
struct Call {
  std::vector<Value> positional;
  std::vector<std::pair<std::string, Value>> named;
};
using Function = std::function<Value(Interpreter&, const Call&)>;

/// A list or tuple. Lists are shared: who appends changes all that hold it.
struct ListData {
  std::vector<Value> items;
  bool tuple = false;
  std::vector<std::string> names;  ///< of a named tuple
  std::string shown;               ///< what is printed instead of the items, if not empty
};
struct DictData {
  std::vector<std::pair<Value, Value>> entries;  ///< in the order of insertion
};
/// Something with attributes: a namespace, a loop, a module.
struct ObjectData {
  std::string kind;
  std::vector<std::pair<std::string, Value>> fields;
  Function call;                    ///< may be empty
  std::optional<std::string> text;  ///< what str() gives, if that is not the kind

  Value* find(std::string_view name);
  void set(const std::string& name, Value value);
};
struct FunctionData {
  std::string name;
  Function call;
};

/// The absence of a value; `name` says what was looked for.
struct Undefined {
  std::string name;
};

class Value {
 public:
  Value() : data_(Undefined{}) {}
  Value(bool value) : data_(value) {}
  Value(std::int64_t value) : data_(value) {}
  Value(int value) : data_(static_cast<std::int64_t>(value)) {}
  Value(double value) : data_(value) {}
  Value(std::string value) : data_(std::move(value)) {}
  Value(const char* value) : data_(std::string(value)) {}

  static Value none() { return Value(Data(nullptr)); }
  static Value undefined(std::string name) { return Value(Data(Undefined{std::move(name)})); }
  static Value list(std::vector<Value> items) {
    return Value(Data(std::make_shared<ListData>(ListData{std::move(items), false, {}, {}})));
  }
  static Value tuple(std::vector<Value> items, std::vector<std::string> names = {}) {
    return Value(Data(std::make_shared<ListData>(ListData{std::move(items), true, std::move(names), {}})));
  }
  static Value dict() { return Value(Data(std::make_shared<DictData>())); }
  static Value object(std::string kind) {
    return Value(Data(std::make_shared<ObjectData>(ObjectData{std::move(kind), {}, {}, {}})));
  }
  static Value function(std::string name, Function call) {
    return Value(Data(std::make_shared<FunctionData>(FunctionData{std::move(name), std::move(call)})));
  }

  bool is_undefined() const { return std::holds_alternative<Undefined>(data_); }
  bool is_none() const { return std::holds_alternative<std::nullptr_t>(data_); }
  bool is_bool() const { return std::holds_alternative<bool>(data_); }
  bool is_int() const { return std::holds_alternative<std::int64_t>(data_); }
  bool is_float() const { return std::holds_alternative<double>(data_); }
  bool is_string() const { return std::holds_alternative<std::string>(data_); }
  bool is_number() const { return is_bool() || is_int() || is_float(); }
  bool is_whole() const { return is_bool() || is_int(); }

  const std::string& as_string() const { return std::get<std::string>(data_); }
  const std::string& undefined_name() const { return std::get<Undefined>(data_).name; }
  /// Of numbers; booleans are 0 and 1.
  std::int64_t as_int() const {
    return is_bool()  ? std::get<bool>(data_)
           : is_int() ? std::get<std::int64_t>(data_)
                      : static_cast<std::int64_t>(std::get<double>(data_));
  }
  double as_float() const { return is_float() ? std::get<double>(data_) : static_cast<double>(as_int()); }
  ListData* as_list() const { return get<ListData>(); }
  DictData* as_dict() const { return get<DictData>(); }
  ObjectData* as_object() const { return get<ObjectData>(); }
  /// For functions of an object that change it: they do not keep it.
  std::weak_ptr<ObjectData> weak_object() const { return std::get<std::shared_ptr<ObjectData>>(data_); }
  FunctionData* as_function() const { return get<FunctionData>(); }

  /// As Python's bool(), str(), repr() and type().__name__ say.
  bool truth() const;
  std::string str() const;
  std::string repr() const;
  const char* type_name() const;

  /// Python's ==.
  bool equals(const Value& other) const;
  /// Python's <: -1, 0, 1; none if the two have no order.
  std::optional<int> order(const Value& other) const;

 private:
  using Data =
      std::variant<Undefined, std::nullptr_t, bool, std::int64_t, double, std::string, std::shared_ptr<ListData>,
                   std::shared_ptr<DictData>, std::shared_ptr<ObjectData>, std::shared_ptr<FunctionData>>;
  explicit Value(Data data) : data_(std::move(data)) {}
  template <class T>
  T* get() const {
    const auto* found = std::get_if<std::shared_ptr<T>>(&data_);
    return found == nullptr ? nullptr : found->get();
  }
  bool equals(const Value& other, int depth) const;
  void append_repr(std::string& out, int depth) const;

  Data data_;
};

/// Lists and dicts, and tuples with those: what cannot be a key.
bool may_change(const Value& value);

/// The value of a key; null if there is none.
Value* find(DictData& dict, const Value& key);
void assign(DictData& dict, const Value& key, Value value);

/// A double as Python prints it: 5.0, 0.1, 1e+16.
std::string float_text(double value);

// Strings are UTF-8; Python counts code points.

std::size_t length_of(std::string_view text);
std::vector<std::string> code_points(std::string_view text);
std::string upper(std::string_view text);
std::string lower(std::string_view text);
std::string trim(std::string_view text, std::string_view characters, bool left, bool right);
inline constexpr std::string_view kWhitespace = " \t\n\r\f\v";

}  // namespace cxlab::planner::templates
