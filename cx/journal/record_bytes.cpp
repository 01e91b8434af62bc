#include "cx/journal/record_bytes.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "cx/base/byte_codec.h"
#include "cx/base/record_sink.h"
#include "cx/journal/journal_record.h"

namespace cxlab {
namespace {

using record_data::put;

constexpr int kDeepestRecord = 64;

enum class ItemType { kBad, kNil, kTruth, kInteger, kUnsigned, kReal, kText, kList, kMap };

struct Item {
  ItemType type = ItemType::kBad;
  std::int64_t integer = 0;  ///< also the truth, the bits of an unsigned, and the size of a list or map
  double real = 0;
  std::string_view text;
};

/// Reads the subset of MessagePack that `RecordData` writes.
class ItemReader {
 public:
  explicit ItemReader(std::string_view bytes) : in_(bytes) {}

  bool at_end() const { return in_.left() == 0; }
  std::size_t position() const { return in_.position(); }

  Item next() {
    const auto tag = in_.fixed<std::uint8_t>();
    if (!in_.ok()) return {};
    if (tag < 0x80) return {ItemType::kInteger, tag, 0, {}};
    if (tag >= 0xa0 && tag < 0xc0) return text(tag & 0x1f);
    switch (tag) {
      case 0xc0: return {ItemType::kNil, 0, 0, {}};
      case 0xc2: return {ItemType::kTruth, 0, 0, {}};
      case 0xc3: return {ItemType::kTruth, 1, 0, {}};
      case 0xcb: return whole({ItemType::kReal, 0, std::bit_cast<double>(number<std::uint64_t>()), {}});
      case 0xcf: return whole({ItemType::kUnsigned, static_cast<std::int64_t>(number<std::uint64_t>()), 0, {}});
      case 0xd2: return whole({ItemType::kInteger, static_cast<std::int32_t>(number<std::uint32_t>()), 0, {}});
      case 0xd3: return whole({ItemType::kInteger, static_cast<std::int64_t>(number<std::uint64_t>()), 0, {}});
      case 0xdb: return text(number<std::uint32_t>());
      case 0xdd: return container(ItemType::kList, number<std::uint32_t>());
      case 0xde: return container(ItemType::kMap, number<std::uint16_t>());
      case 0xdf: return container(ItemType::kMap, number<std::uint32_t>());
      default: return {};
    }
  }

 private:
  /// MessagePack is big-endian.
  template <class T>
  T number() {
    std::uint64_t value = 0;
    for (const char byte : in_.raw(sizeof(T))) value = value << 8 | static_cast<std::uint8_t>(byte);
    return static_cast<T>(value);
  }
  Item whole(const Item& item) const { return in_.ok() ? item : Item{}; }
  Item text(std::size_t size) { return whole({ItemType::kText, 0, 0, in_.raw(size)}); }
  /// Each element takes a byte at least, so a size beyond the rest is malformed (and never allocated).
  Item container(ItemType type, std::size_t size) const {
    return size > in_.left() ? Item{} : whole({type, static_cast<std::int64_t>(size), 0, {}});
  }

  ByteReader in_;
};

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

/// Room for a text with its quotes: a control character becomes six.
std::size_t text_room(std::size_t size) { return 6 * size + 2; }
/// Room for any record: every value becomes at most eight times its bytes, brackets and commas included; 32 for
/// `to_chars`.
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
  if (length == 0) return put(out, "\xef\xbf\xbd");
  if (c == '\n') return put(out, "\\n");
  if (static_cast<std::uint8_t>(c) < 0x20 || c == 0x7f) {
    const char digits[] = {kHex[static_cast<std::uint8_t>(c) >> 4], kHex[c & 15]};
    return put(put(out, "\\u00"), {digits, 2});
  }
  if (c == '"' || c == '\\') *out++ = '\\';
  return put(out, text.substr(0, length));
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
  if (std::isnan(value)) return put(out, "\"nan\"");
  if (std::isinf(value)) return put(out, value > 0 ? "\"inf\"" : "\"-inf\"");
  char* const end = std::to_chars(out, out + 32, value).ptr;
  const bool whole = std::find_if(out, end, [](char c) { return c == '.' || c == 'e'; }) == end;
  return put(end, whole ? ".0" : "");
}

/// Writes one record; `end` is where it got.
struct JsonWriter {
  ItemReader reader;
  char* end;
  const char* fault = nullptr;

