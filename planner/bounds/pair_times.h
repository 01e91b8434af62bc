#pragma once
// Earliest times at which two things can be so together (h2 with time, Haslum and Geffner 2001; here on the happenings
// of PDDL 2.1).
//
// Atoms are the facts and, for each durative action, that it is running. No plan has atoms p and q together before
// `time(p, q)`. A happening is a beginning, an end, an instantaneous action, or an event. Let a happening at time t add
// p. Then q is true beside p only if q was true before t, together with all that the happening needs, and the happening
// does not remove q. It removes the atom that b is running if it makes false what b needs over all. A beginning also
// needs what must hold from then on, unless some beginning can add it: two actions that begin at one instant may each
// add what the other needs. For a run of an action and an atom there is a second time: the earliest end of a run during
// which the atom was true at some time.
//
// Why no plan is quicker, by induction over the instants of a plan. Let p and q be true right after instant t. If
// nothing changed them at t they were true before. Assume that x added p and q was true before. Then q was true with
// all that x needs, because needs are read right before t and nothing else at t touches them. Assume that x added p and
// y added q. Then we may say that x happens before y. The needs of y were true before t, and x does not touch them, so
// they are true beside p. That order fails only where x and y are ends and each makes false what the other needs over
// all, since over all spares the instant of the end. Such ends are happenings of their own, both at once. Those in
// which both also change the same fact are left out (`assumes_order`): validators differ on whether they may share an
// instant, and no plan with them bears any shift. Runs of one ground action may overlap if its beginning can happen
// while it runs. A conditional effect may add and never removes. Numbers are not followed: comparisons hold from
// `released` on.

#include <cstdint>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/ground/task.h"

namespace cxlab::planner {

/// Times in units of so many microseconds, so that they fit 32 bits.
using PairTime = std::int32_t;

/// What happens at one instant.
struct PairHappening {
  std::vector<int> needs;  ///< atoms true right before; of an end: also its conditions over all, and that it runs
  std::vector<int> adds, removes;  ///< atoms; a beginning adds that its action runs, an end removes it
  std::vector<int> ends;           ///< runs that end now
  int begins = -1;                 ///< run that begins now
  PairTime lasts = 0;              ///< of a beginning: at least
  PairTime release = 0;            ///< not before
  bool fixed = false;              ///< an event: at `release`
};

/// The happenings of a task without derived facts.
class HappeningTask {
 public:
  /// `durations` by action, at least; `released` by comparison, earliest times. `unit` in microseconds; all is rounded
  /// down. Not to be used if the time runs out.
  HappeningTask(const GroundTask& task, const std::vector<Micros>& durations, const ById<Micros>& released, Micros unit,
                Budget& budget);

  int facts() const { return facts_; }
  int runs() const { return runs_; }
  int atoms() const { return facts_ + runs_; }
  const ById<PairHappening>& happenings() const { return happenings_; }
  const std::vector<int>& readers(int atom) const { return readers_[atom]; }  ///< happenings that need it
  const std::vector<int>& without_needs() const { return without_needs_; }
  const std::vector<int>& ends_of(int run) const { return ends_of_[run]; }  ///< happenings that end it
  int beginning(int action) const { return beginnings_[action]; }           ///< happening
  bool ends_itself(int run) const { return ends_itself_[run]; }  ///< no other run of the action outlives its end
  const ById<char>& initial() const { return initial_; }
  /// Runs that change the same fact as they end, where only together they could end at all.
  const std::vector<std::pair<int, int>>& left_out() const { return left_out_; }

 private:
  void add_conditional(const GroundAction& action, int begin, int end);
  void find_breaks(const GroundTask& task, const ById<int>& action_of_run, const ById<int>& end_of_run, Budget& budget);

  int facts_ = 0, runs_ = 0;
  ById<PairHappening> happenings_;
  ById<int> beginnings_, without_needs_;
  ById<std::vector<int>> readers_, ends_of_;
  ById<char> initial_, ends_itself_;
  std::vector<std::pair<int, int>> left_out_;
};

class PairTimes {
 public:
  static constexpr PairTime kNever = 1 << 30;
  static constexpr PairTime kMost = 1 << 29;  ///< later times count as this one

  explicit PairTimes(const HappeningTask& task);

  /// Memory of one, in bytes, and work of looking once at each happening, in pieces of Work::kBound.
  static std::size_t bytes(const HappeningTask& task);
  static std::int64_t round_work(const HappeningTask& task);

  /// From the initial state. False if the slice of the budget ended: then no time holds.
  bool solve(Budget& budget);
  /// From right after the beginning of an action in any plan: all may be true that `all`, from the initial state, does
  /// not rule out.
  bool solve_after(int action, const PairTimes& all, Budget& budget);

  PairTime time(int p, int q) const {
    return pairs_[static_cast<std::size_t>(p) * width_ + static_cast<std::size_t>(q)];
  }
  /// When all of them can be true, judged by pairs.
  PairTime time(const std::vector<int>& atoms) const;
  /// When an action can begin.
  PairTime beginning(int action) const;
  /// Whether the times hold only for plans in which no two actions change the same fact at the same instant.
  bool assumes_order() const;

 private:
  PairTime* pairs(int atom) { return pairs_.data() + static_cast<std::size_t>(atom) * width_; }
  PairTime* ends(int run) { return ends_.data() + static_cast<std::size_t>(run) * width_; }
  PairTime* ends_by_atom(int atom) { return ends_by_atom_.data() + static_cast<std::size_t>(atom) * run_width_; }
  bool settle(Budget& budget);
  void apply(int happening);
  void queue(int happening);
  void queue_readers(int atom);
  void lower_pair(int p, int q, PairTime to);
  void lower_end(int run, int atom, PairTime to);

  const HappeningTask& task_;
  std::size_t width_, run_width_;
  std::vector<PairTime> pairs_;         ///< atom, atom
  ById<PairTime> ends_;                 ///< run, atom: earliest end of a run with the atom in it
  std::vector<PairTime> ends_by_atom_;  ///< the same by atom, run
  ById<PairTime> single_;               ///< time(p, p)
  ById<char> overlaps_itself_;
  bool timed_ = true;  ///< releases count
  ById<char> queued_;
  std::vector<int> queue_;
  ById<PairTime> beside_, end_beside_;
  std::int64_t work_ = 0;  ///< entries looked at
};

}  // namespace cxlab::planner
