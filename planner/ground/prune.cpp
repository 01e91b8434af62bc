#include <algorithm>
#include <cmath>

#include "planner/ground/ground.h"

namespace cxlab::planner {

namespace {

/// What can happen if nothing is ever deleted and numbers go as far as they like in each direction in which they move.
class Relaxation {
 public:
  explicit Relaxation(const GroundTask& task)
      : task_(task), fact_(task.facts.size(), 0), comparison_(task.comparisons.size(), 0), action_(task.actions.size(), 0),
        up_(task.numbers.size(), 0), down_(task.numbers.size(), 0) {
    for (std::size_t f = 0; f < task.facts.size(); ++f)
      fact_[f] = task.initial_facts[f] || (task.facts[f].derived && task.facts[f].is_complement);
    for (std::size_t c = 0; c < task.comparisons.size(); ++c) {
      const GroundComparison& comparison = task.comparisons[c];
      comparison_[c] = comparison.holds(task.initial_numbers.data()) || !comparison.linear.is_linear || comparison.linear.duration_weight != 0;
    }
    for (const TimedEvent& event : task.events) apply(event.effects);
    for (bool changed = true; changed;) changed = round();
  }

  bool reaches(const GroundCondition& condition) const {
    return std::ranges::all_of(condition.facts, [this](int f) { return fact_[f] != 0; }) &&
           std::ranges::all_of(condition.comparisons, [this](int c) { return comparison_[c] != 0; });
  }
  bool applicable(std::size_t action) const { return action_[action] != 0; }

 private:
  bool round() {
    bool changed = false;
    for (std::size_t a = 0; a < task_.actions.size(); ++a) {
      const GroundAction& action = task_.actions[a];
      if (action_[a] && action.conditional.empty()) continue;
      if (!reaches(action.start)) continue;
      if (!action_[a]) {
        // What must hold during the action or at its end may be brought about by its own beginning.
        std::vector<std::pair<int, char>> saved;
        for (const int f : action.at_start.add) saved.emplace_back(f, fact_[f]), fact_[f] = 1;
        const std::vector<char> up = up_, down = down_, comparisons = comparison_;
        move(action.at_start);
        for (const ContinuousEffect& change : action.continuous) move_number(change.number, change.rate);
        for (const ConditionalEffects& conditional : action.conditional) {
          for (const int f : conditional.at_start.add) saved.emplace_back(f, fact_[f]), fact_[f] = 1;
          move(conditional.at_start);
        }
        refresh();
        const bool possible = reaches(action.over_all) && reaches(action.end);
        for (auto it = saved.rbegin(); it != saved.rend(); ++it) fact_[it->first] = it->second;
        up_ = up, down_ = down, comparison_ = comparisons;
        if (!possible) continue;
        action_[a] = 1;
        changed = true;
        changed |= apply(action.at_start) | apply(action.at_end);
        for (const ContinuousEffect& effect : action.continuous) changed |= move_number(effect.number, effect.rate);
        refresh();
      }
      for (const ConditionalEffects& conditional : action.conditional)
        if (reaches(conditional.start) && reaches(conditional.over_all) && reaches(conditional.end))
          changed |= apply(conditional.at_start) | apply(conditional.at_end);
    }
    for (const Axiom& axiom : task_.axioms)
      if (!fact_[axiom.head] && reaches(axiom.body)) fact_[axiom.head] = 1, changed = true;
    return changed;
  }

  bool apply(const GroundEffects& effects) {
    bool changed = false;
    for (const int f : effects.add)
      if (!fact_[f]) fact_[f] = 1, changed = true;
    if (move(effects)) changed = true, refresh();
    return changed;
  }

  bool move(const GroundEffects& effects) {
    bool changed = false;
    for (const NumericEffect& effect : effects.numbers) {
      if (effect.kind == NumericEffect::Kind::kIncrease) {
        changed |= move_number(effect.number, effect.value);
      } else if (!up_[effect.number] || !down_[effect.number]) {
        up_[effect.number] = down_[effect.number] = 1;
        changed = true;
      }
    }
    return changed;
  }

