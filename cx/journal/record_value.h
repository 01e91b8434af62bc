#pragma once
// The data of a record, read back: a small tree of values. For reading (pages, why-not, tests), not for the run.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

struct RecordValue {
  using List = std::vector<RecordValue>;
  using Map = std::vector<std::pair<std::string, RecordValue>>;  ///< in the order of writing

  /// Unsigned only where an int64 is too small.
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, List, Map> value;

  /// The value under `key`, or nullptr if this is no map or has no such key.
  const RecordValue* find(std::string_view key) const;
  /// The number, string or truth under `key`, or `otherwise` if there is none of that type. An integer is a number too.
  std::int64_t integer(std::string_view key, std::int64_t otherwise = 0) const;
  double number(std::string_view key, double otherwise = 0.0) const;
  bool truth(std::string_view key, bool otherwise = false) const;
  std::string_view text(std::string_view key, std::string_view otherwise = {}) const;

  friend bool operator==(const RecordValue& a, const RecordValue& b);
};

/// Reads the bytes of a `RecordData`. Never reads beyond them, whatever they hold.
Expected<RecordValue> decode_record_data(std::string_view bytes);

/// Appends the bytes of a `RecordData` as JSON: shortest numbers that read back the same (a real keeps a point or an
/// exponent; what JSON has no number for becomes "nan", "inf" or "-inf"), always valid UTF-8 (U+FFFD for each invalid
/// byte). Fails on malformed bytes; `out` then ends with what was read before.
Status append_json(std::string_view bytes, std::string& out);
void append_json_string(std::string_view text, std::string& out);

}  // namespace cxlab
