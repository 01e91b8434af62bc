#pragma once
// Small random problems in which everything meets: durations that are fixed, chosen, 0 or a number; numbers without a
// value; linear change; conditional effects; events that change facts and numbers.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/random.h"
#include "tests/planner/random/random_problem.h"

namespace cxlab::planner {

/// number <op> value
struct NumberTest {
  int number = 0;
  std::string op;  ///< < <= = >= >
  int value = 0;
};

/// All must hold.
struct NumericCondition {
  std::vector<Literal> facts;
  std::vector<NumberTest> numbers;
};

/// What becomes of a number: assign, increase or decrease, by a value or by the duration times it.
struct NumberEffect {
  int number = 0;
  std::string kind;
  int value = 0;
  bool times_duration = false;
};

struct NumericEffects {
  std::vector<Literal> facts;
  std::vector<NumberEffect> numbers;
};

struct NumericAction {
  enum class Duration { kFixed, kChosen, kNumber };
  Duration duration = Duration::kFixed;
  int least = 1, most = 1;  ///< s
  int number = 0;           ///< of kNumber
  NumericCondition start, over_all, end;
  NumericEffects at_start, at_end;
  std::vector<std::pair<int, int>> rates;  ///< number and change a second
  std::optional<Literal> when;             ///< at the start: then the next one comes about at the end
  Literal then;
};

struct NumericEvent {
  int time = 1;  ///< s
  bool of_number = false;
  Literal fact;
  int number = 0, value = 0;
};

struct NumericProblem {
  int facts = 3, numbers = 2;
  std::vector<char> initial;
  std::vector<std::optional<int>> values;  ///< at first; none: undefined
  std::vector<NumericAction> actions;
  std::vector<NumericEvent> events;  ///< by time, each symbol once at a time
  NumericCondition goal;

  static NumericProblem draw(RandomStream& random);
  std::string domain() const;
  std::string problem() const;
};

/// One step of a witness; times in milliseconds.
struct WitnessStep {
  int action = 0;
  int start = 0, duration = 0;
};

struct WitnessLimits {
  int seconds = 12;
  int instants = 4;  ///< of a second, a millisecond apart
  int steps = 3;
  std::size_t most_situations = 60'000;
};

struct WitnessAnswer {
  std::optional<std::vector<WitnessStep>> plan;  ///< the first that was found; none: none exists on this grid
  bool too_large = false;                        ///< not everything was looked at
};

/// Tries all plans of a few steps that begin at whole seconds or a few milliseconds later and last for whole seconds.
/// Shares no code with the planner or the validator; counts in whole thousandths.
WitnessAnswer find_witness(const NumericProblem& problem, const WitnessLimits& limits = {});

/// As plans are written.
std::string to_text(const std::vector<WitnessStep>& plan);

}  // namespace cxlab::planner