  bool value(int depth) {
    const Item item = reader.next();
    if (depth > kDeepestRecord) return fail("nested too deep");
    switch (item.type) {
      case ItemType::kBad: return fail("cut off, or a byte that starts no value");
      case ItemType::kNil: end = put(end, "null"); break;
      case ItemType::kTruth: end = put(end, item.integer != 0 ? "true" : "false"); break;
      case ItemType::kInteger: end = std::to_chars(end, end + 24, item.integer).ptr; break;
      case ItemType::kUnsigned: end = std::to_chars(end, end + 24, static_cast<std::uint64_t>(item.integer)).ptr; break;
      case ItemType::kReal: end = write_number(item.real, end); break;
      case ItemType::kText: end = write_text(item.text, end); break;
      case ItemType::kList:
      case ItemType::kMap: return container(item, depth);
    }
    return true;
  }

 private:
  bool container(const Item& item, int depth) {
    const bool map = item.type == ItemType::kMap;
    *end++ = map ? '{' : '[';
    for (std::int64_t i = 0; i < item.integer; ++i) {
      if (i > 0) *end++ = ',';
      if (map) {
        const Item key = reader.next();
        if (key.type != ItemType::kText) return fail("a key that is no text");
        end = write_text(key.text, end);
        *end++ = ':';
      }
      if (!value(depth + 1)) return false;
    }
    *end++ = map ? '}' : ']';
    return true;
  }
  bool fail(const char* what) {
    fault = what;
    return false;
  }
};

/// Reads one value with all that it holds; false where the bytes are malformed.
bool decode(ItemReader& reader, RecordValue& out, int depth) {
  const Item item = reader.next();
  if (depth > kDeepestRecord) return false;
  switch (item.type) {
    case ItemType::kBad: return false;
    case ItemType::kNil: out.value = std::monostate{}; break;
    case ItemType::kTruth: out.value = item.integer != 0; break;
    case ItemType::kInteger: out.value = item.integer; break;
    case ItemType::kUnsigned:
      if (item.integer < 0)
        out.value = static_cast<std::uint64_t>(item.integer);
      else
        out.value = item.integer;
      break;
    case ItemType::kReal: out.value = item.real; break;
    case ItemType::kText: out.value = std::string(item.text); break;
    case ItemType::kList: {
      RecordValue::List list(static_cast<std::size_t>(item.integer));
      for (RecordValue& one : list)
        if (!decode(reader, one, depth + 1)) return false;
      out.value = std::move(list);
      break;
    }
    case ItemType::kMap: {
      RecordValue::Map map(static_cast<std::size_t>(item.integer));
      for (RecordValue::Entry& entry : map) {
        const Item key = reader.next();
        if (key.type != ItemType::kText) return false;
        entry.key = key.text;
        if (!decode(reader, entry.value, depth + 1)) return false;
      }
      out.value = std::move(map);
      break;
    }
  }
  return true;
}

/// The scalar under `key` of the outermost map; kBad if there is none.
Item item_in(std::string_view bytes, std::string_view key) {
  ItemReader reader(bytes);
  const Item map = reader.next();
  if (map.type != ItemType::kMap) return {};
  for (std::int64_t i = 0; i < map.integer; ++i) {
    const Item name = reader.next();
    Item value = reader.next();
    if (name.type == ItemType::kText && name.text == key) return value;
    // Items that are still to be skipped: those of a list or map, and of what they hold.
    const auto held = [](const Item& item) {
      return item.type == ItemType::kList ? item.integer : item.type == ItemType::kMap ? 2 * item.integer : 0;
    };
    for (std::int64_t skip = held(value); skip > 0; --skip) {
      value = reader.next();
      if (value.type == ItemType::kBad) return {};
      skip += held(value);
    }
    if (value.type == ItemType::kBad) return {};
  }
  return {};
}

}  // namespace

