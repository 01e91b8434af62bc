// Messages for records, logs and people.

#include <charconv>
#include <cmath>
#include <cstring>

#include "cx/bus/message.h"

namespace cxlab::bus {

namespace {

void record_element(const MessageView& message, const Field& field, std::size_t index, RecordData& data) {
  if (field.is_message())
    message.nested(field, index).record(data);
  else if (field.is_text())
    data.value(std::string_view(message.text(field, index)));
  else if (field.is_real())
    data.value(message.real(field, index));
  else if (field.type == FieldType::kBool)
    data.value(message.integer(field, index) != 0);
  else if (field.type == FieldType::kUint64)
    data.value(static_cast<std::uint64_t>(message.integer(field, index)));
  else
    data.value(message.integer(field, index));
}

void append_quoted(std::string& out, std::string_view text) {
  static constexpr std::string_view kHex = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out.append({'\\', c});
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else if (byte < 0x20 || byte == 0x7f)
      out.append({'\\', 'x', kHex[byte >> 4], kHex[byte & 15]});
    else
      out += c;
  }
  out += '"';
}

void append_real(std::string& out, const MessageView& message, const Field& field, std::size_t index) {
  const double value = message.real(field, index);
  if (std::isnan(value)) {
    out += ".nan";
  } else if (std::isinf(value)) {
    out += value > 0 ? ".inf" : "-.inf";
  } else {
    char text[32];
    const auto end = field.type == FieldType::kFloat32
                         ? std::to_chars(text, text + sizeof text, static_cast<float>(value)).ptr
                         : std::to_chars(text, text + sizeof text, value).ptr;
    const std::string_view digits(text, static_cast<std::size_t>(end - text));
    out += digits;
    if (digits.find_first_of(".e") == std::string_view::npos) out += ".0";
  }
}

void append_element(std::string& out, const MessageView& message, const Field& field, std::size_t index) {
  if (field.is_message())
    out += message.nested(field, index).to_string();
  else if (field.is_text())
    append_quoted(out, message.text(field, index));
  else if (field.is_real())
    append_real(out, message, field, index);
  else if (field.type == FieldType::kBool)
    out += message.integer(field, index) != 0 ? "true" : "false";
  else if (field.type == FieldType::kUint64)
    out += std::to_string(static_cast<std::uint64_t>(message.integer(field, index)));
  else
    out += std::to_string(message.integer(field, index));
}

}  // namespace

void MessageView::record(RecordData& data) const {
  data.open_map(type_->fields().size());
  for (const Field& field : type_->fields()) {
    data.text_key(field.name);
    if (field.type == FieldType::kFloat64 && field.array == ArrayKind::kSingle) {
      // Most fields of most messages.
      double number;
      std::memcpy(&number, memory_ + field.offset, sizeof number);
      data.value(number);
      continue;
    }
    const std::size_t count = size(field);
    if (field.array != ArrayKind::kSingle) data.open_list(count);
    for (std::size_t i = 0; i < count; ++i) record_element(*this, field, i, data);
  }
}

std::string MessageView::to_string() const {
  std::string out = "{";
  for (const Field& field : type_->fields()) {
    if (out.size() > 1) out += ", ";
    out += field.name;
    out += ": ";
    const bool list = field.array != ArrayKind::kSingle;
    if (list) out += '[';
    const std::size_t count = size(field);
    for (std::size_t i = 0; i < count; ++i) {
      if (i > 0) out += ", ";
      append_element(out, *this, field, i);
    }
    if (list) out += ']';
  }
  return out += '}';
}

}  // namespace cxlab::bus
