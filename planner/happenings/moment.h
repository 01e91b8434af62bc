#pragma once
// The state right after some happenings, without their exact times: facts, numbers as they depend on the times, running
// actions, and the distances that the times must keep. A step from one moment to the next adds one happening: a start
// or an end of an action, or an event. It is later than the last one or at the same instant.

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planner/ground/budget.h"
#include "planner/happenings/timed_number.h"
#include "planner/happenings/zone.h"
#include "planner/schedule/timeline.h"
#include "planner/search/simulator.h"

namespace cxlab::planner {

struct Happening {
  enum class Kind : std::uint8_t { kStart, kEnd, kEvent };
  Kind kind = Kind::kStart;
  int index = -1;        ///< an action; a place in Moment::running; an event
  bool at_once = false;  ///< at the instant of the last happening, with which it does not interfere
  bool beyond = false;   ///< of copies that are not followed one by one; index of kEnd is then the action
};

struct Moment {
  struct Running {
    int action = -1;
    int start = -1;  ///< point; -1: no longer of interest
    int end = -1;    ///< point, to come
    Remembered remembered;
  };
  /// A happening from which others may have to keep their distance.
  struct Recent {
    int action = -1;  ///< event k as -2 - k
    bool at_end = false;
    int point = -1;
    std::vector<int> fired;  ///< its effects under conditions that came about
  };

  PackedState state;                                 ///< numbers that depend on times are not in it
  std::vector<std::pair<int, TimedNumber>> varying;  ///< numbers that depend on times; ascending
  int next_event = 0;
  std::vector<Running> running;  ///< by action
  std::vector<int> beyond;       ///< actions of which any number of further copies may run; ascending
  std::vector<int> joining;      ///< those whose further copies began at this instant and last longer; ascending
  std::vector<Recent> recent;
  std::vector<TimedDemand> demands;  ///< that are no distances of two points
  /// A step of the plan, with how long it may last; noted where no point is forgotten.
  struct Noted {
    int action = -1;
    int start = -1, end = -1;  ///< points; the same of what takes no time
    DurationRange range;
  };
  std::vector<Noted> steps;
  Zone zone;
  int origin = -1;  ///< point; -1: no longer of interest
  int now = -1;     ///< point
  int last = 0;     ///< rank of the last happening, by which those of one instant are ordered
  /// Whether time may pass: no condition over all is broken. Where that depends on numbers it is looked at when it
  /// passes.
  bool may_pass = true;
  bool may_join = false;  ///< happenings at the same instant may be needed
};

/// How moments follow each other.
class Moments {
 public:
  struct Options {
    Micros separation = kSeparation;
    /// Asks for less than PDDL does, so that a goal out of reach has no plan. If rounding could decide, it decides for
    /// a plan. Copies beyond the first are not followed one by one.
    bool relaxed = false;
    bool certain = false;          ///< what only validators keep apart counts where it is certain
    int copies = 3;                ///< of one action that run at once, at most
    bool keep_origin = false;      ///< distances from the start of the plan matter
    bool keep_everything = false;  ///< no point is forgotten
  };

  /// Spends what it does; where the budget ends, the rest of a step is left out.
  Moments(const GroundTask& task, const Simulator& simulator, Budget& budget, Options options);
  Moments(const Moments&) = delete;
  Moments& operator=(const Moments&) = delete;

  Moment initial() const;
  /// All happenings that may come next, judged by facts.
  std::vector<Happening> happenings(const Moment& moment) const;
  /// Where a step depends on the sign of a number that depends on times, it is taken once for each sign.
  using Signs = std::vector<int>;
  /// Takes a step with these signs. False if it cannot be taken: `moment` is then not to be used. `open`: more signs
  /// are to be chosen.
  bool step(Moment& moment, const Happening& happening, const Signs& signs, bool& open) const;
  /// Calls `visit` with each moment after that happening, and the signs that lead there.
  template <class Visit>
  void each_after(const Moment& moment, const Happening& happening, const Visit& visit) const {
    Signs signs;
    each_after(moment, happening, signs, visit);
  }
  /// The moment after all events to come, if a plan may end here: nothing runs, and then the goal holds.
  std::optional<Moment> at_goal(const Moment& moment) const;
  /// Times of all points of a moment of which everything was kept: that of `last` as early as it can be, then each as
  /// early as that allows. None if rounding leaves none.
  std::optional<ById<Micros>> times(const Moment& moment, int last) const;

