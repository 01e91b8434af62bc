#pragma once
// Small random problems of more kinds than numeric_problem.h has: numbers that are copied, scaled and compared with
// each other; rates that read numbers; bounds of durations that read numbers, also at the end; effects with conditions
// at start, over all and at end; conditions with "or"; actions that take no time; events at 0 and between whole
// seconds.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cx/base/random.h"
#include "tests/planner/random/random_problem.h"

namespace cxlab::planner {

/// Thousandths of a second, or millionths of a number.
using Ticks = std::int64_t;

/// constant + sum of weight * number + weight * ?duration; the constant in halves.
struct WideSum {
  int halves = 0;
  std::vector<std::pair<int, int>> numbers;  ///< and weight
  int duration = 0;
};

struct WideTest {
  WideSum left;
  std::string op;  ///< < <= = >= >
  WideSum right;
};

/// All facts and tests, and one of `any` where there are some.
struct WideCondition {
  std::vector<Literal> facts, any;
  std::vector<WideTest> tests;
  bool empty() const { return facts.empty() && any.empty() && tests.empty(); }
};

struct WideChange {
  int number = 0;
  std::string kind;  ///< assign increase decrease scale-up
  WideSum value;
};

struct WideEffects {
  std::vector<Literal> facts;
  std::vector<WideChange> numbers;
};

struct WideConditional {
  WideCondition start, over_all, end;
  bool at_end = true;  ///< else only `start` is asked
  WideEffects effects;
};

struct WideBound {
  std::string op;  ///< <= = >=
  WideSum bound;
  bool at_end = false;
};

struct WideAction {
  bool durative = true;
  std::vector<WideBound> duration;
  WideCondition start, over_all, end;
  WideEffects at_start, at_end;
  std::vector<std::pair<int, WideSum>> rates;  ///< of numbers, a second
  std::vector<WideConditional> when;
};

struct WideEvent {
  Ticks time = 0;  ///< thousandths of a second
  bool of_number = false;
  Literal fact;
  int number = 0, value = 0;
};

struct WideProblem {
  bool with_objects = false;  ///< facts are written as (f o0), and "one of all" as exists
  int facts = 3, numbers = 2;
  std::vector<char> initial;
  std::vector<std::optional<int>> values;  ///< at first; none: undefined
  std::vector<WideAction> actions;
  std::vector<WideEvent> events;  ///< by time, each symbol once at a time
  WideCondition goal;

  static WideProblem draw(RandomStream& random);
  std::string domain() const;
  std::string problem() const;
};

struct WideAnswer {
  std::optional<std::string> plan;  ///< the first that was found, as plans are written; none: none exists on this grid
  bool too_large = false;           ///< not everything was looked at
};

/// Tries all plans of up to three steps. Steps begin at half seconds or up to two milliseconds later. They last for
/// halves of a second, or for the time that their bounds give. Shares no code with the planner or the validator.
WideAnswer find_witness(const WideProblem& problem, std::size_t most_situations = 60'000);

}  // namespace cxlab::planner
