#pragma once
// Everything that could become true in a problem, by a relaxation: nothing is undone, and each number goes as far as it
// likes in each direction in which it moves. The planner's grounding (planner/ground) uses the same relaxation; here
// actions keep their names and their conditions as written.

#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planner/ground/ground.h"
#include "planner/ground/passes.h"
#include "planner/ground/reachable.h"
#include "planner/state/atom_table.h"

namespace cxlab::planner {

/// Ground facts that can be so, alone and in twos, judged by pairs of facts.
class PairJudge {
 public:
  PairJudge(const GroundTask& ground, Together together);

  bool can_be(PredicateId predicate, std::span<const ObjectId> objects, bool value) const;
  /// Two of those that `can_be`.
  bool can_be_both(int a, int b) const { return a < 0 || b < 0 || together_.can_be(a, b); }
  /// -1: nothing is known about it.
  int id(PredicateId predicate, std::span<const ObjectId> objects, bool value) const;

 private:
  AtomTable atoms_;
  ById<std::pair<int, int>> ids_;  ///< by atom: the fact, its absence
  Together together_;
};

struct GroundLiteral {
  PredicateId predicate = -1;
  std::vector<ObjectId> objects;
  bool value = true;
};

/// From the least to the greatest value.
struct Range {
  double low = 0, high = 0;
  bool is_point() const { return low == high; }
};

class Reach {
 public:
  /// Meaningless when the budget is over. `pairs` may be none.
  Reach(const Task& task, const Reachable& reachable, Budget& budget, const PairJudge* pairs);

  bool can_be(PredicateId predicate, std::span<const ObjectId> objects, bool value) const;
  /// Whether `condition` can be `wanted`; `frame` has all its free variables.
  bool can_hold(const Condition& condition, Frame& frame, bool wanted) const;
  /// Two facts that a condition asks for at once and that are never so together.
  std::optional<std::pair<GroundLiteral, GroundLiteral>> never_together(const Condition& condition, Frame& frame) const;
  /// None: it has no value.
  std::optional<Range> range(const Expression& expression, const Frame& frame) const;
  /// Whether the action lasts longer than 0 for certain, so that conditions over all count.
  bool takes_time(const Action& action, const Frame& frame) const;

  /// The atoms of a predicate that can be true.
  const std::vector<int>& atoms_of(PredicateId predicate) const { return by_predicate_[predicate]; }
  const AtomTable& atoms() const { return true_; }
  bool is_static(PredicateId predicate) const { return !reachable_.fluent[predicate]; }
  std::optional<double> initial_value(FunctionId function, std::span<const ObjectId> objects) const;
  bool is_initial(PredicateId predicate, std::span<const ObjectId> objects) const {
    return initial_.find(predicate, objects) >= 0;
  }

 private:
  struct Number {
    double value = 0;
    bool initial = false, defined = false, up = false, down = false;
  };
  enum class Stage : char { kNone, kBegun, kEnded, kUseless };

  void spread();
  bool round();
  bool advance(const Binding& binding, Stage& stage);
  bool has_values(const Action& action, Effect::Time time, const Frame& frame) const;
  bool has_durations(const Action& action, bool ends, const Frame& frame) const;
  bool apply(const Action& action, Effect::Time time, bool conditional, Frame& frame);
  bool apply(const Effect& effect, const Frame& frame);
  bool add(PredicateId predicate, std::span<const ObjectId> objects);
  Number& number(FunctionId function, std::span<const ObjectId> objects);
  bool move(Number& number, bool up, bool down);
  bool any_assignment(std::span<const Variable> variables, Frame& frame, const std::function<bool()>& holds) const;
  void collect(const Condition& condition, Frame& frame, bool wanted, std::vector<GroundLiteral>& out) const;
  bool can_compare(const Condition& condition, const Frame& frame, bool wanted) const;

  const Task& task_;
  const Reachable& reachable_;
  Budget& budget_;
  const PairJudge* pairs_;
  AtomTable initial_, true_, deleted_, valued_;
  ById<std::vector<int>> by_predicate_;
  ById<Number> numbers_;  ///< by atom of valued_
  std::vector<Stage> stages_;
};

/// Calls `visit(condition, wanted)` for the parts of a conjunction.
template <class Visit>
void for_each_conjunct(const Condition& condition, bool wanted, const Visit& visit) {
  using Kind = Condition::Kind;
  if (condition.kind == Kind::kNot)
    for_each_conjunct(condition.operands[0], !wanted, visit);
  else if (condition.kind == (wanted ? Kind::kAnd : Kind::kOr))
    for (const Condition& operand : condition.operands) for_each_conjunct(operand, wanted, visit);
  else if (condition.kind == Kind::kImply && !wanted) {
    for_each_conjunct(condition.operands[0], true, visit);
    for_each_conjunct(condition.operands[1], false, visit);
  } else
    visit(condition, wanted);
}

}  // namespace cxlab::planner
