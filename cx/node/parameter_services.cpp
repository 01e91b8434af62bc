#include "cx/node/parameter_services.h"

#include <algorithm>
#include <array>
#include <memory>

#include "cx/base/number_text.h"
#include "cx/bus/needed.h"
#include "cx/node/lifecycle.h"

namespace cxlab::cx {

namespace {

using Type = Parameter::Type;

/// As in rcl_interfaces/msg/ParameterType.
enum RosType : std::uint8_t {
  kNotSet = 0,
  kBool = 1,
  kInteger = 2,
  kDouble = 3,
  kString = 4,
  kByteArray = 5,
  kBoolArray = 6,
  kIntegerArray = 7,
  kDoubleArray = 8,
  kStringArray = 9
};
/// The field of a ParameterValue that has the value is named after them: "integer_array_value".
constexpr std::array<const char*, 10> kTypeNames{"not set",      "bool",        "integer",    "double",
                                                 "string",       "byte_array",  "bool_array", "integer_array",
                                                 "double_array", "string_array"};

const bus::Field& field_of(const bus::MessageView& value, RosType type) {
  return *value.type().find(kTypeNames[type] + std::string("_value"));
}

std::int64_t integer_of(const Parameter& p) { return read_number<std::int64_t>(p.text).value_or(0); }
double number_of(const Parameter& p) { return read_number<double>(p.text).value_or(0); }

RosType type_of(const Parameter& p) {
  switch (p.type) {
    case Type::kNone: return kNotSet;
    case Type::kBool: return kBool;
    case Type::kInteger: return kInteger;
    case Type::kDouble: return kDouble;
    case Type::kString: return kString;
    case Type::kList: break;
  }
  const auto all = [&](Type t) {
    return !p.items.empty() && std::ranges::all_of(p.items, [t](const Parameter& i) { return i.type == t; });
  };
  if (all(Type::kBool)) return kBoolArray;
  if (all(Type::kInteger)) return kIntegerArray;
  const bool numbers = !p.items.empty() && std::ranges::all_of(p.items, [](const Parameter& i) {
    return i.type == Type::kInteger || i.type == Type::kDouble;
  });
  return numbers ? kDoubleArray : kStringArray;
}

Parameter scalar(Type type, std::string text) {
  Parameter p;
  p.type = type;
  p.text = std::move(text);
  return p;
}

void put_scalar(const Parameter& p, const bus::MessageView& value, const bus::Field& field, std::size_t index) {
  if (field.is_text())
    (void)value.set_text(field, p.text, index);
  else if (field.is_real())
    value.set_real(field, number_of(p), index);
  else
    (void)value.set_integer(field, field.type == bus::FieldType::kBool ? p.text == "true" : integer_of(p), index);
}

Parameter take_scalar(const bus::MessageView& value, const bus::Field& field, std::size_t index) {
  if (field.is_text()) return scalar(Type::kString, value.text(field, index));
  if (field.is_real()) return scalar(Type::kDouble, shortest_text(value.real(field, index)));
  const std::int64_t integer = value.integer(field, index);
  if (field.type == bus::FieldType::kBool) return scalar(Type::kBool, integer ? "true" : "false");
  return scalar(Type::kInteger, std::to_string(integer));
}

/// The services of one node.
class Server {
 public:
  Server(bus::Bus& bus, Parameters& parameters, ParameterCheck check, std::string node)
      : bus_(bus), parameters_(parameters), check_(std::move(check)), node_(std::move(node)) {}

  Status open(bus::ParticipantId node) {
    auto type = bus_.registry().message("rcl_interfaces/msg/ParameterEvent");
    if (!type) return type.error();
    if (!bus::can_offer(bus_.registry(), "topic /parameter_events", (*type)->name())) return {};
    event_ = *type;
    auto events = bus_.advertise(node, "/parameter_events", *event_);
    if (!events) return events.error();
    events_ = *events;
    return {};
  }

