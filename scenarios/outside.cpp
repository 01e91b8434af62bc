#include "scenarios/outside.h"

#include "cx/base/byte_codec.h"

namespace cxlab {

namespace {

void write(const Value& value, ByteWriter& out) {
  switch (value.type()) {
    case ValueType::kInteger: out.fixed(value.type()).fixed(value.as_integer()); return;
    case ValueType::kFloat: out.fixed(value.type()).fixed(value.as_number()); return;
    case ValueType::kHandle: out.fixed(value.type()).fixed(value.as_handle()); return;
    case ValueType::kSymbol:
    case ValueType::kString:
    case ValueType::kInstanceName:
      out.fixed(value.type()).fixed(static_cast<std::uint32_t>(value.text().size())).raw(value.text());
      return;
    case ValueType::kMultifield:
      out.fixed(value.type()).fixed(static_cast<std::uint32_t>(value.items().size()));
      for (const Value& item : value.items()) write(item, out);
      return;
    default: out.fixed(ValueType::kVoid);
  }
}

/// Multifields hold no multifields.
Value read(ByteReader& in, bool inside = false) {
  const auto text = [&in] { return std::string(in.raw(in.fixed<std::uint32_t>())); };
  switch (in.fixed<ValueType>()) {
    case ValueType::kVoid: return {};
    case ValueType::kInteger: return Value::integer(in.fixed<std::int64_t>());
    case ValueType::kFloat: return Value::number(in.fixed<double>());
    case ValueType::kHandle: return Value::handle(in.fixed<Handle>());
    case ValueType::kSymbol: return Value::symbol(text());
    case ValueType::kString: return Value::string(text());
    case ValueType::kInstanceName: return Value::instance_name(text());
    case ValueType::kMultifield: {
      if (inside) in.refuse();
      const auto size = in.fixed<std::uint32_t>();
      std::vector<Value> items;
      for (std::uint32_t i = 0; i < size && in.ok(); ++i) items.push_back(read(in, true));
      return Value::multifield(std::move(items));
    }
    default: in.refuse(); return {};
  }
}

}  // namespace

std::string to_bytes(const Value& value) {
  std::string bytes;
  ByteWriter out(bytes);
  write(value, out);
  return bytes;
}

Expected<Value> value_from_bytes(std::string_view bytes) {
  ByteReader in(bytes);
  Value value = read(in);
  if (!in.ok() || in.left() > 0) return input_error("a value in the input log is damaged");
  return value;
}

Value RecordingOutside::look(std::string_view function, const std::function<Value()>& outside) {
  Value value = outside();
  log_.add(LoggedResult{bus_.now(), stream_, function, to_bytes(value)});
  return value;
}

Value ReplayingOutside::look(std::string_view function, const std::function<Value()>&) {
  if (error_) return Value();
  auto bytes = replayer_.next_result(stream_, function);
  if (!bytes) {
    error_ = bytes.error();
    return Value();
  }
  auto value = value_from_bytes(*bytes);
  if (!value) {
    error_ = value.error();
    return Value();
  }
  return *std::move(value);
}

}  // namespace cxlab
