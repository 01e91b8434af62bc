#pragma once
// A record of the journal, read back; and who hears of records while they are written.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/journal/record_value.h"

namespace cxlab {

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

/// Is called with records as they are written, whatever is exported (`Journal::set_listener`).
class JournalListener {
 public:
  virtual ~JournalListener() = default;
  /// Whether `heard` is to be called; asked for each record.
  virtual bool wants(std::string_view stream, RecordKind kind) const = 0;
  virtual void heard(const JournalRecord& record) = 0;
};

}  // namespace cxlab
