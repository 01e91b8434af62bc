#pragma once
// A planning task without variables: facts are bits, numeric fluents are slots, every action is written out.
//
// A condition is a conjunction of facts that must be true. If a problem asks for the absence of a fact, the fact has a
// complement: a second fact that every effect keeps opposite. Disjunctions that cannot be split over several actions
// are derived facts.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "planner/pddl/model.h"

namespace cxlab::planner {

/// Time of plans: whole microseconds, so that sums of durations are exact.
using Micros = std::int64_t;

/// Two happenings of which one reads what the other writes are this far apart: one millisecond, as plan validators
/// ask, and one microsecond against their rounding.
inline constexpr Micros kSeparation = 1001;
/// What plan validators ask for.
inline constexpr Micros kValidSeparation = 1000;

inline constexpr Micros kMicrosPerSecond = 1'000'000;
inline double in_seconds(Micros time) { return static_cast<double>(time) / static_cast<double>(kMicrosPerSecond); }
inline Micros in_micros(double seconds) {
  return static_cast<Micros>(std::llround(seconds * static_cast<double>(kMicrosPerSecond)));
}

using Word = std::uint64_t;

inline bool is_set(const Word* state, int fact) { return (state[fact >> 6] >> (fact & 63)) & 1; }
inline void set(Word* state, int fact) { state[fact >> 6] |= Word{1} << (fact & 63); }
inline void reset(Word* state, int fact) { state[fact >> 6] &= ~(Word{1} << (fact & 63)); }

struct DurationRange {
  Micros least = 0;
  Micros most = 0;  ///< kForever: any
  static constexpr Micros kForever = std::numeric_limits<Micros>::max() / 4;
};

/// A number computed from numeric fluents: operations in postfix order.
struct GroundExpression {
  using Kind = Expression::Kind;
  struct Step {
    Kind kind = Kind::kConstant;
    int number = -1;   ///< of kFunction
    double value = 0;  ///< of kConstant
    bool operator==(const Step&) const = default;
  };
  std::vector<Step> steps;

  template <class Visit>
  void for_each_number(const Visit& visit) const {
    for (const Step& step : steps)
      if (step.kind == Kind::kFunction) visit(step.number);
  }
  bool mentions(int number) const { return std::ranges::find(steps, number, &Step::number) != steps.end(); }
  /// Appends bytes that differ for different expressions.
  void append_key(std::string& key) const;
  bool mentions_duration() const {
    return std::ranges::any_of(steps, [](const Step& step) { return step.kind == Kind::kDuration; });
  }
  bool is_constant() const { return steps.size() == 1 && steps[0].kind == Kind::kConstant; }
  bool operator==(const GroundExpression&) const = default;

  static GroundExpression constant(double value) { return {{{Kind::kConstant, -1, value}}}; }

  /// Value with these numbers; a division by zero or an undefined number gives not-a-number.
  double evaluate(const double* numbers, double duration_s = 0, double total_time_s = 0) const;
  /// What the last step, a subtraction, subtracts from what.
  std::pair<double, double> sides(const double* numbers, double duration_s) const;
};

/// sum of weight * number + constant + duration_weight * ?duration
struct LinearForm {
  bool is_linear = false;
  std::vector<std::pair<int, double>> weights;  ///< by number, ascending, none zero
  double constant = 0;
  double duration_weight = 0;
};

/// The linear form of an expression, or is_linear = false.
LinearForm linear_form(const GroundExpression& expression);
/// The same for what is compared: not linear where a number cancels out, because its value is needed all the same.
LinearForm linear_form_of_all(const GroundExpression& expression);

/// `expression`, a difference of two sides, > 0, >= 0 or = 0. False where the expression is not a number.
struct GroundComparison {
  enum class Kind : std::uint8_t { kPositive, kNotNegative, kZero };
  Kind kind = Kind::kNotNegative;
  GroundExpression expression;
  LinearForm linear;
  bool separate = false;  ///< no term of `linear` stems from both sides

  static GroundComparison of(Kind kind, GroundExpression left, const GroundExpression& right);