  void list(const bus::MessageView& request, const bus::MessageView& response) const {
    const bus::MessageView result = response.nested("result");
    const bus::Field& prefixes = *request.type().find("prefixes");
    const std::int64_t depth = request.integer("depth");
    for (const std::string& name : parameters_.names()) {
      bool wanted = request.size(prefixes) == 0 && deep_enough(name, depth);
      for (std::size_t i = 0; i < request.size(prefixes) && !wanted; ++i) {
        const std::string& prefix = request.text(prefixes, i);
        wanted =
            name == prefix || (name.starts_with(prefix + '.') && deep_enough(name.substr(prefix.size() + 1), depth));
      }
      if (!wanted) continue;
      result.append_text("names", name);
      const std::string group = name.substr(0, name.rfind('.'));
      if (group.size() == name.size()) continue;
      const bus::Field& groups = *result.type().find("prefixes");
      const std::size_t n = result.size(groups);
      if (n == 0 || result.text(groups, n - 1) != group) result.append_text("prefixes", group);
    }
  }

  void get(const bus::MessageView& request, const bus::MessageView& response) const {
    each_name(request, [&](const std::string&, const Parameter* p) {
      const bus::MessageView value = response.append("values");
      if (p) put_parameter(*p, value);
    });
  }

  void types(const bus::MessageView& request, const bus::MessageView& response) const {
    const bus::Field& types = *response.type().find("types");
    (void)response.resize(types, request.size("names"));
    std::size_t i = 0;
    each_name(request, [&](const std::string&, const Parameter* p) {
      (void)response.set_integer(types, p ? type_of(*p) : kNotSet, i++);
    });
  }

  void describe(const bus::MessageView& request, const bus::MessageView& response) const {
    each_name(request, [&](const std::string& name, const Parameter* p) {
      response.append("descriptors")
          .set("name", name)
          .set("type", static_cast<std::int64_t>(p ? type_of(*p) : kNotSet));
    });
  }

  void set(const bus::MessageView& request, const bus::MessageView& response) {
    const bus::Field& list = *request.type().find("parameters");
    for (std::size_t i = 0; i < request.size(list); ++i) {
      const Status s = set({request.nested(list, i)});
      put_result(s, response.append("results"));
    }
  }

  void set_atomically(const bus::MessageView& request, const bus::MessageView& response) {
    const bus::Field& list = *request.type().find("parameters");
    std::vector<bus::MessageView> all;
    for (std::size_t i = 0; i < request.size(list); ++i) all.push_back(request.nested(list, i));
    put_result(set(all), response.nested("result"));
  }

 private:
  static bool deep_enough(const std::string& name, std::int64_t depth) {
    return depth == 0 || std::ranges::count(name, '.') < depth;
  }

  template <class Do>
  void each_name(const bus::MessageView& request, Do&& act) const {
    const bus::Field& names = *request.type().find("names");
    for (std::size_t i = 0; i < request.size(names); ++i)
      act(request.text(names, i), parameters_.find(request.text(names, i)));
  }

  static void put_result(const Status& s, const bus::MessageView& result) {
    result.set("successful", s.ok());
    if (!s) result.set("reason", s.error().message);
  }

  Status set(const std::vector<bus::MessageView>& wanted) {
    std::vector<std::pair<std::string, Parameter>> values;
    for (const bus::MessageView& parameter : wanted) {
      auto value = take_parameter(parameter.nested("value"));
      if (!value) return value.error();
      values.emplace_back(parameter.text("name"), *std::move(value));
    }
    return change(std::move(values));
  }

