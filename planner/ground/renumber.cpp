#include "planner/ground/renumber.h"

#include <algorithm>
#include <numeric>

namespace cxlab::planner {

namespace {

template <class Visit>
void for_all_conditions(GroundTask& task, const Visit& visit) {
  for (GroundAction& action : task.actions) for_each_condition(action, visit);
  for (Axiom& axiom : task.axioms) visit(axiom.body);
  visit(task.goal);
}

template <class Visit>
void for_all_effects(GroundTask& task, const Visit& visit) {
  for (GroundAction& action : task.actions) for_each_effects(action, visit);
  for (TimedEvent& event : task.events) visit(event.effects);
}

void rename(std::vector<int>& ids, const ById<int>& renamed) {
  for (int& id : ids) id = renamed[id];
  std::erase(ids, -1);
}

void rename(GroundExpression& expression, const ById<int>& renamed) {
  for (auto& step : expression.steps)
    if (step.kind == GroundExpression::Kind::kFunction) step.number = renamed[step.number];
}

void rename_numbers(GroundTask& task, const ById<int>& renamed) {
  for (GroundComparison& comparison : task.comparisons) {
    rename(comparison.expression, renamed);
    comparison.linear = linear_form_of_all(comparison.expression);
  }
  for_all_effects(task, [&](GroundEffects& effects) {
    for (NumericEffect& effect : effects.numbers) {
      effect.number = renamed[effect.number];
      rename(effect.value, renamed);
    }
  });
  for (GroundAction& action : task.actions) {
    for (ContinuousEffect& effect : action.continuous) {
      effect.number = renamed[effect.number];
      rename(effect.rate, renamed);
    }
    for (GroundDuration& duration : action.duration) rename(duration.bound, renamed);
  }
  rename(task.metric, renamed);
}

}  // namespace

void drop_facts(GroundTask& task) {
  // What makes a fact true that is true already must still keep clear of what reads it.
  ById<char> added(task.facts.size(), 0), removed(added), asked(added);
  for_all_effects(task, [&](GroundEffects& effects) {
    for (const int f : effects.add) added[f] = 1;
    for (const int f : effects.remove) removed[f] = 1;
  });
  for_all_conditions(task, [&](GroundCondition& condition) {
    std::erase_if(condition.facts,
                  [&](int f) { return !task.facts[f].derived && task.initial_facts[f] && !added[f] && !removed[f]; });
    for (const int f : condition.facts) asked[f] = 1;
  });
  for (const Axiom& axiom : task.axioms) asked[axiom.head] = 1;
  for (std::size_t f = 0; f < task.facts.size(); ++f)  // the complement of a derived fact is computed from it
    if (asked[f] && task.facts[f].derived && task.facts[f].is_complement) asked[task.facts[f].complement] = 1;
  for (std::size_t f = 0; f < task.facts.size(); ++f)  // and what one adds and another deletes keeps apart, too
    if (const int opposite = task.facts[f].complement;
        !task.facts[f].is_complement && added[f] && removed[f] && (opposite < 0 || !asked[opposite]))
      asked[f] = 1;
  const ById<int> renamed = compact(task.facts, asked);
  compact(task.initial_facts, asked);
  for_all_conditions(task, [&](GroundCondition& condition) { rename(condition.facts, renamed); });
  for_all_effects(task, [&](GroundEffects& effects) {
    rename(effects.add, renamed);
    rename(effects.remove, renamed);
  });
  for (Axiom& axiom : task.axioms) axiom.head = renamed[axiom.head];
  for (GroundFact& fact : task.facts)
    if (fact.complement >= 0) fact.complement = renamed[fact.complement];
}

void drop_numbers(GroundTask& task, Budget& budget) {
  ById<char> asked(task.numbers.size(), 0), used(task.comparisons.size(), 0);
  const auto ask = [&asked](const GroundExpression& expression) {
    expression.for_each_number([&asked](int n) { asked[n] = 1; });
  };
  for_all_conditions(task, [&](GroundCondition& condition) {
    for (const int c : condition.comparisons) used[c] = 1;
  });
  for (std::size_t c = 0; c < task.comparisons.size(); ++c)
    if (used[c]) ask(task.comparisons[c].expression);
  ask(task.metric);
  for (const GroundAction& action : task.actions)
    for (const GroundDuration& duration : action.duration) ask(duration.bound);
  for (std::size_t before = 0, now = 1; before != now;) {  // what a needed number is computed from is needed
    before = static_cast<std::size_t>(std::ranges::count(asked, 1));
    budget.spend(Work::kGround, static_cast<std::int64_t>(task.actions.size()));
    if (budget.over()) return;
    for_all_effects(task, [&](GroundEffects& effects) {
      for (const NumericEffect& effect : effects.numbers)
        if (asked[effect.number]) ask(effect.value);
    });
    for (const GroundAction& action : task.actions)
      for (const ContinuousEffect& effect : action.continuous)
        if (asked[effect.number]) ask(effect.rate);
    now = static_cast<std::size_t>(std::ranges::count(asked, 1));
  }
  const ById<int> comparisons = compact(task.comparisons, used);
  const ById<int> numbers = compact(task.numbers, asked);
  compact(task.initial_numbers, asked);
  for_all_conditions(task, [&](GroundCondition& condition) { rename(condition.comparisons, comparisons); });
  for_all_effects(task, [&](GroundEffects& effects) {
    std::erase_if(effects.numbers, [&](const NumericEffect& effect) { return numbers[effect.number] < 0; });
  });
  for (GroundAction& action : task.actions)
    std::erase_if(action.continuous, [&](const ContinuousEffect& effect) { return numbers[effect.number] < 0; });
  rename_numbers(task, numbers);
}

void put_significant_numbers_first(GroundTask& task) {
  const ById<char> significant = significant_numbers(task);
  ById<int> order(significant.size()), place(significant.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(), [&](int n) { return significant[n] != 0; });
  const ById<GroundNumber> numbers = task.numbers;
  const ById<double> values = task.initial_numbers;
  for (std::size_t to = 0; to < order.size(); ++to) {
    place[order[to]] = static_cast<int>(to);
    task.numbers[to] = numbers[order[to]];
    task.initial_numbers[to] = values[order[to]];
  }
  rename_numbers(task, place);
}

}  // namespace cxlab::planner
