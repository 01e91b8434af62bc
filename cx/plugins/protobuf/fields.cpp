#include "cx/plugins/protobuf/fields.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace cxlab::cx {

namespace proto = google::protobuf;
using Field = proto::FieldDescriptor;

Handle ProtobufMessages::add(pb::MessagePtr message) {
  const Handle handle = engine_.new_handle();
  messages_.emplace(handle, std::move(message));
  return handle;
}

proto::Message* ProtobufMessages::find(Handle handle) const {
  const auto found = messages_.find(handle);
  return found == messages_.end() ? nullptr : found->second.get();
}

const char* type_word(const Field& field) {
  switch (field.type()) {
    case Field::TYPE_DOUBLE: return "DOUBLE";
    case Field::TYPE_FLOAT: return "FLOAT";
    case Field::TYPE_INT64: return "INT64";
    case Field::TYPE_UINT64: return "UINT64";
    case Field::TYPE_INT32: return "INT32";
    case Field::TYPE_FIXED64: return "FIXED64";
    case Field::TYPE_FIXED32: return "FIXED32";
    case Field::TYPE_BOOL: return "BOOL";
    case Field::TYPE_STRING: return "STRING";
    case Field::TYPE_MESSAGE: return "MESSAGE";
    case Field::TYPE_BYTES: return "BYTES";
    case Field::TYPE_UINT32: return "UINT32";
    case Field::TYPE_ENUM: return "ENUM";
    case Field::TYPE_SFIXED32: return "SFIXED32";
    case Field::TYPE_SFIXED64: return "SFIXED64";
    case Field::TYPE_SINT32: return "SINT32";
    case Field::TYPE_SINT64: return "SINT64";
    default: return "UNKNOWN";
  }
}

const char* label_word(const Field& field) {
  switch (field.label()) {
    case Field::LABEL_OPTIONAL: return "OPTIONAL";
    case Field::LABEL_REQUIRED: return "REQUIRED";
    case Field::LABEL_REPEATED: return "REPEATED";
  }
  return "UNKNOWN";
}

// --- Reading

Value field_value(const proto::Message& message, const Field& field, ProtobufMessages& messages,
                  std::optional<int> index) {
  const proto::Reflection& reflect = *message.GetReflection();
  const auto read = [&](auto get, auto get_element) {
    return index ? (reflect.*get_element)(message, &field, *index) : (reflect.*get)(message, &field);
  };
  using R = proto::Reflection;
  switch (field.cpp_type()) {
    case Field::CPPTYPE_INT32: return Value::integer(read(&R::GetInt32, &R::GetRepeatedInt32));
    case Field::CPPTYPE_INT64: return Value::integer(read(&R::GetInt64, &R::GetRepeatedInt64));
    case Field::CPPTYPE_UINT32: return Value::integer(read(&R::GetUInt32, &R::GetRepeatedUInt32));
    case Field::CPPTYPE_UINT64:
      return Value::integer(static_cast<std::int64_t>(read(&R::GetUInt64, &R::GetRepeatedUInt64)));
    case Field::CPPTYPE_DOUBLE: return Value::number(read(&R::GetDouble, &R::GetRepeatedDouble));
    case Field::CPPTYPE_FLOAT: return Value::number(static_cast<double>(read(&R::GetFloat, &R::GetRepeatedFloat)));
    case Field::CPPTYPE_BOOL: return Value::boolean(read(&R::GetBool, &R::GetRepeatedBool));
    case Field::CPPTYPE_ENUM: return Value::symbol(read(&R::GetEnum, &R::GetRepeatedEnum)->name());
    case Field::CPPTYPE_STRING:
      if (field.type() == Field::TYPE_BYTES) return Value::string("BYTES");
      return Value::string(read(&R::GetString, &R::GetRepeatedString));
    case Field::CPPTYPE_MESSAGE: {
      const proto::Message& part =
          index ? reflect.GetRepeatedMessage(message, &field, *index) : reflect.GetMessage(message, &field);
      pb::MessagePtr copy(part.New());
      copy->CopyFrom(part);
      return Value::handle(messages.add(std::move(copy)));
    }
  }
  return {};
}

// --- Writing

