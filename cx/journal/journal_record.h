#pragma once
// A record of the journal, for reading (pages, why-not, tests), and who hears of records while they are written.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"

namespace cxlab {

/// The data of a record as a small tree of values.
struct RecordValue {
  struct Entry;
  using List = std::vector<RecordValue>;
  using Map = std::vector<Entry>;  ///< in the order of writing

  /// Unsigned only where an int64 is too small.
  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, List, Map> value;

  /// The value under `key`, or nullptr if this is no map or has no such key.
  const RecordValue* find(std::string_view key) const;
  /// The integer or text under `key`; 0 or empty if there is none of that type.
  std::int64_t integer(std::string_view key) const;
  std::string_view text(std::string_view key) const;
  /// The number under `key`, whole or not; 0 if there is none.
  double real(std::string_view key) const;
  /// Whether the value under `key` is true.
  bool flag(std::string_view key) const;

  friend bool operator==(const RecordValue& a, const RecordValue& b);
};
struct RecordValue::Entry {
  std::string key;
  RecordValue value;
  friend bool operator==(const Entry&, const Entry&) = default;
};
/// Reads the bytes of a `RecordData`.
Expected<RecordValue> decode_record_data(std::string_view bytes);

struct JournalRecord {
  /// Names another record, which need not be exported itself.
  struct Cause {
    std::string stream;
    std::uint64_t n = 0;
    friend bool operator==(const Cause&, const Cause&) = default;
  };
  std::string stream;
  std::uint64_t n = 0;
  SimTime t{};
  RecordKind kind{};
  RecordValue data;
  std::vector<Cause> causes;
};

/// Whether it says what was planned to happen in the middle of the run (`cxlab rerun --at`).
bool is_planned(const JournalRecord& record);

class Journal;

/// A record while it is written; what it points to is there only during the call.
struct WrittenRecord {
  const Journal& journal;  ///< has the names of streams
  std::string_view stream;
  std::uint64_t n = 0;
  SimTime t{};
  RecordKind kind{};
  std::string_view data;  ///< bytes of a `RecordData`
  std::span<const RecordRef> causes;
  JournalRecord read() const;
};

/// Is called with records as they are written, whatever is exported (`Journal::observe`).
class JournalListener {
 public:
  virtual ~JournalListener() = default;
  /// Whether this one hears of a record; asked for each.
  virtual bool wants(std::string_view stream, RecordKind kind) const = 0;
  /// Reads the record and calls `heard`; one that keeps bytes overrides it.
  virtual void written(const WrittenRecord& record) { heard(record.read()); }
  virtual void heard(const JournalRecord&) {}
};

}  // namespace cxlab
