#pragma once
// Reads journal.jsonl back.

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/journal/journal_record.h"

namespace cxlab {

/// One line of the export. Errors say what is missing or wrong, without a line number.
Expected<JournalRecord> parse_journal_line(std::string_view line);

/// `while (true) { auto record = reader->next(); if (!record) return record.error(); if (!*record) break; ... }`
class JournalReader {
 public:
  static Expected<JournalReader> open(const std::filesystem::path& path);
  /// From now on `next` leaves out records of other kinds, and mostly reads no more of their lines than the head.
  void only(std::vector<RecordKind> kinds) { kinds_ = std::move(kinds); }
  /// The next record; nothing at the end. A malformed line is an error with file and line.
  Expected<std::optional<JournalRecord>> next();
  /// After the end: whether the last line was cut off (the process was killed while writing); it is not given out.
  bool cut_off() const { return cut_off_; }

 private:
  std::ifstream file_;
  std::string path_;
  std::string text_;
  std::vector<RecordKind> kinds_;  // empty: all
  int line_ = 0;
  bool cut_off_ = false;
};

/// All records of a file, in order of writing.
Expected<std::vector<JournalRecord>> read_journal(const std::filesystem::path& path);

}  // namespace cxlab
