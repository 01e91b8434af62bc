#pragma once
// A planning domain and problem after parsing: every name is an index, every variable a slot, effects are flat lists.
//
// Language: PDDL 2.1 level 4 restricted to linear change, with derived predicates and timed initial literals of 2.2
// and timed numeric values. See docs/reference/pddl.md. Names are lower case.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "planner/pddl/by_id.h"

namespace cxlab::planner {

using TypeId = int;       ///< index in Domain::types
using ObjectId = int;     ///< index in Problem::objects; constants of the domain come first, with the same index
using PredicateId = int;  ///< index in Domain::predicates
using FunctionId = int;   ///< index in Domain::functions
using ActionId = int;     ///< index in Domain::actions

/// Where something was written; line 0 = nowhere (built in, or added at run time).
struct Source {
  enum class File : std::uint8_t { kDomain, kProblem };
  File file = File::kDomain;
  int line = 0;
};

/// An argument: an object, or the variable in a slot of the surrounding frame (action, rule, goal).
struct Term {
  bool is_variable = false;
  int index = 0;  ///< slot, or ObjectId

  static Term variable(int slot) { return {true, slot}; }
  static Term object(ObjectId id) { return {false, id}; }
  /// The object that it is in a frame.
  ObjectId in(const ById<ObjectId>& frame) const { return is_variable ? frame[index] : index; }
  bool operator==(const Term&) const = default;
};

/// A parameter, or a variable of a quantifier. Its value belongs to at least one of `types`.
/// Slots are unique in a frame: parameters have 0, 1, ..., each quantifier has slots of its own behind them.
struct Variable {
  std::string name;  ///< with the question mark
  std::vector<TypeId> types;
  int slot = 0;
};

/// A number. Operands are in `operands`: one for kNegate, two or more for kAdd and kMultiply, two for the others.
struct Expression {
  enum class Kind : std::uint8_t {
    kConstant,  ///< value
    kFunction,  ///< function, terms
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kNegate,
    kDuration,   ///< ?duration of the surrounding durative action
    kTotalTime,  ///< total-time: end of the plan; only in the metric
  };
  Kind kind = Kind::kConstant;
  double value = 0;
  FunctionId function = -1;
  std::vector<Term> terms;
  std::vector<Expression> operands;

  static Expression constant(double value) { return {Kind::kConstant, value, -1, {}, {}}; }
};

enum class Comparison : std::uint8_t { kLess, kLessEqual, kEqual, kGreaterEqual, kGreater };

/// What must hold. An empty kAnd is true, an empty kOr is false.
struct Condition {
  enum class Kind : std::uint8_t {
    kAtom,     ///< predicate, terms
    kSame,     ///< terms[0] and terms[1] are the same object
    kCompare,  ///< sides[0] `comparison` sides[1]
    kNot,      ///< operands[0]
    kAnd,      ///< operands
    kOr,       ///< operands
    kImply,    ///< operands[0] implies operands[1]
    kForall,   ///< for all `variables`: operands[0]
    kExists,   ///< there are `variables` with operands[0]
  };
  Kind kind = Kind::kAnd;
  Comparison comparison = Comparison::kEqual;
  PredicateId predicate = -1;
  std::vector<Term> terms;
  std::vector<Expression> sides;
  std::vector<Variable> variables;
  std::vector<Condition> operands;
  Source source;

  bool is_true() const { return kind == Kind::kAnd && operands.empty(); }
};

/// Calls `visit(part)` for an expression and all expressions in it.
template <class Visit>
void for_each_part(const Expression& expression, const Visit& visit) {
  visit(expression);
  for (const Expression& operand : expression.operands) for_each_part(operand, visit);
}

/// Calls `visit(part, negated)` for a condition and all conditions in it; `negated`: an odd number of negations are
/// around it.
template <class Visit>
void for_each_part(const Condition& condition, const Visit& visit, bool negated = false) {
  using Kind = Condition::Kind;
  visit(condition, negated);
  for (const Condition& operand : condition.operands) {
    const bool is_premise = condition.kind == Kind::kImply && &operand == &condition.operands.front();
    for_each_part(operand, visit, negated != (is_premise || condition.kind == Kind::kNot));
  }
}

/// Conditions of a durative action by the time at which they count. An instantaneous action uses `start` alone.
struct TimedCondition {
  Condition start;
  Condition over_all;  ///< in the open interval between start and end
  Condition end;

  bool is_true() const { return start.is_true() && over_all.is_true() && end.is_true(); }
  std::array<const Condition*, 3> parts() const { return {&start, &over_all, &end}; }
};

/// One elementary effect: for all `variables`, when `condition`, at `time`, do it. Nested and, forall and when are
/// flattened into this form. `variables` and `condition` are empty where there is none.
struct Effect {
  enum class Kind : std::uint8_t { kAdd, kDelete, kAssign, kIncrease, kDecrease, kScaleUp, kScaleDown };
  enum class Time : std::uint8_t {
    kStart,  ///< also of instantaneous actions
    kEnd,
    kContinuous,  ///< kIncrease or kDecrease all along the action; `value` is the rate, without its #t, a second
  };
  Kind kind = Kind::kAdd;
  Time time = Time::kStart;
  PredicateId predicate = -1;  ///< of kAdd, kDelete
  FunctionId function = -1;    ///< of the other kinds
  std::vector<Term> terms;     ///< arguments of the predicate or function
  Expression value;            ///< right-hand side of the numeric kinds
  std::vector<Variable> variables;
  TimedCondition condition;  ///< of an effect at the end, `start` was evaluated when the action began
  Source source;

