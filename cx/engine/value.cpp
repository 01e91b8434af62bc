#include "cx/engine/value.h"

#include <cstdio>

#include "cx/base/number_text.h"
#include "internal/impl.h"

namespace cxlab {
Value Value::multifield(std::vector<Value> items) {
  Value value(ValueType::kMultifield, 0, 0.0, {});
  value.items_ = std::move(items);
  return value;
}

bool Value::is_text() const {
  return type_ == ValueType::kSymbol || type_ == ValueType::kString || type_ == ValueType::kInstanceName;
}

std::string print_float(double value) {
  std::string text = general_text(value, 15);
  if (text.find_first_of(".eni") == std::string::npos) text += ".0";
  return text;
}

std::string Value::print() const {
  switch (type_) {
    case ValueType::kVoid: return {};
    case ValueType::kInteger: return std::to_string(integer_);
    case ValueType::kFloat: return print_float(number_);
    case ValueType::kSymbol: return text_;
    case ValueType::kInstanceName: return "[" + text_ + "]";
    case ValueType::kFact: return "<Fact-" + std::to_string(integer_) + ">";
    case ValueType::kInstance: return "<Instance-" + text_ + ">";
    case ValueType::kHandle: {
      char buffer[40];
      std::snprintf(buffer, sizeof buffer, "<Pointer-C-0x%llx>", static_cast<unsigned long long>(integer_));
      return buffer;
    }
    case ValueType::kString: {
      std::string quoted = "\"";
      for (const char c : text_) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
      }
      return quoted + '"';
    }
    case ValueType::kMultifield: {
      std::string list = "(";
      for (std::size_t i = 0; i < items_.size(); ++i) list += (i == 0 ? "" : " ") + items_[i].print();
      return list + ")";
    }
  }
  return {};
}

std::int64_t ValueRef::as_integer() const {
  switch (type()) {
    case ValueType::kInteger: return static_cast<const clips::CLIPSInteger*>(atom_)->contents;
    case ValueType::kFloat: return static_cast<std::int64_t>(static_cast<const clips::CLIPSFloat*>(atom_)->contents);
    default: return 0;
  }
}

double ValueRef::as_number() const {
  switch (type()) {
    case ValueType::kInteger: return static_cast<double>(static_cast<const clips::CLIPSInteger*>(atom_)->contents);
    case ValueType::kFloat: return static_cast<const clips::CLIPSFloat*>(atom_)->contents;
    default: return 0.0;
  }
}

std::string_view ValueRef::text() const {
  return is_text() ? static_cast<const clips::CLIPSLexeme*>(atom_)->contents : std::string_view{};
}

Handle ValueRef::as_handle() const {
  if (type() != ValueType::kHandle) return Handle::kNone;
  return Handle{reinterpret_cast<std::uintptr_t>(static_cast<const clips::CLIPSExternalAddress*>(atom_)->contents)};
}

std::int64_t ValueRef::fact_index() const {
  return type() == ValueType::kFact ? static_cast<const clips::Fact*>(atom_)->factIndex : 0;
}

ValueRef ValueRef::operator[](std::size_t i) const {
  const auto* list = static_cast<const clips::Multifield*>(atom_);
  const clips::CLIPSValue& item = list->contents[begin_ + i];
  return ValueRef(item.value, value_type(*item.header), 0, 0);
}

Value ValueRef::copy() const {
  switch (type()) {
    case ValueType::kVoid: return {};
    case ValueType::kInteger: return Value::integer(as_integer());
    case ValueType::kFloat: return Value::number(as_number());
    case ValueType::kSymbol: return Value::symbol(std::string(text()));
    case ValueType::kString: return Value::string(std::string(text()));
    case ValueType::kInstanceName: return Value::instance_name(std::string(text()));
    case ValueType::kHandle: return Value::handle(as_handle());
    case ValueType::kFact: return Value::fact(fact_index());
    case ValueType::kInstance: return Value::instance_name(static_cast<const clips::Instance*>(atom_)->name->contents);
    case ValueType::kMultifield: {
      std::vector<Value> items;
      items.reserve(size_);
      for (std::size_t i = 0; i < size_; ++i) items.push_back((*this)[i].copy());
      return Value::multifield(std::move(items));
    }
  }
  return {};
}

}  // namespace cxlab
