#pragma once
// Where two runs part, found in their journals and input logs: the folders are read once, in step.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/journal/journal_record.h"

namespace cxlab::lab {

/// The first record of a stream that one run has and the other has not.
struct Difference {
  std::string stream;
  SimTime t{};
  std::string then, now;  ///< the records, or "nothing like it"
  /// "env/main at 0.500 s: then ..., now ...".
  std::string text() const;
};

/// A record as people read it: kind and data.
std::string shown(const JournalRecord& record);

/// The first difference before `t` of two runs that should be the same up to then, as far as the first run was
/// recorded. It is found in journal.jsonl, or else in the inputs of the environments. `then_whole`: the first run was
/// not cut off.
Expected<std::optional<Difference>> difference_before(SimTime t, const std::filesystem::path& then,
                                                      const std::filesystem::path& now, bool then_whole);

/// The first difference of each stream in journal.jsonl up to `end`, in order of time. Numbers of records and what was
/// planned (`is_planned`) do not count.
Expected<std::vector<Difference>> first_differences(const std::filesystem::path& then, const std::filesystem::path& now,
                                                    SimTime end = kNever);

}  // namespace cxlab::lab
