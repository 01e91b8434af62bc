#pragma once
// What happens in a run, for the captions of its pictures and the events of its page: what its world tells
// (WorldKind::happened), and errors of its rules.

#include <string>
#include <string_view>
#include <vector>

#include "cx/journal/journal.h"
#include "cx/journal/journal_record.h"
#include "scenarios/run_page.h"

namespace cxlab {
struct Scenario;
}

namespace cxlab::lab {

struct Run;

/// Adds the events that pages and captions show of a record.
void tell(const Scenario& scenario, const JournalRecord& record, std::vector<PageEvent>& out);

/// Receives records while a run is played (`Journal::observe`), or reads those of a recorded one.
class Happenings final : public JournalListener {
 public:
  /// The scenario outlives it.
  explicit Happenings(const Scenario& scenario) : scenario_(scenario) {}
  /// All records of a run; none where it has no journal.
  void read(const Run& run);

  bool wants(std::string_view stream, RecordKind kind) const override;
  void heard(const JournalRecord& record) override { tell(scenario_, record, events_); }

  /// Whether the world tells anything at all.
  bool told_by_world() const;
  /// Those up to that time (s) which captions show, the last one first.
  std::vector<PageEvent> last(double t, std::size_t most) const;

 private:
  const Scenario& scenario_;
  std::vector<PageEvent> events_;  ///< in order of time
};

/// A listener receives the records of a journal as long as this object lives.
class Listening {
 public:
  Listening(Journal& journal, JournalListener& listener) : journal_(journal), listener_(listener) {
    journal_.observe(listener_);
  }
  ~Listening() { journal_.ignore(listener_); }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

 private:
  Journal& journal_;
  JournalListener& listener_;
};

}  // namespace cxlab::lab
