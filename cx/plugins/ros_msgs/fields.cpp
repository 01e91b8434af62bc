#include "cx/plugins/ros_msgs/fields.h"

#include <cmath>
#include <vector>

namespace cxlab::cx {

using bus::ArrayKind;
using bus::Field;
using bus::FieldType;
using bus::MessageView;

namespace {

FieldFault unknown_field(const bus::MessageType& type, std::string_view field) {
  std::string text = type.name() + " has no field '" + std::string(field) + "'";
  const std::vector<std::string> known = type.field_names();
  const std::string near = nearest_word(std::string(field), known);
  if (!near.empty()) return {FieldFault::Kind::kNoField, text + ", did you mean '" + near + "'?"};
  for (std::size_t i = 0; i < known.size(); ++i) text += (i == 0 ? "; it has " : ", ") + known[i];
  return {FieldFault::Kind::kNoField, text};
}

FieldFault wrong_type(const bus::MessageType& found, const bus::MessageType& expected) {
  return {FieldFault::Kind::kNoMessage, found_expected("a message of type " + found.name(), expected.name())};
}

std::string char_text(const MessageView& view, const Field& field, std::size_t index) {
  const char c = static_cast<char>(view.integer(field, index));
  return c == '\0' ? std::string() : std::string(1, c);
}

void give_single(Call& call, MessageStore& store, Handle message, const MessageView& view, const Field& field) {
  switch (field.type) {
    case FieldType::kBool: return call.give_boolean(view.integer(field) != 0);
    case FieldType::kChar: return call.give_string(char_text(view, field, 0));
    case FieldType::kFloat32:
    case FieldType::kFloat64: return call.give_number(view.real(field));
    case FieldType::kString:
    case FieldType::kWstring: return call.give_string(view.text(field));
    case FieldType::kMessage: return call.give_handle(store.nested(message, field, 0));
    default: return call.give_integer(view.integer(field));
  }
}

/// The results of `item(0)`, `item(1)`, ... up to `size`.
template <class Item>
auto list_of(std::size_t size, Item item) {
  std::vector<decltype(item(size))> items(size);
  for (std::size_t i = 0; i < size; ++i) items[i] = item(i);
  return items;
}

void give_array(Call& call, MessageStore& store, Handle message, const MessageView& view, const Field& field) {
  const std::size_t size = view.size(field);
  switch (field.type) {
    case FieldType::kBool:
      return call.give_list(list_of(size, [&](auto i) { return Value::boolean(view.integer(field, i) != 0); }));
    case FieldType::kChar: return call.give_strings(list_of(size, [&](auto i) { return char_text(view, field, i); }));
    case FieldType::kFloat32:
    case FieldType::kFloat64: return call.give_numbers(list_of(size, [&](auto i) { return view.real(field, i); }));
    case FieldType::kString:
    case FieldType::kWstring: return call.give_strings(list_of(size, [&](auto i) { return view.text(field, i); }));
    case FieldType::kMessage:
      return call.give_handles(list_of(size, [&](auto i) { return store.nested(message, field, i); }));
    default: return call.give_integers(list_of(size, [&](auto i) { return view.integer(field, i); }));
  }
}

using Fault = std::optional<FieldFault>;

FieldFault value_fault(std::string text) { return {FieldFault::Kind::kValue, std::move(text)}; }
FieldFault value_expected(const ValueRef& value, std::string_view expected) {
  return value_fault(found_expected(value.copy().print(), std::string(expected)));
}
Fault fault_of(const Status& status) {
  if (status) return std::nullopt;
  return value_fault(status.error().message);
}

FieldFault unknown_message() { return {FieldFault::Kind::kUnknownMessage, "found an unknown message pointer"}; }

Fault set_integer(const MessageView& view, const Field& field, const ValueRef& value, std::size_t index) {
  if (value.is(ValueType::kInteger)) return fault_of(view.set_integer(field, value.as_integer(), index));
  if (field.type == FieldType::kChar && value.is_text() && value.text().size() <= 1)
    return fault_of(
        view.set_integer(field, value.text().empty() ? 0 : static_cast<unsigned char>(value.text()[0]), index));
  if (!value.is(ValueType::kFloat))
    return value_expected(value, field.type == FieldType::kChar ? "one character" : "an INTEGER");
  const double number = value.as_number();
  constexpr double kLimit = 9223372036854775808.0;                                  // 2^63
  if (field.type == FieldType::kUint64 && number >= kLimit && number < 2 * kLimit)  // as INTEGERs have it: wrapped
    return fault_of(view.set_integer(field, static_cast<std::int64_t>(static_cast<std::uint64_t>(number)), index));
  if (std::trunc(number) != number || number < -kLimit || number >= kLimit)
    return value_expected(value, "a whole number");
  return fault_of(view.set_integer(field, static_cast<std::int64_t>(number), index));
}

Fault set_real(const MessageView& view, const Field& field, const ValueRef& value, std::size_t index) {
  if (!value.is_number()) return value_expected(value, "a number");
  const double number = value.as_number();
  const bool single = field.type == FieldType::kFloat32;
  if (value.is(ValueType::kInteger)) {
    // Exact: the number comes back. 2^63 would not fit into an integer.
    const double stored = single ? static_cast<double>(static_cast<float>(number)) : number;
    if (stored >= 9223372036854775808.0 || static_cast<std::int64_t>(stored) != value.as_integer())
      return value_expected(value, "an integer that a float of this size holds exactly");
  } else if (single && std::isfinite(number) && !std::isfinite(static_cast<float>(number))) {
    return value_expected(value, "a number within the range of float32");
  }
  view.set_real(field, number, index);
  return {};
}

}  // namespace

MessageView Fields::source(const Field& field, const ValueRef& value, Fault& fault) {
  const MessageView found = value.is(ValueType::kHandle) ? store_.view(value.as_handle()) : MessageView();
  if (!found) {
    fault = unknown_message();
    return {};
  }
  if (&found.type() == field.nested) return found;
  const std::string text = wrong_type(found.type(), *field.nested).text;
  if (!found.type().has_fields_of(*field.nested)) {
    fault = value_fault(text);
    return {};
  }
  if (strict_) {
    fault = value_fault(text + ", and --strict-cx takes no other type");
    return {};
  }
  if (warned_.emplace(field.nested->name(), found.type().name()).second)
    warn_(text + ": it has the same fields, so it is accepted");
  return {field.nested, found.memory()};
}

Fault Fields::set_value(const MessageView& view, const Field& field, const ValueRef& value, std::size_t index) {
  if (field.type == FieldType::kBool) {
    if (!value.is_text()) return value_expected(value, "TRUE or FALSE");
    return fault_of(view.set_integer(field, value.text() == "TRUE" ? 1 : 0, index));
  }
  if (strict_ && !field.is_text() && !field.is_message() && value.is_number() &&
      field.is_real() == value.is(ValueType::kInteger))
    return value_expected(value, field.is_real() ? "a FLOAT: CX converts no INTEGER (--strict-cx)"
                                                 : "an INTEGER: CX converts no FLOAT (--strict-cx)");
  if (field.is_real()) return set_real(view, field, value, index);
  if (field.is_text()) {
    if (!value.is_text()) return value_expected(value, "a STRING or SYMBOL");
    return fault_of(view.set_text(field, value.text(), index));
  }
  if (!field.is_message()) return set_integer(view, field, value, index);
  Fault fault;
  if (const MessageView from = source(field, value, fault)) view.nested(field, index).copy_from(from);
  return fault;
}

/// Sources may lie in the array that is set, so they are copied before it changes its size.
Fault Fields::set_messages(const MessageView& view, const Field& field, const ValueRef& values) {
  std::vector<bus::Message> sources;
  Fault fault;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const MessageView from = source(field, values[i], fault);
    if (!from) return fault;
    sources.emplace_back(from);
  }
  if (field.is_sequence()) fault = fault_of(view.resize(field, sources.size()));
  if (fault) return fault;
  for (std::size_t i = 0; i < sources.size(); ++i) view.nested(field, i).copy_from(sources[i].view());
  return {};
}

