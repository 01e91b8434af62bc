#include "scenarios/outside.h"

#include <cstring>

namespace cxlab {

namespace {

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
bool take(std::string_view& bytes, T& value) {
  if (bytes.size() < sizeof value) return false;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return true;
}

void write(const Value& value, std::string& out) {
  put(out, static_cast<std::uint8_t>(value.type()));
  switch (value.type()) {
    case ValueType::kInteger: put(out, value.as_integer()); break;
    case ValueType::kFloat: put(out, value.as_number()); break;
    case ValueType::kHandle: put(out, static_cast<std::uint64_t>(value.as_handle())); break;
    case ValueType::kSymbol:
    case ValueType::kString:
    case ValueType::kInstanceName:
      put(out, static_cast<std::uint32_t>(value.text().size()));
      out += value.text();
      break;
    case ValueType::kMultifield:
      put(out, static_cast<std::uint32_t>(value.items().size()));
      for (const Value& item : value.items()) write(item, out);
      break;
    default: out.back() = static_cast<char>(ValueType::kVoid);
  }
}

bool read(std::string_view& bytes, Value& value) {
  std::uint8_t type = 0;
  if (!take(bytes, type)) return false;
  std::uint32_t size = 0;
  switch (static_cast<ValueType>(type)) {
    case ValueType::kVoid: value = Value(); return true;
    case ValueType::kInteger: {
      std::int64_t number = 0;
      if (!take(bytes, number)) return false;
      value = Value::integer(number);
      return true;
    }
    case ValueType::kFloat: {
      double number = 0;
      if (!take(bytes, number)) return false;
      value = Value::number(number);
      return true;
    }
    case ValueType::kHandle: {
      std::uint64_t number = 0;
      if (!take(bytes, number)) return false;
      value = Value::handle(Handle{number});
      return true;
    }
    case ValueType::kSymbol:
    case ValueType::kString:
    case ValueType::kInstanceName: {
      if (!take(bytes, size) || bytes.size() < size) return false;
      std::string text(bytes.substr(0, size));
      bytes.remove_prefix(size);
      value = type == static_cast<std::uint8_t>(ValueType::kSymbol)   ? Value::symbol(std::move(text))
              : type == static_cast<std::uint8_t>(ValueType::kString) ? Value::string(std::move(text))
                                                                      : Value::instance_name(std::move(text));
      return true;
    }
    case ValueType::kMultifield: {
      if (!take(bytes, size) || size > bytes.size()) return false;
      std::vector<Value> items(size);
      for (Value& item : items)
        if (!read(bytes, item)) return false;
      value = Value::multifield(std::move(items));
      return true;
    }
    default: return false;
  }
}

}  // namespace

std::string to_bytes(const Value& value) {
  std::string out;
  write(value, out);
  return out;
}

Expected<Value> value_from_bytes(std::string_view bytes) {
  Value value;
  if (!read(bytes, value) || !bytes.empty()) return input_error("a value in the input log is damaged");
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
