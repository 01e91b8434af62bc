#include "cx/bus/cdr.h"

#include <algorithm>
#include <array>
#include <vector>

namespace cxlab::bus {

namespace {

constexpr std::string_view kLittleEndian("\0\1\0\0", 4);
constexpr std::size_t kHeader = kLittleEndian.size();
static_assert(std::endian::native == std::endian::little, "numbers are copied");

/// The bytes of the numbers of a field.
std::byte* numbers_of(const MessageView& message, const Field& field) {
  std::byte* const memory = message.memory() + field.offset;
  return field.is_sequence() ? reinterpret_cast<const Sequence*>(memory)->data : memory;
}

/// The units of a text as UTF-16; what is no UTF-8 becomes U+FFFD.
std::vector<std::uint16_t> utf16_of(std::string_view text) {
  std::vector<std::uint16_t> units;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xc2 ? 0
                               : first < 0xe0 ? 2
                               : first < 0xf0 ? 3
                               : first < 0xf5 ? 4
                                              : 0;
    std::uint32_t point = length == 1 ? first : first & (0x7fU >> length);
    bool whole = length > 0 && text.size() - i >= length;
    for (std::size_t k = 1; whole && k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      whole = (next & 0xc0U) == 0x80;
      point = point << 6 | (next & 0x3fU);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};  // shorter sequences have what is below
    whole = whole && point >= kLeast[length] && point <= 0x10ffff && (point < 0xd800 || point > 0xdfff);
    if (!whole) point = 0xfffd;
    i += whole ? length : 1;
    if (point >= 0x10000) {
      units.push_back(static_cast<std::uint16_t>(0xd800 + ((point - 0x10000) >> 10)));
      point = 0xdc00 + ((point - 0x10000) & 0x3ffU);
    }
    units.push_back(static_cast<std::uint16_t>(point));
  }
  return units;
}

void append_utf8(std::uint32_t point, std::string& out) {
  const auto tail = [&](int shift) { out += static_cast<char>(0x80U | (point >> shift & 0x3fU)); };
  if (point < 0x80) {
    out += static_cast<char>(point);
  } else if (point < 0x800) {
    out += static_cast<char>(0xc0U | point >> 6);
    tail(0);
  } else if (point < 0x10000) {
    out += static_cast<char>(0xe0U | point >> 12);
    tail(6), tail(0);
  } else {
    out += static_cast<char>(0xf0U | point >> 18);
    tail(12), tail(6), tail(0);
  }
}

void collect(const MessageType& type, std::vector<const MessageType*>& types) {
  if (std::ranges::find(types, &type) != types.end()) return;
  types.push_back(&type);
  for (const Field& field : type.fields())
    if (field.nested) collect(*field.nested, types);
}

/// A constant's text in quotes, for readers of definitions.
std::string text_literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

}  // namespace

CdrWriter::CdrWriter(std::string& out) : out_(out) { out_.assign(kLittleEndian); }

CdrWriter& CdrWriter::raw(const void* data, std::size_t size, std::size_t alignment) {
  const std::size_t at = out_.size() - kHeader;
  out_.append((alignment - at % alignment) % alignment, '\0');
  out_.append(static_cast<const char*>(data), size);
  return *this;
}

CdrWriter& CdrWriter::text(std::string_view text) {
  size(text.size() + 1);
  out_.append(text).push_back('\0');
  return *this;
}

void CdrWriter::wide_text(std::string_view text) {
  const std::vector<std::uint16_t> units = utf16_of(text);
  size(units.size());
  for (const std::uint16_t unit : units) number(unit);
}

CdrWriter& CdrWriter::message(const MessageView& message) {
  if (message.type().fields().empty()) return number(std::uint8_t{0});
  for (const Field& field : message.type().fields()) {
    const std::size_t count = message.size(field);
    if (field.is_sequence()) size(count);
    if (count == 0) continue;
    if (field.is_message()) {
      for (std::size_t i = 0; i < count; ++i) this->message(message.nested(field, i));
    } else if (field.is_text()) {
      for (std::size_t i = 0; i < count; ++i)
        field.type == FieldType::kString ? static_cast<void>(text(message.text(field, i)))
                                         : wide_text(message.text(field, i));
    } else {
      raw(numbers_of(message, field), count * field.stride, field.stride);
    }
  }
  return *this;
}

CdrReader::CdrReader(std::string_view value) {
  if (value.size() < kHeader)
    status_ = input_error(found_expected(std::to_string(value.size()) + " bytes", "CDR with its header of 4"));
  else if (value[0] != 0 || (value[1] != 0 && value[1] != 1))
    status_ = input_error(found_expected("the representation " + std::to_string(static_cast<unsigned char>(value[0])) +
                                             ' ' + std::to_string(static_cast<unsigned char>(value[1])),
                                         "0 0 or 0 1, which is big-endian or little-endian CDR"));
  else
    fields_ = value.substr(kHeader), big_endian_ = value[1] == 0;
}

void CdrReader::copy_numbers(void* to, const char* from, std::size_t count, std::size_t stride) const {
  std::memcpy(to, from, count * stride);
  if (!big_endian_ || stride == 1) return;
  auto* const bytes = static_cast<char*>(to);
  for (std::size_t i = 0; i < count; ++i) std::reverse(bytes + i * stride, bytes + (i + 1) * stride);
}

void CdrReader::fail(const std::string& what) {
  if (!status_) return;
  status_ = input_error((field_.empty() ? "" : "field '" + field_ + "': ") + what + ", at byte " +
                        std::to_string(at_ + kHeader));
}

