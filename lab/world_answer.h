#pragma once
// Asks a run one of the questions that its world declares (scenarios/question.h).

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/journal/journal_record.h"
#include "lab/run.h"
#include "lab/table_text.h"
#include "scenarios/question.h"

namespace cxlab::lab {

struct WorldAsk {
  std::string question, about = {};                    ///< `about`: its argument; empty: everything
  std::optional<SimTime> at = {}, from = {}, to = {};  ///< as it was then; or the stretch. Without them up to the end
};

struct WorldAnswered {
  WorldAnswer answer;
  SimTime from{}, to{};
  std::string cut_off = {};  ///< `Run::cut_off_text` if the journal ends before the time that was asked for, else empty
};

/// An error names the option ("--at") or the nearest question that this world answers.
Expected<WorldAnswered> ask_world(const Run& run, const WorldAsk& ask);

/// The names of the worlds that answer a question.
std::vector<std::string> worlds_with(const Catalogue& catalogue, const std::string& question);

/// What questions of a world need of a run in progress (`Journal::observe`).
class WorldRecords final : public JournalListener {
 public:
  bool wants(std::string_view stream, RecordKind kind) const override;
  void heard(const JournalRecord& record) override { records_.push_back(record); }
  const std::vector<JournalRecord>& all() const { return records_; }

 private:
  std::vector<JournalRecord> records_;
};

/// "up to 5:12.4:", tables and notes, in lines of at most that width.
std::string world_text(const WorldAnswered& answered, std::size_t width = kTableWidth);
/// What `--json` of the commands prints.
Json world_json(const WorldAnswered& answered);

}  // namespace cxlab::lab