namespace {

using Problem = std::optional<FieldProblem>;

FieldProblem value_expected(const ValueRef& value, std::string_view expected) {
  return {found_expected(value.copy().print(), std::string(expected))};
}

/// A number of which CX would take the bits as they are.
Problem unconverted(const Field& field, const ValueRef& value) {
  switch (field.cpp_type()) {
    case Field::CPPTYPE_DOUBLE:
    case Field::CPPTYPE_FLOAT:
      if (!value.is(ValueType::kInteger)) return {};
      return value_expected(value, "a FLOAT: CX converts no INTEGER (--strict-cx)");
    case Field::CPPTYPE_INT32:
    case Field::CPPTYPE_INT64:
    case Field::CPPTYPE_UINT32:
    case Field::CPPTYPE_UINT64:
      if (!value.is(ValueType::kFloat)) return {};
      return value_expected(value, "an INTEGER: CX converts no FLOAT (--strict-cx)");
    default: return {};
  }
}

/// The number as a whole one of that type; CLIPS has 64 bits with a sign.
template <class Integer>
std::optional<Integer> whole(const ValueRef& value) {
  std::int64_t number = 0;
  if (value.is(ValueType::kInteger)) {
    number = value.as_integer();
  } else if (value.is(ValueType::kFloat)) {
    const double real = value.as_number();
    constexpr double kLimit = 9223372036854775808.0;  // 2^63
    if (std::trunc(real) != real || real < -kLimit || real >= kLimit) return std::nullopt;
    number = static_cast<std::int64_t>(real);
  } else {
    return std::nullopt;
  }
  // The upper half of unsigned 64-bit numbers wraps, as it does when they are read.
  if constexpr (sizeof(Integer) < sizeof number)
    if (number < std::numeric_limits<Integer>::min() || number > std::numeric_limits<Integer>::max())
      return std::nullopt;
  return static_cast<Integer>(number);
}

/// As deep as messages are read from the wire.
constexpr int kDeepest = 100;

bool is_deeper(const proto::Message& message, int levels) {
  if (levels == 0) return true;
  const proto::Reflection& reflect = *message.GetReflection();
  std::vector<const Field*> fields;
  reflect.ListFields(message, &fields);
  for (const Field* field : fields) {
    if (field->cpp_type() != Field::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      if (is_deeper(reflect.GetMessage(message, field), levels - 1)) return true;
      continue;
    }
    for (int i = 0; i < reflect.FieldSize(message, field); ++i)
      if (is_deeper(reflect.GetRepeatedMessage(message, field, i), levels - 1)) return true;
  }
  return false;
}

struct Writer {
  proto::Message& message;
  const Field& field;
  const ValueRef& value;
  const proto::Reflection& reflect = *message.GetReflection();

  template <class T>
  Problem put(T content, void (proto::Reflection::*set)(proto::Message*, const Field*, T) const,
              void (proto::Reflection::*append)(proto::Message*, const Field*, T) const) {
    (reflect.*(field.is_repeated() ? append : set))(&message, &field, std::move(content));
    return {};
  }

  template <class Integer>
  Problem put_whole(void (proto::Reflection::*set)(proto::Message*, const Field*, Integer) const,
                    void (proto::Reflection::*append)(proto::Message*, const Field*, Integer) const) {
    const auto number = whole<Integer>(value);
    if (!number) return value_expected(value, "a whole number that " + std::string(field.type_name()) + " can hold");
    return put(*number, set, append);
  }
};

}  // namespace

std::optional<FieldProblem> set_field(proto::Message& message, const Field& field, const ValueRef& value,
                                      const ProtobufMessages& messages, bool strict) {
  if (strict)
    if (Problem problem = unconverted(field, value)) return problem;
  using R = proto::Reflection;
  Writer writer{message, field, value};
  const proto::Reflection& reflect = writer.reflect;
  switch (field.cpp_type()) {
    case Field::CPPTYPE_INT32: return writer.put_whole<std::int32_t>(&R::SetInt32, &R::AddInt32);
    case Field::CPPTYPE_INT64: return writer.put_whole<std::int64_t>(&R::SetInt64, &R::AddInt64);
    case Field::CPPTYPE_UINT32: return writer.put_whole<std::uint32_t>(&R::SetUInt32, &R::AddUInt32);
    case Field::CPPTYPE_UINT64: return writer.put_whole<std::uint64_t>(&R::SetUInt64, &R::AddUInt64);
    case Field::CPPTYPE_DOUBLE:
      if (!value.is_number()) return value_expected(value, "a number");
      return writer.put(value.as_number(), &R::SetDouble, &R::AddDouble);
    case Field::CPPTYPE_FLOAT:
      if (!value.is_number()) return value_expected(value, "a number");
      return writer.put(static_cast<float>(value.as_number()), &R::SetFloat, &R::AddFloat);
    case Field::CPPTYPE_BOOL:
      if (!value.is_text()) return value_expected(value, "TRUE or FALSE");
      return writer.put(value.text() == "TRUE", &R::SetBool, &R::AddBool);
    case Field::CPPTYPE_STRING:
      if (field.type() == Field::TYPE_BYTES) return {};
      if (!value.is_text()) return value_expected(value, "a STRING or SYMBOL");
      return writer.put(std::string(value.text()), &R::SetString, &R::AddString);
    case Field::CPPTYPE_ENUM: {
      const proto::EnumValueDescriptor* known =
          value.is_text() ? field.enum_type()->FindValueByName(std::string(value.text())) : nullptr;
      if (!known)
        return FieldProblem{"cannot set invalid enum value " + value.copy().print() + " of " + field.full_name(), true};
      return writer.put(known, &R::SetEnum, &R::AddEnum);
    }
    case Field::CPPTYPE_MESSAGE: {
      const proto::Message* part = value.is(ValueType::kHandle) ? messages.find(value.as_handle()) : nullptr;
      if (!part) return value_expected(value, "a message of type " + field.message_type()->full_name());
      if (part->GetDescriptor() != field.message_type())
        return FieldProblem{found_expected("a message of type " + part->GetDescriptor()->full_name(),
                                           field.message_type()->full_name())};
      if (is_deeper(*part, kDeepest - 1))
        return FieldProblem{"messages would lie more than " + std::to_string(kDeepest) + " deep in each other"};
      pb::MessagePtr copy(part->New());  // it may be the message itself
      copy->CopyFrom(*part);
      proto::Message* target =
          field.is_repeated() ? reflect.AddMessage(&message, &field) : reflect.MutableMessage(&message, &field);
      target->GetReflection()->Swap(target, copy.get());
      return {};
    }
  }
  return {};
}

}  // namespace cxlab::cx