const char* CdrReader::take(std::size_t size, std::size_t alignment) {
  if (!status_) return nullptr;
  const std::size_t begin = (at_ + alignment - 1) / alignment * alignment;
  if (begin > fields_.size() || size > fields_.size() - begin) {
    fail("found the end of the bytes");
    return nullptr;
  }
  at_ = begin + size;
  return fields_.data() + begin;
}

CdrReader& CdrReader::size(std::uint32_t& size, std::uint32_t most) {
  number(size);
  if (size > most) fail(found_expected(std::to_string(size) + " elements", "at most " + std::to_string(most)));
  return *this;
}

CdrReader& CdrReader::text(std::string_view& text) {
  std::uint32_t size = 0;
  number(size);
  const char* const data = take(size, 1);
  text = data ? std::string_view(data, size) : std::string_view();
  if (text.ends_with('\0')) text.remove_suffix(1);
  return *this;
}

CdrReader& CdrReader::bytes(std::string& bytes, std::size_t size) {
  if (const char* const data = take(size, 1)) bytes.assign(data, size);
  return *this;
}

CdrReader& CdrReader::message(const MessageView& message) {
  if (message.type().fields().empty()) {
    field_ = message.type().name();
    take(1, 1);
  }
  for (const Field& field : message.type().fields()) {
    if (!status_) break;
    field_ = field.name;
    read_field(message, field);
  }
  return *this;
}

void CdrReader::read_field(const MessageView& message, const Field& field) {
  std::size_t count = message.size(field);
  if (field.is_sequence()) {
    std::uint32_t found = 0;
    number(found);
    const std::size_t least = field.is_text() ? 4 : field.is_message() ? field.nested->serialized_min() : field.stride;
    if ((fields_.size() - at_) / least < found)
      return fail("found " + std::to_string(found) + " elements, more than the bytes hold");
    count = found;
    if (Status s = message.resize(field, count); !s) return fail(s.error().message);
  }
  if (!field.is_message() && !field.is_text()) return read_numbers(message, field, count);
  std::string wide;
  for (std::size_t i = 0; i < count && status_; ++i) {
    if (field.is_message()) {
      this->message(message.nested(field, i));
      continue;
    }
    std::string_view text;
    field.type == FieldType::kString ? static_cast<void>(this->text(text)) : read_wide(wide);
    if (!status_) return;
    const Status s = message.set_text(field, field.type == FieldType::kString ? text : wide, i);
    if (!s) fail(s.error().message);
  }
}

void CdrReader::read_numbers(const MessageView& message, const Field& field, std::size_t count) {
  const char* const data = count > 0 ? take(count * field.stride, field.stride) : nullptr;
  if (!data) return;
  if (field.type == FieldType::kBool)
    if (const char* const other = std::find_if(data, data + count, [](char c) { return c != 0 && c != 1; });
        other != data + count) {
      at_ -= static_cast<std::size_t>(data + count - other);
      return fail(found_expected(std::to_string(static_cast<unsigned char>(*other)), "0 or 1 for a bool"));
    }
  copy_numbers(numbers_of(message, field), data, count, field.stride);
}

void CdrReader::read_wide(std::string& text) {
  std::uint32_t size = 0;
  number(size);
  if ((fields_.size() - at_) / 2 < size) return fail("found the end of the bytes");
  text.clear();
  std::uint32_t high = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    std::uint16_t unit = 0;
    number(unit);
    const bool is_high = unit >= 0xd800 && unit < 0xdc00, is_low = unit >= 0xdc00 && unit < 0xe000;
    if (high && !is_low) append_utf8(0xfffd, text);
    if (is_low) append_utf8(high ? 0x10000 + ((high - 0xd800) << 10) + (unit - 0xdc00U) : 0xfffd, text);
    if (!is_high && !is_low) append_utf8(unit, text);
    high = is_high ? unit : 0;
  }
  if (high) append_utf8(0xfffd, text);
}

Expected<Message> read_cdr(const MessageType& type, std::string_view value) {
  Message message(type);
  CdrReader in(value);
  if (!in.message(message.view()).status()) return in.status().error();
  return message;
}

std::string ros2msg_name(std::string_view type) {
  std::string name(type);
  const std::size_t first = name.find('/'), second = name.find('/', first + 1);
  if (second != name.npos) name.erase(first, second - first);
  return name;
}

std::string ros2msg_text(const MessageType& type) {
  std::string out;
  for (const Constant& constant : type.constants())
    out +=
        std::string(to_string(constant.type)) + ' ' + constant.name + '=' +
        (constant.type == FieldType::kString || constant.type == FieldType::kWstring ? text_literal(constant.value_text)
                                                                                     : constant.value_text) +
        '\n';
  for (const Field& field : type.fields()) {
    std::string name = field.type_text();
    if (field.nested) name.replace(0, field.nested->name().size(), ros2msg_name(field.nested->name()));
    out += name + ' ' + field.name + '\n';
  }
  return out;
}

std::string ros2msg_schema(std::string text, std::span<const MessageType* const> uses) {
  std::vector<const MessageType*> types;
  for (const MessageType* type : uses) collect(*type, types);
  for (const MessageType* type : types)
    text += std::string(80, '=') + "\nMSG: " + ros2msg_name(type->name()) + '\n' + ros2msg_text(*type);
  return text;
}

std::string ros2msg_schema(const MessageType& type) {
  std::vector<const MessageType*> uses;
  for (const Field& field : type.fields())
    if (field.nested) uses.push_back(field.nested);
  return ros2msg_schema(ros2msg_text(type), uses);
}

}  // namespace cxlab::bus
