#pragma once
// Every part writes here what happened. `cx/journal` implements the sink, and the episode passes it to the parts.

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "cx/base/time.h"

namespace cxlab {

enum class RecordKind : std::uint8_t {
  kInput,
  kAssert,
  kRetract,
  kModify,
  kFire,
  kBus,
  kSkill,
  kReferee,
  kDecision,
  kControl,
  kError
};

/// The journal word of a kind: "input", "assert", ...
std::string_view to_string(RecordKind kind);

/// A stream of records: one per environment, node, world and referee. Ids are given in order of opening and never
/// reach a record: streams are known by name.
enum class StreamId : std::uint16_t {};

/// Points at one record, as a cause. `n` counts within its stream.
struct RecordRef {
  StreamId stream{};
  std::uint64_t n = 0;
};

/// Builds the data of one record as a MessagePack map, without allocating once warm:
/// `data.begin().field("order", 3).field("state", "OPEN")`.
class RecordData {
 public:
  RecordData& begin();
  /// Continues a record that was begun before.
  RecordData& begin(const RecordData& opening);
  RecordData& field(std::string_view key, std::int64_t value) { return name(key).value(value); }
  RecordData& field(std::string_view key, int value) { return name(key).value(static_cast<std::int64_t>(value)); }
  RecordData& field(std::string_view key, std::uint64_t value) { return name(key).value(value); }
  RecordData& field(std::string_view key, double value) { return name(key).value(value); }
  RecordData& field(std::string_view key, bool value) { return name(key).value(value); }
  RecordData& field(std::string_view key, std::string_view value) { return name(key).value(value); }
  RecordData& field(std::string_view key, const char* value) { return name(key).value(value); }
  template <class Pointee>
  RecordData& field(std::string_view key, Pointee* value) = delete;  // it would be a bool
  RecordData& field(std::string_view key, std::span<const double> values);

  /// A key whose value follows with `value`, `open_list`, `open_map` or `nil`.
  RecordData& name(std::string_view key);
  RecordData& value(std::int64_t value);
  RecordData& value(std::uint64_t value);
  RecordData& value(double value);
  RecordData& value(bool value);
  RecordData& value(std::string_view value) { return value_between({}, value, {}); }
  RecordData& value(const char* value) { return this->value(std::string_view(value)); }
  template <class Pointee>
  RecordData& value(Pointee* value) = delete;
  /// One text of three parts, for example a string in its quotes.
  RecordData& value_between(std::string_view before, std::string_view value, std::string_view after);
  RecordData& nil();
  /// A list of exactly `size` values that follow.
  RecordData& open_list(std::size_t size);
  /// A nested map of exactly `size` name-value pairs; values are written with `text_key` + value.
  RecordData& open_map(std::size_t size);
  RecordData& text_key(std::string_view key) { return value(key); }

  std::string_view bytes() const { return {memory_.data(), size_}; }

 private:
  /// Where the next bytes go: room for that many, which `took` then counts.
  char* room(std::size_t bytes) {
    if (memory_.size() - size_ < bytes) grow(bytes);
    return memory_.data() + size_;
  }
  RecordData& took(std::size_t bytes) {
    size_ += bytes;
    return *this;
  }
  void grow(std::size_t bytes);

  std::string memory_;  // of which the first `size_` bytes are written
  std::size_t size_ = 0;
  std::uint16_t fields_ = 0;
};

/// Takes records. A record is numbered within its stream from 0 and hashed whether or not it is written out.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  /// Opens the stream of that name, or finds it. Names: "env/<name>", "node/<name>", "world", "referee", ...
  virtual StreamId open_stream(std::string_view name) = 0;
  virtual RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                          std::span<const RecordRef> causes = {}) = 0;
};

// --- The encoding: https://github.com/msgpack/msgpack/blob/master/spec.md; the outer map is always a map 16. Inline,
// because records are a large part of the cost of a rule, and most keys are literals.

namespace record_data {

/// MessagePack is big-endian.
inline void put(char* out, std::uint64_t value) {
  if constexpr (std::endian::native == std::endian::little) value = __builtin_bswap64(value);
  std::memcpy(out, &value, sizeof value);
}
inline void put(char* out, std::uint32_t value) {
  if constexpr (std::endian::native == std::endian::little) value = __builtin_bswap32(value);
  std::memcpy(out, &value, sizeof value);
}
inline void put(char* out, std::uint16_t value) {
  if constexpr (std::endian::native == std::endian::little) value = __builtin_bswap16(value);
  std::memcpy(out, &value, sizeof value);
}
/// Returns the end of the text. The data of an empty text may be null.
inline char* put(char* out, std::string_view text) {
  if (!text.empty()) std::memcpy(out, text.data(), text.size());
  return out + text.size();
}

}  // namespace record_data

inline RecordData& RecordData::begin() {
  size_ = 0;
  fields_ = 0;
  std::memcpy(room(3), "\xde\x00", 3);
  return took(3);
}

inline RecordData& RecordData::name(std::string_view key) {
  record_data::put(memory_.data() + 1, ++fields_);
  return value(key);
}

inline RecordData& RecordData::value(std::int64_t value) {
  char* const out = room(9);
  if (value >= 0 && value < 128) {
    out[0] = static_cast<char>(value);
    return took(1);
  }
  if (value >= INT32_MIN && value <= INT32_MAX) {
    out[0] = '\xd2';
    record_data::put(out + 1, static_cast<std::uint32_t>(value));
    return took(5);
  }
  out[0] = '\xd3';
  record_data::put(out + 1, static_cast<std::uint64_t>(value));
  return took(9);
}

inline RecordData& RecordData::value(std::uint64_t value) {
  if (value <= INT64_MAX) return this->value(static_cast<std::int64_t>(value));
  char* const out = room(9);
  out[0] = '\xcf';
  record_data::put(out + 1, value);
  return took(9);
}

inline RecordData& RecordData::value(double value) {
  char* const out = room(9);
  out[0] = '\xcb';
  record_data::put(out + 1, std::bit_cast<std::uint64_t>(value));
  return took(9);
}

inline RecordData& RecordData::value(bool value) {
  *room(1) = value ? '\xc3' : '\xc2';
  return took(1);
}

inline RecordData& RecordData::value_between(std::string_view before, std::string_view value, std::string_view after) {
  const std::size_t length = before.size() + value.size() + after.size();
  char* const out = room(5 + length);
  char* text = out + 1;
  if (length < 32) {
    out[0] = static_cast<char>(0xa0 | length);
  } else {
    out[0] = '\xdb';
    record_data::put(out + 1, static_cast<std::uint32_t>(length));
    text = out + 5;
  }
  text = record_data::put(text, before);
  text = record_data::put(text, value);
  return took(static_cast<std::size_t>(record_data::put(text, after) - out));
}

inline RecordData& RecordData::nil() {
  *room(1) = '\xc0';
  return took(1);
}

inline RecordData& RecordData::open_list(std::size_t size) {
  char* const out = room(5);
  out[0] = '\xdd';
  record_data::put(out + 1, static_cast<std::uint32_t>(size));
  return took(5);
}

inline RecordData& RecordData::open_map(std::size_t size) {
  char* const out = room(5);
  out[0] = '\xdf';
  record_data::put(out + 1, static_cast<std::uint32_t>(size));
  return took(5);
}

}  // namespace cxlab