  bool move_number(int number, const GroundExpression& change) {
    const bool known = change.is_constant();
    const bool up = !known || change.steps[0].value > 0, down = !known || change.steps[0].value < 0;
    const bool changed = (up && !up_[number]) || (down && !down_[number]);
    up_[number] |= static_cast<char>(up), down_[number] |= static_cast<char>(down);
    return changed;
  }

  void refresh() {
    for (std::size_t c = 0; c < task_.comparisons.size(); ++c) {
      if (comparison_[c]) continue;
      const GroundComparison& comparison = task_.comparisons[c];
      for (const auto& [number, weight] : comparison.linear.weights) {
        const bool rises = weight > 0 ? up_[number] : down_[number], falls = weight > 0 ? down_[number] : up_[number];
        if (rises || (falls && comparison.kind == GroundComparison::Kind::kZero) || (std::isnan(task_.initial_numbers[number]) && (rises || falls)))
          comparison_[c] = 1;
      }
    }
  }

  const GroundTask& task_;
  std::vector<char> fact_, comparison_, action_, up_, down_;
};

template <class Visit>
void for_each_condition(GroundTask& task, const Visit& visit) {
  for (GroundAction& action : task.actions) {
    visit(action.start), visit(action.over_all), visit(action.end);
    for (ConditionalEffects& conditional : action.conditional) visit(conditional.start), visit(conditional.over_all), visit(conditional.end);
  }
  for (Axiom& axiom : task.axioms) visit(axiom.body);
  visit(task.goal);
}

template <class Visit>
void for_each_effects(GroundTask& task, const Visit& visit) {
  for (GroundAction& action : task.actions) {
    visit(action.at_start), visit(action.at_end);
    for (ConditionalEffects& conditional : action.conditional) visit(conditional.at_start), visit(conditional.at_end);
  }
  for (TimedEvent& event : task.events) visit(event.effects);
}

/// New numbers for the items that are kept, -1 for the others; moves the kept ones up in `items`.
template <class Item>
std::vector<int> compact(std::vector<Item>& items, const std::vector<char>& keep) {
  std::vector<int> renamed(items.size(), -1);
  std::size_t next = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!keep[i]) continue;
    renamed[i] = static_cast<int>(next);
    if (next != i) items[next] = std::move(items[i]);
    ++next;
  }
  items.resize(next);
  return renamed;
}

void rename(std::vector<int>& ids, const std::vector<int>& renamed) {
  for (int& id : ids) id = renamed[id];
  std::erase(ids, -1);
}

void rename(GroundExpression& expression, const std::vector<int>& renamed) {
  for (auto& step : expression.steps)
    if (step.kind == GroundExpression::Kind::kNumber) step.number = renamed[step.number];
}

void drop_facts(GroundTask& task) {
  std::vector<char> removed(task.facts.size(), 0), asked(task.facts.size(), 0);
  for_each_effects(task, [&](GroundEffects& effects) {
    for (const int f : effects.remove) removed[f] = 1;
  });
  for_each_condition(task, [&](GroundCondition& condition) {
    std::erase_if(condition.facts, [&](int f) { return !task.facts[f].derived && task.initial_facts[f] && !removed[f]; });
    for (const int f : condition.facts) asked[f] = 1;
  });
  for (const Axiom& axiom : task.axioms) asked[axiom.head] = 1;
  for (std::size_t f = 0; f < task.facts.size(); ++f)  // the complement of a derived fact is computed from it
    if (asked[f] && task.facts[f].derived && task.facts[f].is_complement) asked[task.facts[f].complement] = 1;
  std::vector<char> initial = task.initial_facts;
  const std::vector<int> renamed = compact(task.facts, asked);
  compact(task.initial_facts, asked);
  for_each_condition(task, [&](GroundCondition& condition) { rename(condition.facts, renamed); });
  for_each_effects(task, [&](GroundEffects& effects) { rename(effects.add, renamed), rename(effects.remove, renamed); });
  for (Axiom& axiom : task.axioms) axiom.head = renamed[axiom.head];
  for (GroundFact& fact : task.facts)
    if (fact.complement >= 0) fact.complement = renamed[fact.complement];
}