Expected<RecordValue> decode_record_data(std::string_view bytes) {
  RecordValue value;
  ItemReader reader(bytes);
  if (!decode(reader, value, 0) || !reader.at_end()) return input_error("malformed record data");
  return value;
}

std::int64_t integer_in(std::string_view bytes, std::string_view key) {
  const Item item = item_in(bytes, key);
  return item.type == ItemType::kInteger || (item.type == ItemType::kUnsigned && item.integer >= 0) ? item.integer : 0;
}

std::string_view text_in(std::string_view bytes, std::string_view key) {
  const Item item = item_in(bytes, key);
  return item.type == ItemType::kText ? item.text : std::string_view();
}

Status append_json(std::string_view bytes, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + json_room(bytes.size()));
  JsonWriter writer{ItemReader(bytes), out.data() + before};
  if (writer.value(0) && !writer.reader.at_end()) writer.fault = "bytes after its end";
  out.resize(static_cast<std::size_t>(writer.end - out.data()));
  if (writer.fault == nullptr) return {};
  return input_error(std::string("malformed record data: ") + writer.fault);
}

void append_json_string(std::string_view text, std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + text_room(text.size()));
  out.resize(static_cast<std::size_t>(write_text(text, out.data() + before) - out.data()));
}

// --- Names instead of folders

namespace {

bool is_part_of_a_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

}  // namespace

void FolderNames::add(const std::string& folder, const std::string& name) {
  if (folder.size() < 2 || folder.front() != '/') return;
  for (const auto& known : names_)
    if (known.first == folder) return;
  names_.emplace_back(folder, name);
  std::stable_sort(names_.begin(), names_.end(),
                   [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
}

const std::pair<std::string, std::string>* FolderNames::find(std::string_view text, std::size_t slash) const {
  if (slash > 0 && is_part_of_a_name(text[slash - 1])) return nullptr;
  for (const auto& name : names_) {
    const std::size_t end = slash + name.first.size();
    if (text.substr(slash).starts_with(name.first) && (end == text.size() || !is_part_of_a_name(text[end])))
      return &name;
  }
  return nullptr;
}

bool FolderNames::in_text(std::string_view text, std::string& out) const {
  out.clear();
  std::size_t done = 0;
  for (std::size_t at = text.find('/'); at != std::string_view::npos; at = text.find('/', at)) {
    const auto* name = find(text, at);
    if (name == nullptr) {
      ++at;
      continue;
    }
    out.append(text.substr(done, at - done)).append(name->second);
    done = at += name->first.size();
  }
  out.append(text.substr(done));
  return done > 0;
}

bool FolderNames::rewrite(std::string_view bytes, std::string& out) const {
  // Most records hold none: look at the slashes before anything is copied. Heads of texts are no part of names, but one
  // may look like it: the exact test follows.
  const auto may_begin = [&](std::size_t at) {
    return std::any_of(names_.begin(), names_.end(),
                       [&](const auto& name) { return bytes.substr(at).starts_with(name.first); });
  };
  std::size_t slash = bytes.find('/');
  while (slash != std::string_view::npos && !may_begin(slash)) slash = bytes.find('/', slash + 1);
  if (slash == std::string_view::npos) return false;

  std::string renamed;
  bool any = false;
  out.clear();
  for (ItemReader reader(bytes); !reader.at_end();) {
    const std::size_t begin = reader.position();
    const Item item = reader.next();
    if (item.type == ItemType::kBad) return false;
    if (item.type == ItemType::kText && in_text(item.text, renamed)) {
      any = true;
      out.append(RecordData().value(std::string_view(renamed)).bytes());
    } else {
      out.append(bytes.substr(begin, reader.position() - begin));
    }
  }
  return any;
}

}  // namespace cxlab