 public:
  /// All of them or none.
  Status change(std::vector<std::pair<std::string, Parameter>> values) {
    for (auto& [name, value] : values) {
      if (name.empty()) return input_error("a parameter needs a name");
      const Parameter* old = parameters_.find(name);
      if (!old) return input_error("parameter '" + name + "' cannot be set because it was not declared");
      const RosType was = type_of(*old), is = type_of(value);
      if (was != is && old->type != Type::kNone &&
          !(old->type == Type::kList && value.type == Type::kList && (old->items.empty() || value.items.empty())))
        return input_error("Wrong parameter type, parameter {" + name + "} is of type {" + kTypeNames[was] +
                           "}, setting it to {" + kTypeNames[is] + "} is not allowed.");
      if (check_)
        if (Status s = check_(name, value); !s) return s;
      value.file = "parameter " + node_ + '.' + name;
      value.at_run_time = true;
    }
    publish(values);
    for (auto& [name, value] : values) parameters_.put(name, std::move(value));
    return {};
  }

 private:
  void publish(const std::vector<std::pair<std::string, Parameter>>& changes) {
    if (!event_) return;
    auto message = std::make_shared<bus::Message>(*event_);
    const bus::MessageView event = message->view();
    const auto now = bus_.now().count();
    event.nested("stamp").set("sec", now / 1'000'000'000).set("nanosec", now % 1'000'000'000);
    event.set("node", node_);
    for (const auto& [name, value] : changes) {
      const bus::MessageView told = event.append("changed_parameters");
      told.set("name", name);
      put_parameter(value, told.nested("value"));
    }
    bus_.publish(events_, std::move(message));
  }

  bus::Bus& bus_;
  Parameters& parameters_;
  ParameterCheck check_;
  std::string node_;
  bus::EndpointId events_{};
  const bus::MessageType* event_ = nullptr;
};

}  // namespace

void put_parameter(const Parameter& p, const bus::MessageView& value) {
  const RosType type = type_of(p);
  value.set("type", static_cast<std::int64_t>(type));
  if (type == kNotSet) return;
  const bus::Field& field = field_of(value, type);
  if (p.type != Type::kList) return put_scalar(p, value, field, 0);
  (void)value.resize(field, p.items.size());
  for (std::size_t i = 0; i < p.items.size(); ++i) put_scalar(p.items[i], value, field, i);
}

Expected<Parameter> take_parameter(const bus::MessageView& value) {
  const std::int64_t type = value.integer("type");
  if (type < kBool || type > kStringArray) return input_error("a parameter cannot be set to nothing");
  const bus::Field& field = field_of(value, static_cast<RosType>(type));
  if (type <= kString) return take_scalar(value, field, 0);
  Parameter list;
  list.type = Type::kList;
  for (std::size_t i = 0; i < value.size(field); ++i) list.items.push_back(take_scalar(value, field, i));
  return list;
}

Expected<ParameterSetter> serve_parameters(bus::Bus& bus, bus::ParticipantId node, Parameters& parameters,
                                           ParameterCheck check) {
  const auto server = std::make_shared<Server>(bus, parameters, std::move(check), bus.name_of(node).full_name());
  if (Status s = server->open(node); !s) return s.error();
  auto services = cx::serve(bus, node,
                            {{"~/list_parameters", "rcl_interfaces/srv/ListParameters",
                              [server](const auto& q, const auto& a) { server->list(q, a); }},
                             {"~/get_parameters", "rcl_interfaces/srv/GetParameters",
                              [server](const auto& q, const auto& a) { server->get(q, a); }},
                             {"~/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes",
                              [server](const auto& q, const auto& a) { server->types(q, a); }},
                             {"~/describe_parameters", "rcl_interfaces/srv/DescribeParameters",
                              [server](const auto& q, const auto& a) { server->describe(q, a); }},
                             {"~/set_parameters", "rcl_interfaces/srv/SetParameters",
                              [server](const auto& q, const auto& a) { server->set(q, a); }},
                             {"~/set_parameters_atomically", "rcl_interfaces/srv/SetParametersAtomically",
                              [server](const auto& q, const auto& a) { server->set_atomically(q, a); }}});
  if (!services) return services.error();
  return ParameterSetter([server](auto values) { return server->change(std::move(values)); });
}

}  // namespace cxlab::cx
