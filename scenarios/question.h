#pragma once
// Questions that a world answers about a run: `cxlab NAME RUN`, and NAME in `cxlab attach`. A world declares them
// (WorldKind::questions) and answers with tables; the caller makes text or JSON of them, in the same way for all
// worlds.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/journal/journal_record.h"

namespace cxlab {

struct Scenario;

/// One value of a table: nothing, a text, a number, or a stretch of time from the first to the second number, in s.
struct TableCell {
  using Stretch = std::pair<double, double>;
  std::variant<std::monostate, std::string, std::int64_t, double, Stretch> value;
  std::string shown;  ///< what people read instead of a text; empty: the text itself

  TableCell() = default;
  TableCell(std::string text, std::string for_people = {}) : value(std::move(text)), shown(std::move(for_people)) {}
  TableCell(std::string_view text) : value(std::string(text)) {}
  TableCell(const char* text) : value(std::string(text)) {}
  TableCell(std::int64_t number) : value(number) {}
  TableCell(int number) : value(std::int64_t{number}) {}
  TableCell(double number) : value(number) {}
  TableCell(Stretch stretch) : value(stretch) {}
  TableCell(SimTime t) : value(to_seconds(t)) {}
  bool empty() const { return value.index() == 0; }
};

/// "5:12.4", as options take it.
std::string time_text(double seconds);
inline std::string time_text(SimTime t) { return time_text(to_seconds(t)); }
/// "12.4 s".
std::string length_text(double seconds);
inline std::string length_text(SimTime t) { return length_text(to_seconds(t)); }

struct Column {
  enum class Kind : std::uint8_t {
    kText,
    kNumber,
    kTime,     ///< s of the run, shown as 5:12.4
    kStretch,  ///< of time of the run, shown as 5:12-8:00; a cell is a `TableCell::Stretch`
    kSeconds,  ///< how long, shown as 12.4 s
    kShare,    ///< 0 to 1, shown as per cent
  };
  std::string key;    ///< in JSON; of times and lengths it ends in `_s`
  std::string title;  ///< for people
  Kind kind = Kind::kText;
};

/// Texts are broken into lines where they are long, first that of the last column.
struct Table {
  std::string key;    ///< in JSON
  std::string title;  ///< a line above it; may be empty
  std::vector<Column> columns;
  std::vector<std::vector<TableCell>> rows;
};

/// Takes the column of that key out.
void drop_column(Table& table, std::string_view key);

struct WorldAnswer {
  std::vector<Table> tables;
  std::vector<std::string> notes;  ///< sentences below the tables
};

/// The kinds of the records that a world is asked about.
inline const std::vector<RecordKind> kRecordsOfQuestions{
    RecordKind::kSkill, RecordKind::kReferee, RecordKind::kDecision, RecordKind::kControl, RecordKind::kError};

/// What a question is asked about; all of it outlives the question.
struct AskedRun {
  const std::filesystem::path& folder;  ///< empty: a run in progress that has none
  const Scenario& scenario;
  /// The records of `kRecordsOfQuestions` up to `to`, in order of writing.
  const std::vector<JournalRecord>& records;
  SimTime from{};          ///< what was over before is left out; 0: nothing
  SimTime to{};            ///< the run up to this time; at most its end
  bool ended = false;      ///< `to` is the end of a run that has ended, by itself or not
  std::string_view about;  ///< the argument; empty: everything
};

/// A question of a world.
struct WorldQuestion {
  std::string_view name;           ///< of the command; worlds may share one
  std::string_view what;           ///< one line for people
  std::string_view argument = {};  ///< name of an argument that chooses a part: "robot"; empty: it takes none
  std::string_view argument_help = {};
  std::string_view examples = {};  ///< lines for `--help`
  /// An argument that names nothing is a usage error with the nearest name.
  Expected<WorldAnswer> (*ask)(const AskedRun& run) = nullptr;
};

}  // namespace cxlab
