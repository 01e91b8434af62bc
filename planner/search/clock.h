#pragma once
// Search along the clock: actions begin and end at the time that has been reached, and numbers have their values of
// that time. For what cannot be cut into parts without times, because numbers change all along or an end remembers its
// beginning.
//
// The search decides right after each happening, when a step may end for the first time, and when a comparison turns.
// Greedy best-first by the relaxed task in which actions are cut (the better of the state as it is and as it will be
// when all that runs has ended).

#include <functional>
#include <vector>

#include "planner/search/lazy_search.h"
#include "planner/search/loose.h"

namespace cxlab::planner {

/// One step of a plan with its times.
struct ClockStep {
  int action = -1;
  Micros start = 0, end = 0;
};

class ClockSearch {
 public:
  ClockSearch(const GroundTask& task, const Simulator& simulator, const Touches& touches);

  /// Calls `accept` with each plan that ends before `before`, until it returns true.
  SearchEnd run(const LazyOptions& options, Micros before, Budget& budget,
                const std::function<bool(const std::vector<ClockStep>&)>& accept);

 private:
  struct Running {
    int action;
    Micros start;
    DurationRange range;
    Remembered remembered;

    bool is_fixed() const { return range.least == range.most; }
    Micros first_end() const { return start + range.least; }
    Micros last_end() const { return start + range.most; }
  };
  /// A happening less than kSeparation ago.
  struct Recent {
    Micros time;
    int action;  ///< event k as -2 - k
    bool at_end;
  };
  struct Moment {
    PackedState state;
    Micros time = 0;
    int next_event = 0;
    std::vector<Running> running;  ///< by action
    std::vector<Recent> recent;
    std::vector<ClockStep> ended;  ///< since the parent
    int parent = -1;
  };

  bool begin(Moment& moment, int action) const;
  bool end(Moment& moment, std::size_t running) const;
  bool wait(Moment& moment) const;
  bool advance(Moment& moment, Micros to) const;
  bool finish(Moment& moment, std::size_t running) const;
  bool pass_event(Moment& moment) const;

  ById<double> rates(const Moment& moment) const;
  Micros next_turn(const Moment& moment, const ById<double>& rates) const;
  Micros forced(const Moment& moment) const;
  bool holds_over_all(Moment& moment) const;
  Micros clear_of_recent(const Moment& moment, int action, bool at_end) const;

  int estimate(RelaxedHeuristic& heuristic, const Moment& moment);
  std::vector<Word> key(const Moment& moment, bool with_time) const;
  bool too_late(const Moment& moment, Micros before) const;

  const GroundTask& task_;
  const Simulator& simulator_;
  const Touches& touches_;
  LooseEstimate loose_;
  std::vector<int> candidates_;  ///< actions that may begin
  ById<char> starts_by_length_;  ///< by action: its beginning reads how long it lasts, which is then the shortest
};

}  // namespace cxlab::planner