  /// Value of the expression; 0 if its two sides are the same, which is as the validator compares them. Not-a-number
  /// where a side is none.
  double gap(const double* numbers, double duration_s = 0) const;
  bool accepts(double a_gap) const {
    if (kind == Kind::kPositive) return a_gap > 0;
    return kind == Kind::kNotNegative ? a_gap >= 0 : a_gap == 0;
  }
  bool holds(const double* numbers, double duration_s = 0) const { return accepts(gap(numbers, duration_s)); }
};

struct GroundCondition {
  std::vector<int> facts;        ///< all true; ascending
  std::vector<int> comparisons;  ///< all hold; ascending
  bool empty() const { return facts.empty() && comparisons.empty(); }
};

struct NumericEffect {
  enum class Kind : std::uint8_t { kAssign, kIncrease, kScale, kDivide };
  Kind kind = Kind::kIncrease;
  int number = -1;
  GroundExpression value;  ///< a decrease is an increase by the negated value
};

/// What one happening changes. Facts that are deleted and added are true afterwards.
struct GroundEffects {
  std::vector<int> add, remove;  ///< ascending, disjoint
  std::vector<NumericEffect> numbers;
  bool empty() const { return add.empty() && remove.empty() && numbers.empty(); }
};

/// Conditions and effects by time. A condition of an effect is read at its own time, `start` when the action begins.
/// Effects at the start have a condition at the start only.
struct ConditionalEffects {
  GroundCondition start, over_all, end;
  GroundEffects at_start, at_end;
};

struct GroundDuration {
  Comparison comparison = Comparison::kEqual;
  GroundExpression bound;
  bool at_end = false;
};

/// `number` changes by `rate` a second, all along the action.
struct ContinuousEffect {
  int number = -1;
  GroundExpression rate;
};

/// A use of a fact or number on which no plan depends, but which validators count when happenings share an instant. A
/// condition names a fact that never changes, or one that another part of the condition makes unimportant. Or an effect
/// changes what nothing needs.
struct IdleTouch {
  int key = -1;  ///< a fact, or behind all facts a number, or behind all numbers one of GroundTask::others
  bool at_end = false;
  bool read = false, up = false, down = false;  ///< up: added or increased; down: deleted; both: assigned
  bool conditional = false;                     ///< of an effect that may not come about
};

/// Its own conditions and effects, which it always has, and more under conditions.
struct GroundAction : ConditionalEffects {
  ActionId schema = -1;
  std::vector<ObjectId> arguments;
  bool durative = false;
  std::vector<GroundDuration> duration;
  double stretch = 0;  ///< as a whole action it lasts this share of the way from the shortest to the longest duration
  int aim = -1;        ///< as a whole action it lasts until this comparison turns
  std::vector<ConditionalEffects> conditional;
  std::vector<ContinuousEffect> continuous;
  std::vector<IdleTouch> idle;
};

/// Calls `visit` for the conditions and effects of an action: its own, then each under a condition.
template <class Action, class Visit>
void for_each_share(Action& action, const Visit& visit) {
  visit(action);
  for (auto& conditional : action.conditional) visit(conditional);
}
template <class Action, class Visit>
void for_each_condition(Action& action, const Visit& visit) {
  for_each_share(action, [&](auto& share) {
    for (auto* condition : {&share.start, &share.over_all, &share.end}) visit(*condition);
  });
}
template <class Action, class Visit>
void for_each_effects(Action& action, const Visit& visit) {
  for_each_share(action, [&](auto& share) {
    for (auto* effects : {&share.at_start, &share.at_end}) visit(*effects);
  });
}

/// `head` is true if `body` holds; false unless an axiom derives it.
struct Axiom {
  int head = -1;
  GroundCondition body;
  int stratum = 0;
};

/// What happens from outside.
struct TimedEvent {
  Micros time = 0;
  GroundEffects effects;
  std::vector<IdleTouch> idle;
};

struct GroundFact {
  PredicateId predicate = -1;  ///< -1 for the fact of a disjunction
  std::vector<ObjectId> objects;
  int complement = -1;         ///< the fact that is opposite, or -1
  bool is_complement = false;  ///< true: `predicate` of `objects` does not hold
  bool derived = false;
};

struct GroundNumber {
  FunctionId function = -1;
  std::vector<ObjectId> objects;
};

/// The facts and numbers that conditions of an action of the domain read through derived predicates, as validators
/// judge it. They read every fact of the predicates, and every number of the functions, from which these are derived.
/// Empty lists: nothing.
struct SchemaReads {
  Symbols start, over_all, end;
};

struct GroundTask {
  ById<GroundFact> facts;
  ById<GroundNumber> numbers;  ///< those that only the metric reads last
  ById<GroundComparison> comparisons;
  ById<GroundAction> actions;
  std::vector<Axiom> axioms;        ///< by stratum
  ById<TimedEvent> events;          ///< by time
  ById<SchemaReads> derived_reads;  ///< by action of the domain; empty without derived predicates
  ById<char> initial_facts;         ///< without derived facts
  ById<double> initial_numbers;     ///< not-a-number where undefined
  GroundCondition goal;
  bool proved_unsolvable = false;  ///< the goal is out of reach even if nothing were ever deleted, or by pairs of facts
  std::vector<int> missing_values;  ///< numbers without a value, which nothing assigns, that keep the goal out of reach
  GroundExpression metric;          ///< to be made small; empty = makespan
  int others = 0;                   ///< facts and numbers that only IdleTouch names

  /// Words of bits of a state.
  int words() const { return static_cast<int>((facts.size() + 63) / 64); }
  /// The fact, or the one that it is the complement of.
  int positive(int fact) const {
    return facts[fact].is_complement && facts[fact].complement >= 0 ? facts[fact].complement : fact;
  }
};

/// By fact: the facts and, behind all facts, the numbers that it depends on. A fact that no axiom derives depends on
/// itself, and a complement on what its fact depends on.
ById<std::vector<int>> bases_of_facts(const GroundTask& task);

/// By number: whether it may matter to what can be done, so that states with different values differ: all but those
/// that only the metric reads.
ById<char> significant_numbers(const GroundTask& task);

/// The durations that those constraints allow that are constants.
DurationRange constant_durations(const GroundAction& action);

}  // namespace cxlab::planner