Fault Fields::set_array(const MessageView& view, const Field& field, const ValueRef& values) {
  if (!values.is(ValueType::kMultifield))
    return FieldFault{FieldFault::Kind::kNotMultifield, found_expected(values.copy().print(), "a multifield")};
  if (field.array == ArrayKind::kFixed && values.size() != field.size_limit)
    return value_fault(
        found_expected(std::to_string(values.size()) + " values", "exactly " + std::to_string(field.size_limit)));
  if (field.is_message()) return set_messages(view, field, values);
  if (field.is_sequence())
    if (Fault fault = fault_of(view.resize(field, values.size()))) return fault;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (Fault fault = set_value(view, field, values[i], i)) return fault;
  return {};
}

const Field* Fields::find(const bus::MessageType& type, const ValueRef& name) {
  const auto mix = reinterpret_cast<std::uintptr_t>(name.atom()) ^ reinterpret_cast<std::uintptr_t>(&type) >> 3;
  Known& known = known_[(mix >> 4) % known_.size()];
  if (known.atom == name.atom() && known.type == &type) return known.field;
  const Field* field = type.find(name.text());
  if (field) {
    store_.engine().keep(name);
    known = {name.atom(), &type, field};
  }
  return field;
}

Fault Fields::give(Call& call, Handle message, const ValueRef& name, const bus::MessageType* expected) {
  const MessageView view = store_.view(message);
  if (!view) return FieldFault{FieldFault::Kind::kNoMessage, "invalid message pointer"};
  if (expected && expected != &view.type()) return wrong_type(view.type(), *expected);
  const Field* field = find(view.type(), name);
  if (!field) return unknown_field(view.type(), name.text());
  if (field->array == ArrayKind::kSingle)
    give_single(call, store_, message, view, *field);
  else
    give_array(call, store_, message, view, *field);
  return std::nullopt;
}

Fault Fields::set(Handle message, const ValueRef& name, const ValueRef& value, const bus::MessageType* expected) {
  const MessageView view = store_.writable(message);
  if (!view) return FieldFault{FieldFault::Kind::kNoMessage, "invalid message pointer"};
  if (expected && expected != &view.type()) return wrong_type(view.type(), *expected);
  const Field* field = find(view.type(), name);
  if (!field) return unknown_field(view.type(), name.text());
  Fault fault = field->array == ArrayKind::kSingle ? set_value(view, *field, value, 0) : set_array(view, *field, value);
  if (fault) fault->text += " (" + field->type_text() + ' ' + field->name + " of " + view.type().name() + ')';
  return fault;
}

}  // namespace cxlab::cx
