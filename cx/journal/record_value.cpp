#include "cx/journal/record_value.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "cx/journal/record_items.h"

namespace cxlab {
namespace {

constexpr int kDeepest = 64;

Error malformed(const char* what) { return input_error(std::string("malformed record data: ") + what); }

Status decode(ItemReader& reader, RecordValue& out, int depth) {
  const Item item = reader.next();
  if (depth > kDeepest) return malformed("nested too deep");
  switch (item.type) {
    case ItemType::kBad: return malformed("cut off, or a byte that starts no value");
    case ItemType::kNil: out.value = std::monostate{}; break;
    case ItemType::kTruth: out.value = item.integer != 0; break;
    case ItemType::kInteger: out.value = item.integer; break;
    case ItemType::kUnsigned: out.value = static_cast<std::uint64_t>(item.integer); break;
    case ItemType::kReal: out.value = item.real; break;
    case ItemType::kText: out.value = std::string(item.text); break;
    case ItemType::kList: {
      RecordValue::List list;
      for (std::int64_t i = 0; i < item.integer; ++i) {
        if (Status s = decode(reader, list.emplace_back(), depth + 1); !s) return s;
      }
      out.value = std::move(list);
      break;
    }
    case ItemType::kMap: {
      RecordValue::Map map;
      for (std::int64_t i = 0; i < item.integer; ++i) {
        const Item key = reader.next();
        if (key.type != ItemType::kText) return malformed("a key that is no text");
        map.emplace_back(std::string(key.text), RecordValue{});
        if (Status s = decode(reader, map.back().second, depth + 1); !s) return s;
      }
      out.value = std::move(map);
      break;
    }
  }
  return {};
}

/// Bytes of the UTF-8 character that `text` begins with, 0 if it begins with none (RFC 3629, table in section 4).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0) == 0x80; };
  const int first = byte(0);
  const int second = byte(1);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return follows(1) ? 2 : 0;
  if (first >= 0xe0 && first <= 0xef) {
    const int low = first == 0xe0 ? 0xa0 : 0x80;
    const int high = first == 0xed ? 0x9f : 0xbf;
    return second >= low && second <= high && follows(2) ? 3 : 0;
  }
  if (first >= 0xf0 && first <= 0xf4) {
    const int low = first == 0xf0 ? 0x90 : 0x80;
    const int high = first == 0xf4 ? 0x8f : 0xbf;
    return second >= low && second <= high && follows(2) && follows(3) ? 4 : 0;
  }
  return 0;
}

// --- JSON. Written into memory that has room for the longest text, so that no character is checked for it.

/// Of a text with its quotes: a control character becomes six.
std::size_t text_room(std::size_t size) { return 6 * size + 2; }
/// Of any record: every value becomes at most eight times its bytes, brackets and commas included; 32 for `to_chars`.
std::size_t json_room(std::size_t size) { return 8 * size + 32; }

/// Whether any of eight characters is not written as it is: control characters, quotes, backslashes, all beyond ASCII.
bool any_special(std::uint64_t eight) {
  constexpr std::uint64_t kEach = 0x0101010101010101, kHigh = 0x80 * kEach;
  const auto zero = [](std::uint64_t x) { return (x - kEach) & ~x; };
  const std::uint64_t control = (eight - 0x20 * kEach) & ~eight;
  return ((eight | control | zero(eight ^ '"' * kEach) | zero(eight ^ '\\' * kEach) | zero(eight ^ 0x7f * kEach)) &
          kHigh) != 0;
}

char* write_special(std::string_view text, std::size_t length, char* out) {
  static constexpr char kHex[] = "0123456789abcdef";
  const char c = text.front();
  const auto write = [&out](std::string_view piece) {
    std::memcpy(out, piece.data(), piece.size());
    out += piece.size();
  };
  if (length == 0) {
    write("\xef\xbf\xbd");
  } else if (c == '"' || c == '\\') {
    *out++ = '\\';
    *out++ = c;
  } else if (c == '\n') {
    write("\\n");
  } else if (static_cast<std::uint8_t>(c) < 0x20 || c == 0x7f) {
    write("\\u00");
    *out++ = kHex[static_cast<std::uint8_t>(c) >> 4];
    *out++ = kHex[c & 15];
  } else {
    write(text.substr(0, length));
  }
  return out;
}

char* write_text(std::string_view text, char* out) {
  *out++ = '"';
  while (!text.empty()) {
    std::uint64_t eight;
    if (text.size() >= sizeof eight) {
      std::memcpy(&eight, text.data(), sizeof eight);
      if (!any_special(eight)) {
        std::memcpy(out, &eight, sizeof eight);
        out += sizeof eight;
        text.remove_prefix(sizeof eight);
        continue;
      }
    }
    const std::size_t length = utf8_length(text);
    out = write_special(text, length, out);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  *out++ = '"';
  return out;
}

char* write_number(double value, char* out) {
  const auto word = [out](std::string_view text) {
    std::memcpy(out, text.data(), text.size());
    return out + text.size();
  };
  if (std::isnan(value)) return word("\"nan\"");
  if (std::isinf(value)) return word(value > 0 ? "\"inf\"" : "\"-inf\"");
  char* end = std::to_chars(out, out + 32, value).ptr;
  if (std::find_if(out, end, [](char c) { return c == '.' || c == 'e'; }) == end) {
    *end++ = '.';
    *end++ = '0';
  }
  return end;
}

/// Writes one record; `end` is where it got.
struct JsonWriter {
  ItemReader reader;
  char* end;
  const char* fault = nullptr;

  bool value(int depth) {
    const Item item = reader.next();
    if (depth > kDeepest) return fail("nested too deep");
    switch (item.type) {
      case ItemType::kBad: return fail("cut off, or a byte that starts no value");
      case ItemType::kNil: return word("null");
      case ItemType::kTruth: return word(item.integer != 0 ? "true" : "false");
      case ItemType::kInteger: end = std::to_chars(end, end + 24, item.integer).ptr; return true;
      case ItemType::kUnsigned:
        end = std::to_chars(end, end + 24, static_cast<std::uint64_t>(item.integer)).ptr;
        return true;
      case ItemType::kReal: end = write_number(item.real, end); return true;
      case ItemType::kText: end = write_text(item.text, end); return true;
      case ItemType::kList:
        *end++ = '[';
        for (std::int64_t i = 0; i < item.integer; ++i) {
          if (i > 0) *end++ = ',';
          if (!value(depth + 1)) return false;
        }
        *end++ = ']';
        return true;
      case ItemType::kMap:
        *end++ = '{';
        for (std::int64_t i = 0; i < item.integer; ++i) {
          if (i > 0) *end++ = ',';
          const Item key = reader.next();
          if (key.type != ItemType::kText) return fail("a key that is no text");
          end = write_text(key.text, end);
          *end++ = ':';
          if (!value(depth + 1)) return false;
        }
        *end++ = '}';
        return true;
    }
    return false;
  }

 private:
  bool fail(const char* what) {
    fault = what;
    return false;
  }
  bool word(std::string_view text) {
    std::memcpy(end, text.data(), text.size());
    end += text.size();
    return true;
  }
};

template <class T>
const T* get(const RecordValue& map, std::string_view key) {
  const RecordValue* found = map.find(key);
  return found ? std::get_if<T>(&found->value) : nullptr;
}

}  // namespace

bool operator==(const RecordValue& a, const RecordValue& b) { return a.value == b.value; }

const RecordValue* RecordValue::find(std::string_view key) const {
  const auto* map = std::get_if<Map>(&value);
  if (!map) return nullptr;
  const auto found = std::find_if(map->begin(), map->end(), [&](const auto& entry) { return entry.first == key; });
  return found == map->end() ? nullptr : &found->second;
}

std::int64_t RecordValue::integer(std::string_view key, std::int64_t otherwise) const {
  const auto* found = get<std::int64_t>(*this, key);
  return found ? *found : otherwise;
}

double RecordValue::number(std::string_view key, double otherwise) const {
  if (const auto* whole = get<std::int64_t>(*this, key)) return static_cast<double>(*whole);
  if (const auto* large = get<std::uint64_t>(*this, key)) return static_cast<double>(*large);
  const auto* found = get<double>(*this, key);
  return found ? *found : otherwise;
}

bool RecordValue::truth(std::string_view key, bool otherwise) const {
  const auto* found = get<bool>(*this, key);
  return found ? *found : otherwise;
}

std::string_view RecordValue::text(std::string_view key, std::string_view otherwise) const {
  const auto* found = get<std::string>(*this, key);
  return found ? std::string_view(*found) : otherwise;
}

Expected<RecordValue> decode_record_data(std::string_view bytes) {
  ItemReader reader(bytes);
  RecordValue value;
  if (Status s = decode(reader, value, 0); !s) return s.error();
  if (!reader.at_end()) return malformed("bytes after its end");
  return value;
}

Status append_json(std::string_view bytes, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + json_room(bytes.size()));
  JsonWriter writer{ItemReader(bytes), out.data() + before};
  if (writer.value(0) && !writer.reader.at_end()) writer.fault = "bytes after its end";
  out.resize(static_cast<std::size_t>(writer.end - out.data()));
  return writer.fault == nullptr ? Status{} : Status{malformed(writer.fault)};
}

void append_json_string(std::string_view text, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + text_room(text.size()));
  out.resize(static_cast<std::size_t>(write_text(text, out.data() + before) - out.data()));
}

}  // namespace cxlab