  /// Whether everything that a plan can do was followed; false from the first step on that was left out.
  bool complete() const { return complete_; }
  /// Whether a start was left out because too many copies of its action run.
  bool capped() const { return capped_; }
  /// Whether more than the bounds of its duration depend on how long an action lasts.
  bool reads_duration(int action) const { return reads_duration_[action] != 0; }

 private:
  template <class Visit>
  void each_after(const Moment& moment, const Happening& happening, Signs& signs, const Visit& visit) const {
    Moment after = moment;
    bool open = false;
    if (step(after, happening, signs, open)) {
      visit(std::move(after), signs);
      return;
    }
    if (!open) return;
    if (signs.size() == kMostSigns || budget_.over()) {
      leave_out();
      return;
    }
    for (const int sign : {-1, 0, 1}) {
      signs.push_back(sign);
      each_after(moment, happening, signs, visit);
      signs.pop_back();
    }
  }
  static constexpr std::size_t kMostSigns = 12;

  /// One step that is being taken.
  struct Step {
    Moment& moment;
    const Signs& signs;
    std::size_t used = 0;
    bool open = false;
  };

  std::optional<TimedNumber> evaluate(const Moment& moment, const GroundExpression& expression,
                                      const TimedNumber& duration) const;
  /// The value that decides about a comparison; a constant where no time matters.
  std::optional<TimedNumber> gap(const Moment& moment, int comparison, const TimedNumber& duration) const;
  TimedNumber number(const Moment& moment, int number) const;
  void set_number(Moment& moment, int number, TimedNumber value) const;
  static TimedNumber duration(const Moment& moment, const Moment::Running& running);

  bool accepts(int comparison, double gap) const;
  bool demand(Moment& moment, TimedDemand demand) const;
  bool demand(Moment& moment, const GroundCondition& condition, const TimedNumber& duration) const;
  /// Whether a condition holds; chooses signs.
  std::optional<bool> holds(Step& step, const GroundCondition& condition, const TimedNumber& duration) const;
  std::optional<int> sign(Step& step, const TimedNumber& value) const;
  bool derive(Step& step) const;

  bool pass_to(Step& step, int point, int ending) const;
  int most_copies(const GroundAction& action) const;
  std::optional<double> room(const LinearForm& gap, const GroundAction& action) const;
  bool may_hold(const Moment& moment, const GroundCondition& over_all, const ById<char>& changes) const;
  void let_beyond_pass(Moment& moment, const ById<char>& changes) const;
  ById<char> changing_numbers(const Moment& moment) const;
  bool conflict(const Moment::Recent& one, const Moment::Recent& other) const;
  bool keep_clear(Moment& moment, const Moment::Recent& happening) const;
  bool start(Step& step, const Happening& happening) const;
  bool end(Step& step, const Happening& happening) const;
  bool event(Step& step, const Happening& happening) const;
  bool apply(Step& step, const GroundEffects& effects, const TimedNumber& duration) const;
  bool limit_duration(Moment& moment, const Moment::Running& running, bool at_end) const;
  void judge(Moment& moment) const;
  bool tidy(Moment& moment) const;
  std::optional<ById<double>> solve(const Moment& moment, int least) const;
  bool fix(Moment& moment, int point, Micros time) const;
  bool is_needless(const Moment& moment, int action) const;
  int rank(const Happening& happening, const Moment& moment) const;
  bool leave_out() const {
    complete_ = false;
    return false;
  }

  const GroundTask& task_;
  const Simulator& simulator_;
  Budget& budget_;
  const Touches touches_;
  const Options options_;
  ById<int> candidates_;        ///< actions that may begin
  ById<char> repeats_nothing_;  ///< by action: once it has been done, doing it again changes nothing
  ById<char> reads_duration_;   ///< by action: also its end does, or limits it
  ById<int> most_at_once_;      ///< by action: how many of its copies can begin or run at one instant
  bool axioms_read_numbers_ = false;
  mutable bool complete_ = true, capped_ = false;
};

}  // namespace cxlab::planner
