#include "planner/ground/passes.h"

#include <algorithm>

namespace cxlab::planner {

namespace {

class Relevance {
 public:
  explicit Relevance(const Task& task)
      : task_(task),
        present_(task.domain.predicates.size(), 0),
        absent_(present_),
        number_(task.domain.functions.size(), 0),
        action_(task.domain.actions.size(), 0) {
    find_late_values();
    ask(task.problem.goal, false);
    while (changed_) {
      changed_ = false;
      look_at_rules();
    }
    // A plan ends with its last action: where events bring about the goal, any action may be needed to wait for them.
    if (events_help()) {
      action_.assign(action_.size(), 1);
      return;
    }
    if (task.problem.metric) ask(task.problem.metric->value);
    changed_ = true;
    while (changed_) {
      changed_ = false;
      for (std::size_t a = 0; a < action_.size(); ++a) look_at(a);
      look_at_rules();
    }
  }

  std::vector<char> take() { return std::move(action_); }

 private:
  /// Functions some of whose numbers have no value at first and get one from an action.
  void find_late_values() {
    ById<std::size_t> values(number_.size(), 0);
    for (const Assignment& value : task_.problem.values) ++values[value.function];
    late_.assign(number_.size(), 0);
    for (const Action& action : task_.domain.actions)
      for (const Effect& effect : action.effects) {
        if (effect.kind != Effect::Kind::kAssign) continue;
        std::size_t all = 1;
        for (const Variable& parameter : task_.domain.functions[effect.function].parameters)
          all *= objects_of(task_.domain, task_.problem, parameter.types).size();
        late_[effect.function] = values[effect.function] < all;
      }
  }

  bool events_help() const {
    const auto helps = [this](const TimedFact& timed) {
      return (timed.value ? present_ : absent_)[timed.fact.predicate] != 0;
    };
    return std::ranges::any_of(task_.problem.timed_facts, helps) ||
           std::ranges::any_of(task_.problem.timed_values, [this](const TimedAssignment& timed) {
             return number_[timed.assignment.function] != 0;
           });
  }

  void look_at_rules() {
    for (const Derivation& rule : task_.domain.derivations) {
      if (present_[rule.predicate]) ask(rule.condition, false);
      if (absent_[rule.predicate]) ask(rule.condition, true);
    }
  }

  void look_at(std::size_t index) {
    const Action& action = task_.domain.actions[index];
    bool needed = action_[index];
    for (const Effect& effect : action.effects) {
      if (!helps(effect)) continue;
      needed = true;
      ask(effect.condition);
      ask(effect.value);
    }
    if (!needed || action_[index]) return;
    action_[index] = 1;
    changed_ = true;
    ask(action.condition);
    for (const Effect& effect : action.effects)  // one that must not come about may have to be kept from it
      for (const Condition* part : effect.condition.parts()) ask(*part, true);
    for (const DurationConstraint& constraint : action.duration) ask(constraint.bound);
    for (const Effect& effect :
         action.effects) {  // it cannot be done before the numbers that it reads and changes have values
      if (!effect.is_numeric()) continue;
      if (effect.kind != Effect::Kind::kAssign && late_[effect.function]) mark(number_[effect.function]);
      bool product = false;  // or quotient, which may have no value
      for_each_part(effect.value, [&product](const Expression& part) {
        product |= part.kind == Expression::Kind::kMultiply || part.kind == Expression::Kind::kDivide;
      });
      for_each_part(effect.value, [&](const Expression& part) {
        if (part.kind == Expression::Kind::kFunction && (product || late_[part.function])) mark(number_[part.function]);
      });
    }
  }

  bool helps(const Effect& effect) const {
    if (effect.kind == Effect::Kind::kAdd) return present_[effect.predicate];
    if (effect.kind == Effect::Kind::kDelete) return absent_[effect.predicate];
    return number_[effect.function];
  }

  void ask(const TimedCondition& condition) {
    for (const Condition* part : condition.parts()) ask(*part, false);
  }

  void ask(const Condition& condition, bool negated) {
    for_each_part(
        condition,
        [this](const Condition& part, bool absent) {
          if (part.kind == Condition::Kind::kAtom) mark((absent ? absent_ : present_)[part.predicate]);
          for (const Expression& side : part.sides) ask(side);
        },
        negated);
  }

  void ask(const Expression& expression) {
    for_each_part(expression, [this](const Expression& part) {
      if (part.kind == Expression::Kind::kFunction) mark(number_[part.function]);
    });
  }

  void mark(char& flag) {
    if (!flag) {
      flag = 1;
      changed_ = true;
    }
  }

  const Task& task_;
  ById<char> present_, absent_, number_, action_;
  ById<char> late_;  ///< by function
  bool changed_ = true;
};

}  // namespace

std::vector<char> relevant_actions(const Task& task) { return Relevance(task).take(); }

}  // namespace cxlab::planner
