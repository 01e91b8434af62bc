#pragma once
// Checks plans. Their meaning is that of PDDL 2.1 (Fox and Long, 2003), as the validator VAL implements it.
//
// Starts, ends, instantaneous actions and events from outside are happenings. A condition at start or end is read right
// before its happening, `over all` in the open interval between. Happenings closer than epsilon must not interfere:
// none reads or writes what another writes, except that several may increase and decrease one number. A condition reads
// all facts that it names, also those that the rest of it makes unimportant. The goal must hold after the last step and
// all events. Numbers that change continuously are linear between happenings; conditions on them are checked at every
// crossing, not by sampling.

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "planner/pddl/plan.h"
#include "planner/state/state.h"

namespace cxlab::planner {

/// Times as whole nanoseconds, so that equal is equal.
using Nanos = std::int64_t;
/// Large times, as Unix times are, to the microsecond: a double does not hold more.
inline Nanos to_nanos(double seconds) {
  return static_cast<Nanos>(std::abs(seconds) < 1e6 ? std::llround(seconds * 1e9) : std::llround(seconds * 1e6) * 1000);
}
inline double to_seconds(Nanos time) { return cxlab::to_seconds(SimTime{time}); }

/// What changes at a time without an action: timed facts, then timed values.
struct OutsideEvent {
  Nanos time = 0;
  std::vector<Change> changes;
};

struct ValidateOptions {
  double epsilon = 0.001;  ///< s that keeps interfering happenings apart
  double duration_tolerance =
      0.001;  ///< s by which a duration may miss its bounds: plans are printed with few decimals
};

/// The first thing that is wrong with a plan.
struct Violation {
  enum class Kind {
    kTime,          ///< a step begins before 0 or has no possible time
    kDuration,      ///< the duration misses its bounds
    kCondition,     ///< a condition of a step does not hold
    kEffect,        ///< a right-hand side reads a number without value
    kInterference,  ///< two happenings are closer than epsilon and interfere
    kGoal,          ///< the goal does not hold at the end
  };
  Kind kind = Kind::kCondition;
  double time = 0;          ///< s
  int step = -1;            ///< index in the plan; -1 = the goal or an event from outside
  int other_step = -1;      ///< the one it interferes with
  std::string when{};       ///< at start, over all, at end; empty where no time applies
  std::string condition{};  ///< the smallest part that does not hold, as PDDL
  std::string message{};    ///< what is wrong, with numbers and the cause
  std::string advice{};     ///< how to correct it
};

const char* to_word(Violation::Kind kind);

struct Verdict {
  bool valid = false;
  std::optional<Violation> violation;
  double makespan = 0;           ///< s
  std::optional<double> metric;  ///< value of the problem's metric, of valid plans
};

/// Checks plans of one problem. Outlived by domain and problem.
class Validator {
 public:
  /// `meter`, which may be none, outlives this: it limits what is tried for quantifiers.
  Validator(const Domain& domain, const Problem& problem, Meter* meter = nullptr);

  /// An error only if the meter is over (Failure::kOutOfBudget).
  Expected<Verdict> check(const Plan& plan, const ValidateOptions& options = {}) const;

  const Evaluator& evaluator() const { return evaluator_; }
  const State& initial() const { return initial_; }
  /// By time, each time once.
  const std::vector<OutsideEvent>& outside() const { return outside_; }
  /// What actions and events can change.
  const Symbols& fluents() const { return fluents_; }
  /// What a derived predicate depends on, directly or not.
  const Symbols& bases(PredicateId derived) const { return bases_[derived]; }

 private:
  Evaluator evaluator_;
  State initial_;
  std::vector<OutsideEvent> outside_;
  Symbols fluents_;
  ById<Symbols> bases_;
};

/// `error: ...` for people: one paragraph of message and advice.
std::string to_text(const Violation& violation);

}  // namespace cxlab::planner
