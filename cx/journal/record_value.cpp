#include "cx/journal/record_value.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

namespace cxlab {
namespace {

constexpr int kDeepest = 64;

Error malformed(const char* what) { return input_error(std::string("malformed record data: ") + what); }

enum class TokenType { kBad, kNil, kTruth, kInteger, kReal, kText, kList, kMap };

struct Token {
  TokenType type = TokenType::kBad;
  std::int64_t integer = 0;  ///< also the truth, and the size of a list or map
  double real = 0;
  std::string_view text;
};

/// Reads the subset of MessagePack that `RecordData` writes.
class TokenReader {
 public:
  explicit TokenReader(std::string_view bytes) : rest_(bytes) {}

  bool at_end() const { return rest_.empty(); }

  Token next() {
    if (rest_.empty()) return {};
    const auto tag = static_cast<std::uint8_t>(rest_.front());
    rest_.remove_prefix(1);
    if (tag < 0x80) return {TokenType::kInteger, tag, 0, {}};
    if (tag >= 0xa0 && tag < 0xc0) return text(tag & 0x1f);
    switch (tag) {
      case 0xc0: return {TokenType::kNil, 0, 0, {}};
      case 0xc2: return {TokenType::kTruth, 0, 0, {}};
      case 0xc3: return {TokenType::kTruth, 1, 0, {}};
      case 0xcb: {
        const auto bits = number(8);
        if (!bits) return {};
        return {TokenType::kReal, 0, std::bit_cast<double>(*bits), {}};
      }
      case 0xd2: {
        const auto bits = number(4);
        if (!bits) return {};
        return {TokenType::kInteger, static_cast<std::int32_t>(static_cast<std::uint32_t>(*bits)), 0, {}};
      }
      case 0xd3: {
        const auto bits = number(8);
        if (!bits) return {};
        return {TokenType::kInteger, static_cast<std::int64_t>(*bits), 0, {}};
      }
      case 0xdb: {
        const auto size = number(4);
        return size ? text(*size) : Token{};
      }
      case 0xdd: return container(TokenType::kList, 4);
      case 0xde: return container(TokenType::kMap, 2);
      case 0xdf: return container(TokenType::kMap, 4);
      default: return {};
    }
  }

 private:
  struct Maybe {
    bool has = false;
    std::uint64_t value = 0;
    explicit operator bool() const { return has; }
    std::uint64_t operator*() const { return value; }
  };

  Maybe number(std::size_t size) {
    if (rest_.size() < size) return {};
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8 | static_cast<std::uint8_t>(rest_[i]);
    rest_.remove_prefix(size);
    return {true, value};
  }

  Token text(std::size_t size) {
    if (rest_.size() < size) return {};
    const Token token{TokenType::kText, 0, 0, rest_.substr(0, size)};
    rest_.remove_prefix(size);
    return token;
  }

  /// Each element takes a byte at least, so a size beyond the rest is malformed (and never allocated).
  Token container(TokenType type, std::size_t size_bytes) {
    const auto size = number(size_bytes);
    if (!size || *size > rest_.size()) return {};
    return {type, static_cast<std::int64_t>(*size), 0, {}};
  }

  std::string_view rest_;
};

Status decode(TokenReader& reader, RecordValue& out, int depth) {
  const Token token = reader.next();
  if (depth > kDeepest) return malformed("nested too deep");
  switch (token.type) {
    case TokenType::kBad: return malformed("cut off, or a byte that starts no value");
    case TokenType::kNil: out.value = std::monostate{}; break;
    case TokenType::kTruth: out.value = token.integer != 0; break;
    case TokenType::kInteger: out.value = token.integer; break;
    case TokenType::kReal: out.value = token.real; break;
    case TokenType::kText: out.value = std::string(token.text); break;
    case TokenType::kList: {
      RecordValue::List list;
      for (std::int64_t i = 0; i < token.integer; ++i) {
        if (Status s = decode(reader, list.emplace_back(), depth + 1); !s) return s;
      }
      out.value = std::move(list);
      break;
    }
    case TokenType::kMap: {
      RecordValue::Map map;
      for (std::int64_t i = 0; i < token.integer; ++i) {
        const Token key = reader.next();
        if (key.type != TokenType::kText) return malformed("a key that is no text");
        map.emplace_back(std::string(key.text), RecordValue{});
        if (Status s = decode(reader, map.back().second, depth + 1); !s) return s;
      }
      out.value = std::move(map);
      break;
    }
  }
  return {};
}

void append_number(double value, std::string& out) {
  if (std::isnan(value)) {
    out += "\"nan\"";
  } else if (std::isinf(value)) {
    out += value > 0 ? "\"inf\"" : "\"-inf\"";
  } else {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    out.append(digits, end);
    if (std::find_if(digits, end, [](char c) { return c == '.' || c == 'e'; }) == end) out += ".0";
  }
}

Status append_value(TokenReader& reader, std::string& out, int depth) {
  const Token token = reader.next();
  if (depth > kDeepest) return malformed("nested too deep");
  switch (token.type) {
    case TokenType::kBad: return malformed("cut off, or a byte that starts no value");
    case TokenType::kNil: out += "null"; break;
    case TokenType::kTruth: out += token.integer != 0 ? "true" : "false"; break;
    case TokenType::kInteger: {
      char digits[24];
      out.append(digits, std::to_chars(digits, digits + sizeof digits, token.integer).ptr);
      break;
    }
    case TokenType::kReal: append_number(token.real, out); break;
    case TokenType::kText: append_json_string(token.text, out); break;
    case TokenType::kList:
      out += '[';
      for (std::int64_t i = 0; i < token.integer; ++i) {
        if (i > 0) out += ',';
        if (Status s = append_value(reader, out, depth + 1); !s) return s;
      }
      out += ']';
      break;
    case TokenType::kMap:
      out += '{';
      for (std::int64_t i = 0; i < token.integer; ++i) {
        if (i > 0) out += ',';
        const Token key = reader.next();
        if (key.type != TokenType::kText) return malformed("a key that is no text");
        append_json_string(key.text, out);
        out += ':';
        if (Status s = append_value(reader, out, depth + 1); !s) return s;
      }
      out += '}';
      break;
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
  TokenReader reader(bytes);
  RecordValue value;
  if (Status s = decode(reader, value, 0); !s) return s.error();
  if (!reader.at_end()) return malformed("bytes after its end");
  return value;
}

Status append_json(std::string_view bytes, std::string& out) {
  TokenReader reader(bytes);
  if (Status s = append_value(reader, out, 0); !s) return s;
  return reader.at_end() ? Status{} : Status{malformed("bytes after its end")};
}

void append_json_string(std::string_view text, std::string& out) {
  static constexpr char kHex[] = "0123456789abcdef";
  out += '"';
  while (!text.empty()) {
    const char c = text.front();
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      out += "\xef\xbf\xbd";
    } else if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (static_cast<std::uint8_t>(c) < 0x20 || c == 0x7f) {
      out += "\\u00";
      out += kHex[static_cast<std::uint8_t>(c) >> 4];
      out += kHex[c & 15];
    } else {
      out.append(text.substr(0, length));
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  out += '"';
}

}  // namespace cxlab
