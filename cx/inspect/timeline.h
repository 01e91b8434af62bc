#pragma once
// The records of one environment's journal stream, from its start, kept as they were written.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/time.h"
#include "cx/engine/engine.h"
#include "cx/journal/journal_record.h"

namespace cxlab::inspect {

/// Records are named by `n`, as in the journal.
class Timeline {
 public:
  void add(const WrittenRecord& record);

  /// `begin()` is the first record that was kept, `end()` the one that comes next.
  std::uint64_t begin() const { return first_; }
  std::uint64_t end() const { return first_ + entries_.size(); }
  bool has(std::uint64_t n) const { return n >= begin() && n < end(); }

  /// The environment has started: what was recorded so far, before the first tick, belongs to that.
  void start_is_over() { started_ = end(); }
  bool is_of_start(std::uint64_t n) const { return !started_ || n < *started_; }

  SimTime time(std::uint64_t n) const { return entry(n).t; }
  RecordKind kind(std::uint64_t n) const { return entry(n).kind; }
  /// The template of a fact, the rule of a firing with a module other than MAIN; else empty.
  const std::string& name(std::uint64_t n) const { return names_[entry(n).name]; }
  /// The number of the fact that the record is about; 0: it is about none.
  std::int64_t fact(std::uint64_t n) const { return entry(n).fact; }
  JournalRecord read(std::uint64_t n) const;

  struct Cause {
    std::uint64_t n = 0;
    const std::string* stream = nullptr;  ///< null: this one
  };
  std::vector<Cause> causes(std::uint64_t n) const;

  /// Whether record `n` and record `m` of the other one say the same. Causes count by stream and number; those of this
  /// stream may be as far apart as `n` and `m`.
  bool same(std::uint64_t n, const Timeline& other, std::uint64_t m) const;
  bool same(std::uint64_t n, const Timeline& other) const { return same(n, other, n); }
  /// Whether the record says what `cxlab rerun` was to do then.
  bool is_planned(std::uint64_t n) const;

  /// The records that asserted, changed and retracted the fact of that number, in order.
  std::span<const std::uint64_t> changes(std::int64_t fact) const;
  /// The fact as record `n`, one of its changes, left it; as it was before, where that took it back.
  const FactCopy& fact_after(std::uint64_t n) const;
  /// Records of firings, in order.
  const std::vector<std::uint64_t>& firings() const { return firings_; }
  /// The first record after the one at which everything up to `t` has been recorded.
  std::uint64_t end_of(SimTime t) const;

 private:
  struct Entry {
    SimTime t{};
    std::size_t data = 0, causes = 0;  // where they begin
    std::int64_t fact = 0;
    std::uint32_t name = 0;
    RecordKind kind{};
  };
  struct StoredCause {
    std::uint32_t stream = 0;  // in names_
    std::uint64_t n = 0;
  };
  std::string_view data_of(std::uint64_t n) const;
  std::span<const StoredCause> causes_of(std::uint64_t n) const;
  const Entry& entry(std::uint64_t n) const { return entries_[n - first_]; }
  std::uint32_t number_of(std::string_view name);

  std::uint64_t first_ = 0;
  std::optional<std::uint64_t> started_;
  std::string stream_;
  std::vector<Entry> entries_;
  std::string data_;
  std::vector<StoredCause> causes_;
  std::deque<std::string> names_{""};
  std::map<std::string, std::uint32_t, std::less<>> numbers_{{"", 0}};
  std::vector<std::vector<std::uint64_t>> changes_;  // by number of the fact, which counts facts
  std::vector<std::uint64_t> firings_;
  mutable std::map<std::uint64_t, FactCopy> facts_;  // as changes left them, as far as somebody asked
};

/// The timelines of all environments of a run, by stream.
class Timelines final : public JournalListener {
 public:
  bool wants(std::string_view stream, RecordKind) const override { return stream.starts_with("env/"); }
  void written(const WrittenRecord& record) override;
  const Timeline& of(std::string_view stream);
  /// All environments have started; of those that come later all counts as after the start.
  void start_is_over() {
    started_ = true;
    for (auto& [stream, timeline] : by_stream_) timeline.start_is_over();
  }

 private:
  bool started_ = false;
  std::map<std::string, Timeline, std::less<>> by_stream_;
};

}  // namespace cxlab::inspect
