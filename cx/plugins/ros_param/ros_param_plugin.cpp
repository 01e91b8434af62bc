#include <cmath>

#include "cx/base/number_text.h"
#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

using Type = Parameter::Type;

/// The type that a default gives to its parameter.
struct Wanted {
  Type type = Type::kString;  ///< of the value, or of the elements
  bool is_list = false;
};

bool is_truth(const ValueRef& value) { return value.is_text() && (value.text() == "TRUE" || value.text() == "FALSE"); }

Expected<Type> type_of(const ValueRef& value) {
  if (value.is(ValueType::kInteger)) return Type::kInteger;
  if (value.is(ValueType::kFloat)) return Type::kDouble;
  if (is_truth(value)) return Type::kBool;
  if (value.is_text()) return Type::kString;
  return input_error(
      found_expected("a default " + value.copy().print(), "a number, a symbol, a string or a list of such"));
}

Expected<Wanted> wanted_by(const ValueRef& fallback) {
  Wanted out;
  out.is_list = fallback.is(ValueType::kMultifield);
  if (!out.is_list) {
    auto type = type_of(fallback);
    if (!type) return type.error();
    out.type = *type;
    return out;
  }
  if (fallback.size() == 0) return out;
  auto first = type_of(fallback[0]);
  if (!first) return first.error();
  out.type = *first;
  for (std::size_t i = 0; out.type == Type::kBool && i < fallback.size(); ++i)
    if (!is_truth(fallback[i])) out.type = Type::kString;
  return out;
}

Parameter parameter_from(const ValueRef& value, Type type) {
  Parameter out;
  out.type = type;
  switch (type) {
    case Type::kBool: out.text = value.text() == "TRUE" ? "true" : "false"; break;
    case Type::kInteger: out.text = std::to_string(value.as_integer()); break;
    case Type::kDouble: out.text = shortest_text(value.as_number()); break;
    default: out.text = value.is_text() ? std::string(value.text()) : value.copy().print(); break;
  }
  return out;
}

/// The parameter as a value of that type. Numbers are converted where that is exact.
Expected<Value> value_of(const Parameter& p, Type type) {
  if (p.type == Type::kInteger) {
    const auto integer = read_number<std::int64_t>(p.text).value_or(0);
    if (type == Type::kInteger) return Value::integer(integer);
    const auto number = static_cast<double>(integer);
    if (type == Type::kDouble && std::abs(number) < 0x1p63 && static_cast<std::int64_t>(number) == integer)
      return Value::number(number);
  } else if (p.type == Type::kDouble) {
    const double number = read_number<double>(p.text).value_or(NAN);
    if (type == Type::kDouble) return Value::number(number);
    if (type == Type::kInteger && std::abs(number) <= 0x1p53 && std::trunc(number) == number)
      return Value::integer(static_cast<std::int64_t>(number));
  } else if (p.type == type) {
    return type == Type::kBool ? Value::boolean(p.text == "true") : Value::string(p.text);
  }
  return input_error("found " + (p.text.empty() ? std::string() : "'" + p.text + "' (") +
                     std::string(to_string(p.type)) + (p.text.empty() ? "" : ")") + ", the default wants " +
                     std::string(to_string(type)));
}

/// Where the value is from, behind what is wrong with it: " (game.yaml:7)". Empty where rules have set it.
std::string place_of(const Parameter& p) {
  if (p.at_run_time || p.file.empty()) return {};
  return " (" + p.file + (p.line > 0 ? ':' + std::to_string(p.line) : "") + ')';
}

/// Parameters of the manager node, as rules ask for them.
class RosParamPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard environment) override {
    Environment& e = *environment;
    return e.engine().add_function({"ros-param-get-value", "*", 2, 2, ";sy;*", FunctionKind::kPure, name(),
                                    "A parameter of the manager node; declares it with the default if there is none."},
                                   [this, &e](Call& call) { get(e, call); });
  }

 private:
  void get(Environment& environment, Call& call) {
    const std::string parameter(call.text(0));
    const ValueRef& fallback = call.arg(1);
    context().parameters.find(parameter);  // it is asked for in a replay, too
    // Others may set parameters during the run: what rules found is part of the input log, as (TRUE value...) or (FALSE
    // why).
    const Value found = environment.look("ros-param-get-value " + parameter, [&] {
      auto values = read(parameter, fallback);
      if (!values) return Value::multifield({Value::boolean(false), Value::string(values.error().message)});
      values->insert(values->begin(), Value::boolean(true));
      return Value::multifield(*std::move(values));
    });
    const auto& items = found.items();
    if (items.empty() || !items[0].is_true()) {
      call.fail("parameter '" + parameter +
                "': " + (items.size() > 1 ? items[1].text() : std::string("nothing was recorded")));
      return;
    }
    if (fallback.is(ValueType::kMultifield))
      call.give_list(std::span(items).subspan(1));
    else
      call.give(items.at(1));
  }

  Expected<std::vector<Value>> read(const std::string& parameter, const ValueRef& fallback) {
    if (parameter.empty()) return input_error(found_expected("an empty name", "that of a parameter"));
    auto wanted = wanted_by(fallback);
    if (!wanted) return wanted.error();
    const Parameter* known = context().parameters.find(parameter);
    if (known == nullptr || known->type == Type::kNone) {
      declare(parameter, fallback, *wanted);
      known = context().parameters.find(parameter);
    }
    const bool is_list = known->type == Type::kList;
    if (is_list != wanted->is_list)
      return input_error("found " + std::string(to_string(known->type)) + ", the default wants " +
                         (wanted->is_list ? "a list" : std::string(to_string(wanted->type))) + place_of(*known));
    std::vector<Value> out;
    const std::span<const Parameter> items =
        is_list ? std::span<const Parameter>(known->items) : std::span<const Parameter>(known, 1);
    for (const Parameter& item : items) {
      auto value = value_of(item, wanted->type);
      if (!value) return input_error(value.error().message + place_of(*known));
      out.push_back(*std::move(value));
    }
    return out;
  }

  void declare(const std::string& parameter, const ValueRef& fallback, const Wanted& wanted) {
    Parameter declared;
    if (wanted.is_list) {
      declared.type = Type::kList;
      for (std::size_t i = 0; i < fallback.size(); ++i) {
        auto own = type_of(fallback[i]);  // a list of mixed types is found out when it is read back
        const bool text = wanted.type == Type::kString;
        declared.items.push_back(parameter_from(fallback[i], text || !own ? Type::kString : *own));
      }
    } else {
      declared = parameter_from(fallback, wanted.type);
    }
    declared.file = "ros-param-get-value " + parameter;
    declared.at_run_time = true;
    context().parameters.put(parameter, std::move(declared));
  }
};

}  // namespace

PluginType ros_param_plugin() {
  return {"cx::RosParamPlugin", {}, [](PluginContext c) { return std::make_unique<RosParamPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
