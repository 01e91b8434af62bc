#pragma once
// The history of one environment from the records of its journal: every fact that ever existed, and every firing. It
// includes facts that live only within one run of the rules.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
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
  std::string rule, module;
  std::vector<std::int64_t> facts{};  ///< numbers of its facts; only of the rule that was asked for
  std::uint64_t n = 0;                ///< of its record
  /// Whether `name`, with or without a module, stands for its rule.
  bool is_of(std::string_view name) const;
};

/// The module of a firing's rule.
std::string module_of(const JournalRecord& firing);

class History {
 public:
  struct Options {
    bool past_facts = true;  ///< else only firings are kept
    std::string rule;        ///< without a module: whose firings are kept with their facts; may be empty
  };
  explicit History(Options options) : options_(std::move(options)) {}

  /// An assert, modify, retract or fire record of the environment.
  void add(const JournalRecord& record);

  /// In order of their beginning.
  const std::vector<FactVersion>& facts() const { return facts_; }
  const std::vector<Firing>& firings() const { return firings_; }
  /// The facts of the last firing of the wanted rule in that module, as they were then.
  const std::vector<FactCopy>& last_facts(const std::string& module) const;
  /// The last firing of that rule for facts of these numbers since the last of them changed; null if there is none.
  const Firing* fired_for(const std::string& module, const std::vector<std::int64_t>& facts) const;
  /// Whether there ever was a fact of that template.
  bool ever(const std::string& template_name) const { return templates_.contains(template_name); }

 private:
  struct Present {
    FactCopy fact;
    std::size_t version = 0;  // index in `facts_`
    std::uint64_t n = 0;      // of the record of its last change
  };
  void end_version(const Present& present, SimTime t);

  Options options_;
  std::vector<FactVersion> facts_;
  std::map<std::int64_t, Present> present_;  // by number
  std::vector<Firing> firings_;
  std::map<std::string, std::vector<FactCopy>> last_facts_;  // by module
  std::set<std::string> templates_;
};

/// The histories of all environments of a run.
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
