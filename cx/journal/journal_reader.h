#pragma once
// Reads journal.jsonl back.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/journal/journal_record.h"

namespace cxlab {

/// One line of the export. Errors say what is missing or wrong, without a line number.
Expected<JournalRecord> parse_journal_line(std::string_view line);

/// The records of a file in order of writing, only those of `kinds` (none: all): of others mostly no more is read than
/// the head of the line. A malformed line is an error with file and line. A last line that was cut off, because the
/// process was killed while writing, is left out.
Expected<std::vector<JournalRecord>> read_journal(const std::filesystem::path& path,
                                                  const std::vector<RecordKind>& kinds = {});

/// What the slots of a record of a fact hold, in their order: texts without their quotes.
std::vector<std::string> slot_texts(const RecordValue& fact);

/// The data of a record as it stands in a line of the export.
std::string to_json(const RecordValue& value);

}  // namespace cxlab
