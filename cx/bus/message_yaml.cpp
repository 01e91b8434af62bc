// Messages from YAML or JSON, as stimuli and configurations write them.

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <limits>

#include "cx/bus/literal.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

namespace {

Error error_at(const YAML::Node& node, std::string message) {
  return input_error(std::move(message), {}, node.Mark().line + 1);
}

std::string kind_of(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list of " + std::to_string(node.size());
  if (node.IsNull()) return "nothing";
  return "'" + node.Scalar() + "'";
}

/// YAML 1.2's words for what has no digits.
Expected<double> yaml_real(const std::string& text) {
  if (text == ".inf" || text == "+.inf" || text == ".Inf") return std::numeric_limits<double>::infinity();
  if (text == "-.inf" || text == "-.Inf") return -std::numeric_limits<double>::infinity();
  if (text == ".nan" || text == ".NaN") return std::numeric_limits<double>::quiet_NaN();
  return parse_real(text);
}

Status read_message(const YAML::Node& node, const MessageView& message, const std::string& path);

Status read_scalar(const YAML::Node& node, const MessageView& message, const Field& field, std::size_t index) {
  if (!node.IsScalar())
    return input_error(found_expected(kind_of(node), "a value of type " + std::string(to_string(field.type))));
  const std::string& text = node.Scalar();
  if (field.is_text()) return message.set_text(field, text, index);
  if (field.is_real()) {
    const auto real = yaml_real(text);
    if (!real) return real.error();
    if (field.type == FieldType::kFloat32 && std::isfinite(*real) &&
        std::abs(*real) > static_cast<double>(std::numeric_limits<float>::max()))
      return input_error(found_expected(text, "a number that a float32 can hold"));
    message.set_real(field, *real, index);
    return {};
  }
  return set_from_text(message, field, text, index);
}

Status read_element(const YAML::Node& node, const MessageView& message, const Field& field, std::size_t index,
                    const std::string& path) {
  if (field.is_message()) return read_message(node, message.nested(field, index), path);
  const Status status = read_scalar(node, message, field, index);
  if (status) return {};
  // The message names its field as well; here it has its path.
  std::string_view found = status.error().message;
  if (const std::string name = "field '" + field.name + "': "; found.starts_with(name))
    found.remove_prefix(name.size());
  return error_at(node, "field '" + path + "': " + std::string(found));
}

Status read_field(const YAML::Node& node, const MessageView& message, const Field& field, const std::string& path) {
  if (field.array == ArrayKind::kSingle) return read_element(node, message, field, 0, path);
  if (!node.IsSequence())
    return error_at(node,
                    "field '" + path + "': " + found_expected(kind_of(node), "a list (" + field.type_text() + ")"));
  if (field.is_sequence()) {
    if (Status status = message.resize(field, node.size()); !status) return error_at(node, status.error().message);
  } else if (node.size() != field.size_limit) {
    return error_at(
        node, "field '" + path +
                  "': " + found_expected(std::to_string(node.size()) + " elements", std::to_string(field.size_limit)));
  }
  for (std::size_t i = 0; i < node.size(); ++i)
    if (Status status = read_element(node[i], message, field, i, path + '[' + std::to_string(i) + ']'); !status)
      return status;
  return {};
}

Status read_message(const YAML::Node& node, const MessageView& message, const std::string& path) {
  const MessageType& type = message.type();
  if (node.IsNull()) return {};
  if (!node.IsMap())
    return error_at(node, (path.empty() ? "" : "field '" + path + "': ") +
                              found_expected(kind_of(node), "a map of the fields of " + type.name()));
  std::vector<std::string> seen;
  for (const auto& entry : node) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : kind_of(entry.first);
    const Field* field = type.find(name);
    if (field == nullptr)
      return error_at(entry.first, type.name() + " has no field '" + name + "'" + nearest_is(name, type.field_names()));
    for (const std::string& other : seen)
      if (other == name) return error_at(entry.first, "field '" + name + "' is given twice");
    seen.push_back(name);
    if (Status status = read_field(entry.second, message, *field, path.empty() ? name : path + '.' + name); !status)
      return status;
  }
  return {};
}

}  // namespace

Expected<Message> Message::from_yaml(const MessageType& type, const std::string& text) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& failure) {
    return input_error(failure.msg, {}, failure.mark.is_null() ? 0 : failure.mark.line + 1);
  }
  Message message(type);
  if (Status status = read_message(root, message.view(), {}); !status) return status.error();
  return message;
}

}  // namespace cxlab::bus
