#pragma once
// What has happened in one environment, from the records of its journal: every fact that ever was, every firing. So a
// fact is seen that lives only within one run of the rules.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cx/base/time.h"
#include "cx/engine/engine.h"
#include "cx/journal/journal_record.h"

namespace cxlab::explain {

/// A fact between two changes of it. It has no index.
struct FactVersion {
  FactCopy fact;
  SimTime from{};
  SimTime until = kNever;  ///< retracted or changed then
};

struct Firing {
  SimTime t{};
  std::string rule;
};

class History {
 public:
  struct Options {
    bool past_facts = true;  ///< else only firings are kept
    std::string rule;        ///< whose last firing is kept with its facts; may be empty
  };
  explicit History(Options options) : options_(std::move(options)) {}

  /// An assert, modify, retract or fire record of the environment.
  void add(const JournalRecord& record);

  /// In order of their beginning.
  const std::vector<FactVersion>& facts() const { return facts_; }
  const std::vector<Firing>& firings() const { return firings_; }
  /// Those of the last firing of the rule that was asked for, as they were then.
  const std::vector<FactCopy>& last_facts() const { return last_facts_; }

 private:
  struct Present {
    FactCopy fact;
    std::size_t version = 0;  // index in `facts_`
  };
  void end_version(const Present& present, SimTime t);

  Options options_;
  std::vector<FactVersion> facts_;
  std::map<std::int64_t, Present> present_;  // by number
  std::vector<Firing> firings_;
  std::vector<FactCopy> last_facts_;
};

/// Those of all environments of a run.
class Histories final : public JournalListener {
 public:
  explicit Histories(History::Options options = {}) : options_(std::move(options)) {}
  bool wants(std::string_view stream, RecordKind kind) const override;
  void heard(const JournalRecord& record) override;
  /// `stream` as in the journal.
  const History& of(const std::string& stream);

 private:
  History::Options options_;
  std::map<std::string, History> by_stream_;
};

}  // namespace cxlab::explain