void drop_numbers(GroundTask& task) {
  std::vector<char> asked(task.numbers.size(), 0), used(task.comparisons.size(), 0);
  const auto ask = [&asked](const GroundExpression& expression) {
    for (const auto& step : expression.steps)
      if (step.kind == GroundExpression::Kind::kNumber) asked[step.number] = 1;
  };
  for_each_condition(task, [&](GroundCondition& condition) {
    for (const int c : condition.comparisons) used[c] = 1;
  });
  for (std::size_t c = 0; c < task.comparisons.size(); ++c)
    if (used[c]) ask(task.comparisons[c].expression);
  ask(task.metric);
  for (const GroundAction& action : task.actions)
    for (const GroundDuration& duration : action.duration) ask(duration.bound);
  for (std::size_t before = 0, now = 1; before != now;) {  // what a needed number is computed from is needed
    before = static_cast<std::size_t>(std::ranges::count(asked, 1));
    for_each_effects(task, [&](GroundEffects& effects) {
      for (const NumericEffect& effect : effects.numbers)
        if (asked[effect.number]) ask(effect.value);
    });
    for (const GroundAction& action : task.actions)
      for (const ContinuousEffect& effect : action.continuous)
        if (asked[effect.number]) ask(effect.rate);
    now = static_cast<std::size_t>(std::ranges::count(asked, 1));
  }
  const std::vector<int> comparisons = compact(task.comparisons, used);
  const std::vector<int> numbers = compact(task.numbers, asked);
  compact(task.initial_numbers, asked);
  for_each_condition(task, [&](GroundCondition& condition) { rename(condition.comparisons, comparisons); });
  for (GroundComparison& comparison : task.comparisons) {
    rename(comparison.expression, numbers);
    comparison.linear = linear_form(comparison.expression);
  }
  for_each_effects(task, [&](GroundEffects& effects) {
    std::erase_if(effects.numbers, [&](const NumericEffect& effect) { return numbers[effect.number] < 0; });
    for (NumericEffect& effect : effects.numbers) {
      effect.number = numbers[effect.number];
      rename(effect.value, numbers);
    }
  });
  for (GroundAction& action : task.actions) {
    std::erase_if(action.continuous, [&](const ContinuousEffect& effect) { return numbers[effect.number] < 0; });
    for (ContinuousEffect& effect : action.continuous) {
      effect.number = numbers[effect.number];
      rename(effect.rate, numbers);
    }
    for (GroundDuration& duration : action.duration) rename(duration.bound, numbers);
  }
  rename(task.metric, numbers);
}

}  // namespace

void prune(GroundTask& task) {
  const Relaxation relaxation(task);
  if (task.proved_unsolvable || !relaxation.reaches(task.goal)) {
    task.proved_unsolvable = true;
    return;
  }
  std::vector<char> keep(task.actions.size(), 0);
  for (std::size_t a = 0; a < task.actions.size(); ++a) keep[a] = relaxation.applicable(a);
  compact(task.actions, keep);
  for (GroundAction& action : task.actions)
    std::erase_if(action.conditional, [&](const ConditionalEffects& conditional) {
      return !relaxation.reaches(conditional.start) || !relaxation.reaches(conditional.over_all) || !relaxation.reaches(conditional.end) ||
             (conditional.at_start.empty() && conditional.at_end.empty());
    });
  std::erase_if(task.axioms, [&](const Axiom& axiom) { return !relaxation.reaches(axiom.body); });
  drop_facts(task);
  drop_numbers(task);
}

}  // namespace cxlab::planner
