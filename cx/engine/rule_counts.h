#pragma once
// What rules, their conditions and deffunctions have done since an engine was asked to count (`RuleEngine::count`).

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/time.h"
#include "cx/engine/construct_info.h"

namespace cxlab {

enum class Counting : std::uint8_t {
  kNothing,
  kUse,    ///< activations, firings, calls, partial matches
  kTimes,  ///< also the time of this thread that each of them takes
};

/// How long something was at work, and how often the clock was read for it: that takes time, too.
struct WorkTime {
  double s = 0, reads = 0;
  WorkTime& operator+=(const WorkTime& other) {
    s += other.s;
    reads += other.reads;
    return *this;
  }
  friend WorkTime operator/(WorkTime time, double by) { return {time.s / by, time.reads / by}; }
};

/// A join of CLIPS: one condition of a rule, to which CLIPS adds the `test` conditions that follow it. All conditions
/// inside one `not`, `exists` or `forall` are one join together.
struct JoinCounts {
  std::int64_t passed = 0;    ///< partial matches that have got through since the join was made
  std::int64_t compared = 0;  ///< pairs of a partial match and a fact that were tried
  std::int64_t held = 0;      ///< partial matches that are through now
  bool initial = false;       ///< CLIPS made it for tests that come before all patterns
  bool tests_after = false;   ///< tests that follow it are those of `reached`; else they are the last ones of it
  std::vector<std::int64_t> reached;  ///< how often each test was reached, in order
  std::size_t sharers = 1;            ///< rules of which it is a condition; the time is divided among them
  WorkTime time;                      ///< its matching, with its share of the pattern's
};

struct RuleCounts {
  ConstructInfo info;  ///< without file and text for a rule that was not read from a text
  std::int64_t activated = 0, fired = 0;
  std::vector<std::vector<JoinCounts>> disjuncts;  ///< one for each way through the `or` conditions
  WorkTime acting;                                 ///< its actions, without the matching that they cause
  WorkTime activating;                             ///< putting it on the agenda and taking it off
};

struct FunctionCounts {
  ConstructInfo info;
  std::int64_t calls = 0;
  WorkTime time;  ///< in its own actions, without functions that it calls
};

/// A stretch of the clock in which something was at work, for a trace.
struct WorkSpan {
  enum class Kind : std::uint8_t { kFiring, kFunction, kMatching };
  Kind kind = Kind::kFiring;
  std::string name;  ///< of the rule or function, with its module
  double begin_s = 0, end_s = 0;
  SimTime t{};

  /// A join in `EngineCounts::rules`; the one after the last stands for the agenda.
  struct Place {
    std::size_t rule = 0, disjunct = 0, join = 0;
  };
  std::optional<Place> longest = {};  ///< of matching: what took longest in it; none if its rule is gone
};

struct EngineCounts {
  Counting counting = Counting::kNothing;
  std::vector<RuleCounts> rules;  ///< in order of definition; those that have been removed come first
  std::vector<FunctionCounts> functions;
  WorkTime elsewhere;      ///< outside of rules
  double clock_reads = 0;  ///< in all
  std::vector<WorkSpan> spans;
  std::int64_t spans_left_out = 0;  ///< after the first `kMostSpans`
};
inline constexpr std::size_t kMostSpans = 1'000'000;
/// Matching that takes less is no span.
inline constexpr double kShortestMatching = 20e-6;

}  // namespace cxlab
