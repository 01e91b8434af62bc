#pragma once
// The state at one instant: the true facts and the values of numbers. Also evaluates conditions and collects effects in
// it.

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "planner/pddl/model.h"
#include "planner/state/atom_table.h"
#include "planner/state/meter.h"

namespace cxlab::planner {

/// Truth of ground atoms and values of ground functions. A value may change linearly with time. Copies are cheap.
class State {
 public:
  /// Nothing is true, nothing has a value.
  explicit State(const Domain& domain);
  /// The initial state, without derived facts.
  State(const Domain& domain, const Problem& problem);

  bool holds(PredicateId predicate, std::span<const ObjectId> objects) const;
  void set(PredicateId predicate, std::span<const ObjectId> objects, bool value);
  /// Makes all facts of derived predicates false.
  void clear_derived();

  /// The value now; none where it is undefined.
  std::optional<double> value(FunctionId function, std::span<const ObjectId> objects) const;
  void set_value(FunctionId function, std::span<const ObjectId> objects, double value);

  /// Change a second of a defined value; 0 for others.
  double rate(FunctionId function, std::span<const ObjectId> objects) const;
  void add_rate(FunctionId function, std::span<const ObjectId> objects, double rate);
  void clear_rates();
  bool has_rates() const { return !changing_.empty(); }
  /// Reads numbers as they will be in `seconds` by their rates; 0 = now. Writing still changes the numbers of now.
  void look_ahead(double seconds) { ahead_ = seconds; }
  /// Moves all changing values on.
  void advance(double seconds);

  /// All that is true, and all values, in the order in which it became so.
  std::vector<Fact> facts() const;
  std::vector<Assignment> values() const;

 private:
  struct Number {
    double value = 0;
    double rate = 0;

    double after(double seconds) const;
  };

  AtomTable atoms_;            // all that has ever been true
  ById<std::uint64_t> since_;  // by atom: when it became true; 0 = it is false
  ById<char> derived_;         // by predicate
  std::vector<int> derived_atoms_;
  AtomTable functions_;        // that have a value
  ById<Number> numbers_;       // of them
  std::vector<int> changing_;  // functions with a rate
  std::uint64_t changes_ = 0;  // facts that became true
  double ahead_ = 0;
};

/// Compares exactly, up to the rounding errors of what has no decimal (planner/state/number.h).
bool compare(double left, Comparison comparison, double right);

/// One ground effect. `value` is the right-hand side of the numeric kinds.
struct Change {
  Effect::Kind kind = Effect::Kind::kAdd;
  int id = -1;  ///< predicate or function
  std::vector<ObjectId> objects;
  double value = 0;
  const Effect* effect = nullptr;
};

/// Evaluates parts of a task. Domain and problem must outlive it. The caller makes a new one when objects are added or
/// removed.
class Evaluator {
 public:
  /// `meter`, which may be none, outlives this; when it is over, every answer is meaningless.
  Evaluator(const Domain& domain, const Problem& problem, Meter* meter = nullptr)
      : domain_(domain), problem_(problem), meter_(meter) {}

  /// Whether `condition` holds. A comparison that reads an undefined value does not hold. `frame` has one entry a
  /// slot; those of quantifiers are overwritten. `duration` is that of the action, where there is one.
  bool holds(const Condition& condition, Frame& frame, const State& state, double duration = 0) const;

  /// The same, where `compare(condition, frame)` judges comparisons of numbers.
  template <class Compare>
  bool judge(const Condition& condition, Frame& frame, const State& state, const Compare& compare) const {
    using Kind = Condition::Kind;
    const auto each = [&](const Condition& operand) { return judge(operand, frame, state, compare); };
    switch (condition.kind) {
      case Kind::kAtom: return state.holds(condition.predicate, Objects(condition.terms, frame));
      case Kind::kSame: return condition.terms[0].in(frame) == condition.terms[1].in(frame);
      case Kind::kCompare: return compare(condition, frame);
      case Kind::kNot: return !each(condition.operands[0]);
      case Kind::kImply: return !each(condition.operands[0]) || each(condition.operands[1]);
      case Kind::kAnd: return std::ranges::all_of(condition.operands, each);
      case Kind::kOr: return std::ranges::any_of(condition.operands, each);
      case Kind::kForall: return each_binding(condition.variables, frame, [&] { return each(condition.operands[0]); });
      case Kind::kExists:
        return !each_binding(condition.variables, frame, [&] { return !each(condition.operands[0]); });
    }
    return false;
  }

  /// A number; none if an undefined value is read, or something is divided by 0.
  std::optional<double> number(const Expression& expression, const Frame& frame, const State& state,
                               double duration = 0) const;

  /// Calls `visit` for every binding of `variables` in `frame`; stops when it returns false, or the meter is over, and
  /// then gives false.
  template <class Visit>
  bool each_binding(const std::vector<Variable>& variables, Frame& frame, Visit visit, std::size_t from = 0) const {
    if (from == variables.size()) return visit();
    for (const ObjectId object : candidates(variables[from])) {
      frame[variables[from].slot] = object;
      if (!spend(1) || !each_binding(variables, frame, visit, from + 1)) return false;
    }
    return true;
  }
  /// The objects that a variable may be.
  const std::vector<ObjectId>& candidates(const Variable& variable) const;

  /// The effect with every binding of its variables for which `when(frame)` is true. False when a right-hand side has
  /// no value.
  template <class When>
  bool collect(const Effect& effect, Frame& frame, const State& state, double duration, When when,
               std::vector<Change>& out) const {
    return each_binding(effect.variables, frame, [&] {
      if (!when(frame)) return true;
      return ground(effect, frame, state, duration, out);
    });
  }

  /// The effect with the binding in `frame`. False when its right-hand side has no value.
  bool ground(const Effect& effect, const Frame& frame, const State& state, double duration,
              std::vector<Change>& out) const;

  /// Recomputes all facts of derived predicates.
  void derive(State& state) const;

  const Domain& domain() const { return domain_; }
  const Problem& problem() const { return problem_; }
  bool is_over() const { return meter_ != nullptr && meter_->over(); }
  /// False when the meter is over.
  bool spend(std::int64_t combinations) const { return meter_ == nullptr || meter_->spend(combinations); }

 private:
  const Domain& domain_;
  const Problem& problem_;
  Meter* meter_;
  mutable std::map<std::vector<TypeId>, std::vector<ObjectId>> by_types_;  // found before, found again
};

/// Applies changes that were collected in one state: deletes, then adds, then numbers in their order. False if a number
/// that is changed relatively has no value.
bool apply_changes(const std::vector<Change>& changes, State& state);

}  // namespace cxlab::planner
