#pragma once
// Where everybody writes what happened. `cx/journal` implements it; an episode hands it in.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cx/base/time.h"

namespace cxlab {

enum class RecordKind : std::uint8_t {
  kInput, kAssert, kRetract, kModify, kFire, kBus, kSkill, kReferee, kDecision, kControl, kError
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
  RecordData& field(std::string_view key, std::int64_t value) { return name(key).value(value); }
  RecordData& field(std::string_view key, int value) { return name(key).value(static_cast<std::int64_t>(value)); }
  RecordData& field(std::string_view key, std::uint64_t value) { return name(key).value(static_cast<std::int64_t>(value)); }
  RecordData& field(std::string_view key, double value) { return name(key).value(value); }
  RecordData& field(std::string_view key, bool value) { return name(key).value(value); }
  RecordData& field(std::string_view key, std::string_view value) { return name(key).value(value); }
  RecordData& field(std::string_view key, const char* value) { return name(key).value(std::string_view(value)); }
  RecordData& field(std::string_view key, std::span<const double> values);

  /// A key whose value follows with `value`, `open_list`, `open_map` or `nil`.
  RecordData& name(std::string_view key);
  RecordData& value(std::int64_t value);
  RecordData& value(double value);
  RecordData& value(bool value);
  RecordData& value(std::string_view value);
  RecordData& nil();
  /// A list of exactly `size` values that follow.
  RecordData& open_list(std::size_t size);
  /// A nested map of exactly `size` name-value pairs; values are written with `text_key` + value.
  RecordData& open_map(std::size_t size);
  RecordData& text_key(std::string_view key) { return value(key); }

  std::string_view bytes() const { return bytes_; }

 private:
  void put_be(std::uint64_t value, int size);
  std::string bytes_;
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

}  // namespace cxlab