  bool is_numeric() const { return kind != Kind::kAdd && kind != Kind::kDelete; }
};

/// ?duration `comparison` `bound`, evaluated when the action starts or ends. kLess and kGreater do not occur.
struct DurationConstraint {
  Comparison comparison = Comparison::kEqual;
  Expression bound;
  bool at_end = false;
};

struct Action {
  std::string name;
  bool durative = false;
  std::vector<Variable> parameters;          ///< slots 0, 1, ...
  int slots = 0;                             ///< size of the frame: parameters and all variables of quantifiers
  std::vector<DurationConstraint> duration;  ///< all must hold; empty = any duration
  TimedCondition condition;
  std::vector<Effect> effects;  ///< in the order of the file
  Source source;
};

/// A rule of a derived predicate: `predicate` is true of `parameters` if `condition` holds. Rules are stratified:
/// no derived predicate depends on its own negation.
struct Derivation {
  PredicateId predicate = -1;
  std::vector<Variable> parameters;
  int slots = 0;
  Condition condition;
  Source source;
};

struct Type {
  std::string name;
  std::vector<TypeId> parents;  ///< several with `either`; empty for object
  Source source;
};

struct Predicate {
  std::string name;
  std::vector<Variable> parameters;
  bool derived = false;
  int stratum = 0;  ///< of derived predicates: negation reaches only lower strata
  Source source;
};

/// A numeric fluent. One without an initial value is undefined: what reads it fails. total-cost begins with 0.
struct Function {
  std::string name;
  std::vector<Variable> parameters;
  Source source;
};

struct Object {
  std::string name;
  std::vector<TypeId> types;  ///< it belongs to all of them
  Source source;
};

/// Names to indices. Only for look-up: nothing depends on the order of the table.
using NameTable = std::unordered_map<std::string, int>;

/// A ground atom or ground numeric fluent of the initial state.
struct Fact {
  PredicateId predicate = -1;
  std::vector<ObjectId> objects;
  bool operator==(const Fact&) const = default;
};
struct Assignment {
  FunctionId function = -1;
  std::vector<ObjectId> objects;
  double value = 0;
};

/// Times and plans end before (s): 285 years, so that Unix times fit and nanoseconds are whole numbers of 64 bits.
inline constexpr double kLatestTime = 9e9;

struct Domain {
  static constexpr TypeId kObjectType = 0;

  std::string name;
  std::string file;
  std::vector<std::string> requirements;  ///< as declared, with the colon
  ById<Type> types;                       ///< [0] is object
  ById<Object> constants;
  ById<Predicate> predicates;
  ById<Function> functions;
  ById<Action> actions;
  std::vector<Derivation> derivations;
  std::vector<Fact> timeless;  ///< true in the initial state of every problem

  NameTable type_names, predicate_names, function_names, action_names;  ///< kept by the parser

  /// Whether `type` is `ancestor` or below it.
  bool is_a(TypeId type, TypeId ancestor) const {
    return ancestors[type * static_cast<int>(types.size()) + ancestor] != 0;
  }
  ById<char> ancestors;  ///< matrix of is_a, row = type
};

/// What happens from outside at `time` (s, 0 to kLatestTime): a timed initial literal, or a timed numeric value.
struct TimedFact {
  double time = 0;
  Fact fact;
  bool value = true;
  Source source;
};
struct TimedAssignment {
  double time = 0;
  Assignment assignment;
  Source source;
};

struct Metric {
  bool maximize = false;
  Expression value;
};

struct Problem {
  std::string name;
  std::string file;
  ById<Object> objects;    ///< constants of the domain, then objects of the problem
  std::vector<Fact> init;  ///< what is true, in the order of the file, each once
  std::vector<Assignment> values;
  std::vector<TimedFact> timed_facts;         ///< by time
  std::vector<TimedAssignment> timed_values;  ///< by time
  bool has_goal = false;                      ///< a goal was given; otherwise `goal` always holds
  Condition goal;
  int goal_slots = 0;            ///< frame of the goal: variables of its quantifiers
  std::optional<Metric> metric;  ///< none = shortest makespan

  NameTable object_names;
};

/// A problem with its domain.
struct Task {
  Domain domain;
  Problem problem;
};

/// Whether an object may be the value of a variable with these types.
bool fits(const Domain& domain, const Object& object, const std::vector<TypeId>& types);

/// All objects that may be the value of a variable with these types, ascending.
std::vector<ObjectId> objects_of(const Domain& domain, const Problem& problem, const std::vector<TypeId>& types);

/// The index of a name, or -1.
int find(const NameTable& table, std::string_view name);

/// Which predicates and which functions.
struct Symbols {
  ById<char> predicates, functions;
};

/// What actions and events can change; derived predicates are not among it.
Symbols changing(const Domain& domain, const Problem& problem);

/// By predicate: what a derived one is computed from, directly or through other derived ones, which are not among it.
ById<Symbols> bases_of_derived(const Domain& domain);

}  // namespace cxlab::planner
