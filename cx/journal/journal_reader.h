#pragma once
// Reads journal.jsonl back.

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/journal/journal_record.h"

namespace cxlab {

/// One line of the export. Errors say what is missing or wrong, without a line number.
Expected<JournalRecord> parse_journal_line(std::string_view line);

/// A line of the export, split but not decoded: views into the line.
struct JournalLine {
  std::string_view stream;
  std::uint64_t n = 0;
  SimTime t{};
  RecordKind kind{};
  std::string_view data;    ///< JSON, an object
  std::string_view causes;  ///< "a:1","b:2"
};
/// Splits a line that looks as the journal writes it, at a tenth of the cost of `parse_journal_line`; none for any
/// other line, whether it is a record or not.
std::optional<JournalLine> split_journal_line(std::string_view line);

/// Which records of a journal are read; what is empty takes all.
struct RecordFilter {
  std::vector<RecordKind> kinds{};
  std::string stream{};
  SimTime from = SimTime::min(), to = SimTime::max();

  bool takes(RecordKind kind) const;
  bool takes(const JournalRecord& record) const { return takes(record.kind, record.stream, record.t); }
  bool takes(RecordKind kind, std::string_view stream, SimTime t) const;
};

/// The records of a file, one after the other in order of writing. A last line that was cut off, because the process
/// was killed while writing, is left out.
class JournalReader {
 public:
  static Expected<JournalReader> open(const std::filesystem::path& path);

  /// Goes to the next line; false at the end. Lines of other kinds than those of the filter are mostly passed over.
  bool next_line(const RecordFilter& filter = {});
  const std::string& line() const { return line_; }
  /// The record of the line; the error has file and line.
  Expected<JournalRecord> record() const;

  /// The next record that the filter takes; none at the end. It mostly reads only the head of the line for records of
  /// other kinds.
  Expected<std::optional<JournalRecord>> next(const RecordFilter& filter = {});
  /// All remaining records.
  Expected<std::vector<JournalRecord>> all(const RecordFilter& filter = {});

 private:
  JournalReader(std::filesystem::path path, std::ifstream file) : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  std::ifstream file_;
  std::string line_;
  int number_ = 0;
};

/// The records of a file.
Expected<std::vector<JournalRecord>> read_journal(const std::filesystem::path& path, const RecordFilter& filter = {});

/// What the slots of a record of a fact hold, in their order: texts without their quotes.
std::vector<std::string> slot_texts(const RecordValue& fact);

/// The name of an act of a story (cx/testing/story_parts.h), whose text says what it does.
inline constexpr std::string_view kActOfStory = "story";

/// The kind of that name; none if there is none.
std::optional<RecordKind> record_kind(std::string_view word);

/// The data of a record as it stands in a line of the export.
std::string to_json(const RecordValue& value);

}  // namespace cxlab
