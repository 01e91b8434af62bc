#include "cx/bus/cdr.h"

#include <algorithm>
#include <array>
#include <vector>

namespace cxlab::bus {

namespace {

constexpr std::string_view kLittleEndian("\0\1\0\0", 4);
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
    whole = whole && point <= 0x10ffff && (point < 0xd800 || point > 0xdfff);
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

class CdrReader {
 public:
  explicit CdrReader(std::string_view fields) : fields_(fields) {}

  Status read(const MessageView& message) {
    if (message.type().fields().empty()) return take(1, 1) ? Status() : cut_off(message.type().name());
    for (const Field& field : message.type().fields())
      if (Status s = read_field(message, field); !s) return s;
    return {};
  }

 private:
  Status fail(const std::string& what) const {
    return input_error(what + " at byte " + std::to_string(at_ + kLittleEndian.size()));
  }
  Status cut_off(const std::string& name) const { return fail("field '" + name + "': found the end of the bytes"); }

  /// `size` bytes from the next multiple of `alignment` on; nullptr where they are not there.
  const char* take(std::size_t size, std::size_t alignment) {
    const std::size_t begin = (at_ + alignment - 1) / alignment * alignment;
    if (begin > fields_.size() || size > fields_.size() - begin) return nullptr;
    at_ = begin + size;
    return fields_.data() + begin;
  }
  template <class T>
  bool number(T& value) {
    const char* const data = take(sizeof value, sizeof value);
    if (data) std::memcpy(&value, data, sizeof value);
    return data != nullptr;
  }

  Status read_field(const MessageView& message, const Field& field) {
    std::size_t count = message.size(field);
    if (field.is_sequence()) {
      std::uint32_t found = 0;
      if (!number(found)) return cut_off(field.name);
      const std::size_t least = field.is_text()      ? 4
                                : field.is_message() ? field.nested->serialized_min()
                                                     : field.stride;
      if ((fields_.size() - at_) / least < found)
        return fail("field '" + field.name + "': found " + std::to_string(found) +
                    " elements, more than the bytes hold,");
      count = found;
      if (Status s = message.resize(field, count); !s) return fail("field '" + field.name + "': " + s.error().message);
    }
    if (count == 0) return {};
    if (field.is_message()) {
      for (std::size_t i = 0; i < count; ++i)
        if (Status s = read(message.nested(field, i)); !s) return s;
      return {};
    }
    if (field.is_text()) {
      for (std::size_t i = 0; i < count; ++i)
        if (Status s = field.type == FieldType::kString ? read_text(message, field, i) : read_wide(message, field, i);
            !s)
          return s;
      return {};
    }
    const char* const data = take(count * field.stride, field.stride);
    if (!data) return cut_off(field.name);
    if (field.type == FieldType::kBool && std::any_of(data, data + count, [](char c) { return c != 0 && c != 1; }))
      return fail("field '" + field.name + "': found neither 0 nor 1 before");
    std::memcpy(numbers_of(message, field), data, count * field.stride);
    return {};
  }

  Status set(const MessageView& message, const Field& field, std::string_view text, std::size_t index) const {
    const Status s = message.set_text(field, text, index);
    return s ? Status() : fail("field '" + field.name + "': " + s.error().message);
  }
  Status read_text(const MessageView& message, const Field& field, std::size_t index) {
    std::uint32_t size = 0;
    if (!number(size)) return cut_off(field.name);
    const char* const data = take(size, 1);
    if (!data) return cut_off(field.name);
    std::string_view text(data, size);
    if (text.ends_with('\0')) text.remove_suffix(1);
    return set(message, field, text, index);
  }
  Status read_wide(const MessageView& message, const Field& field, std::size_t index) {
    std::uint32_t size = 0;
    if (!number(size)) return cut_off(field.name);
    if ((fields_.size() - at_) / 2 < size) return cut_off(field.name);
    std::string text;
    std::uint32_t high = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      std::uint16_t unit = 0;
      if (!number(unit)) return cut_off(field.name);
      const bool is_high = unit >= 0xd800 && unit < 0xdc00, is_low = unit >= 0xdc00 && unit < 0xe000;
      if (high && !is_low) append_utf8(0xfffd, text);
      if (is_low) append_utf8(high ? 0x10000 + ((high - 0xd800) << 10) + (unit - 0xdc00U) : 0xfffd, text);
      if (!is_high && !is_low) append_utf8(unit, text);
      high = is_high ? unit : 0;
    }
    if (high) append_utf8(0xfffd, text);
    return set(message, field, text, index);
  }

  std::string_view fields_;
  std::size_t at_ = 0;
};

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
  const std::size_t at = out_.size() - kLittleEndian.size();
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

Expected<Message> read_cdr(const MessageType& type, std::string_view value) {
  if (value.size() < kLittleEndian.size())
    return input_error("found " + std::to_string(value.size()) + " bytes, expected CDR with its header of 4");
  if (value[0] != 0 || value[1] != 1)
    return input_error("found the representation " + std::to_string(static_cast<unsigned char>(value[0])) + ' ' +
                       std::to_string(static_cast<unsigned char>(value[1])) +
                       ", expected 0 1, which is little-endian CDR");
  Message message(type);
  if (Status s = CdrReader(value.substr(kLittleEndian.size())).read(message.view()); !s) return s.error();
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
