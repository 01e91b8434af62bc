#include <algorithm>

#include "planner/ground/ground.h"
#include "planner/ground/passes.h"
#include "planner/ground/relaxation.h"
#include "planner/ground/renumber.h"
#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kLookWork = 4;  ///< of looking at all that an action asks and does, in pieces of Work::kGround

/// Whether an event may bring about a part of the goal.
bool events_help_goal(const GroundTask& task) {
  if (task.events.empty()) return false;
  if (std::ranges::any_of(task.goal.facts, [&](int f) { return task.facts[f].derived; })) return true;
  const auto reads = [&](int number) {
    return std::ranges::any_of(task.goal.comparisons,
                               [&](int c) { return task.comparisons[c].expression.mentions(number); });
  };
  return std::ranges::any_of(task.events, [&](const TimedEvent& event) {
    return std::ranges::any_of(event.effects.add, [&](int f) { return contains(task.goal.facts, f); }) ||
           std::ranges::any_of(event.effects.numbers,
                               [&](const NumericEffect& effect) { return reads(effect.number); });
  });
}

void keep_applicable(GroundTask& task, const Relaxation& relaxation) {
  ById<char> keep(task.actions.size(), 0);
  for (std::size_t a = 0; a < task.actions.size(); ++a) keep[a] = relaxation.applicable(a);
  compact(task.actions, keep);
}

/// Keeps actions that add a fact that is asked for, or change a number that is read, counting what the goal and kept
/// actions ask for.
void drop_irrelevant(GroundTask& task, Budget& budget) {
  if (events_help_goal(task)) return;  // any action may be needed to wait for them
  ById<char> fact(task.facts.size(), 0), number(task.numbers.size(), 0), keep(task.actions.size(), 0);
  ById<std::vector<int>> adders(task.facts.size()), removers(task.facts.size()), changers(task.numbers.size());
  const auto note = [&](const GroundEffects& effects, int action) {
    for (const int f : effects.add) adders[f].push_back(action);
    for (const int f : effects.remove) removers[f].push_back(action);
    for (const NumericEffect& effect : effects.numbers) changers[effect.number].push_back(action);
  };
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    for_each_effects(action, [&](const GroundEffects& effects) { note(effects, static_cast<int>(a)); });
    for (const ContinuousEffect& effect : action.continuous) changers[effect.number].push_back(static_cast<int>(a));
  }
  std::vector<int> queue;  // actions to look at
  const auto take = [&](int action) {
    if (!keep[action]) {
      keep[action] = 1;
      queue.push_back(action);
    }
  };
  const auto take_all = [&] {
    for (std::size_t a = 0; a < task.actions.size(); ++a) take(static_cast<int>(a));
  };
  const auto ask_number = [&](const GroundExpression& expression) {
    expression.for_each_number([&](int n) {
      if (number[n]) return;
      number[n] = 1;
      for (const int action : changers[n]) take(action);
    });
  };
  const auto ask = [&](const GroundCondition& condition) {
    std::vector<int> facts = condition.facts;
    for (const int c : condition.comparisons) ask_number(task.comparisons[c].expression);
    while (!facts.empty()) {
      const int f = facts.back();
      facts.pop_back();
      if (fact[f]) continue;
      fact[f] = 1;
      for (const int action : adders[f]) take(action);
      if (!task.facts[f].derived) continue;
      const int head = task.facts[f].is_complement ? task.facts[f].complement : f;
      budget.spend(Work::kGround, static_cast<std::int64_t>(1 + task.axioms.size() / kLooksOfWork));
      for (const Axiom& axiom : task.axioms) {
        if (axiom.head != head) continue;
        facts.insert(facts.end(), axiom.body.facts.begin(), axiom.body.facts.end());
        for (const int below :
             axiom.body.facts)  // the absence of a derived fact asks for the absence of what it is derived from
          if (task.facts[below].complement >= 0) facts.push_back(task.facts[below].complement);
        for (const int c : axiom.body.comparisons) ask_number(task.comparisons[c].expression);
      }
      if (task.facts[f].is_complement) take_all();  // what falsifies a body has no fact of its own: everything may help
    }
  };
  /// An effect that must not come about may have to be kept from it.
  const auto deny = [&](const GroundCondition& condition) {
    for (const int f : condition.facts) {
      if (task.facts[f].derived) take_all();
      for (const int action : removers[f]) take(action);
    }
  };
  ask(task.goal);
  ask_number(task.metric);
  while (!queue.empty()) {
    const GroundAction& action = task.actions[queue.back()];
    queue.pop_back();
    budget.spend(Work::kGround, kLookWork);
    if (budget.over()) return;
    ask(action.start);
    ask(action.over_all);
    ask(action.end);
    for (const ConditionalEffects& conditional : action.conditional)
      for (const GroundCondition* condition : {&conditional.start, &conditional.over_all, &conditional.end}) {
        ask(*condition);
        deny(*condition);
      }
    for (const GroundDuration& duration : action.duration) ask_number(duration.bound);
    for_each_effects(action, [&](const GroundEffects& effects) {
      for (const NumericEffect& effect : effects.numbers) ask_number(effect.value);
    });
    for (const ContinuousEffect& effect : action.continuous) ask_number(effect.rate);
  }
  compact(task.actions, keep);
}

/// Actions that ask and do the same are one: keeps the first.
void drop_copies(GroundTask& task, Budget& budget) {
  std::vector<std::pair<std::string, std::size_t>> keys;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    budget.spend(Work::kGround, kLookWork);
    if (budget.over()) return;
    const GroundAction& action = task.actions[a];
    if (!action.conditional.empty() || !action.continuous.empty()) continue;
    std::string key(1, static_cast<char>('0' + action.durative));
    const auto add = [&key](const std::vector<int>& ids) {
      for (const int id : ids) key.append(reinterpret_cast<const char*>(&id), sizeof id);
      key += '|';
      key.append(4, '\xff');
    };
    for (const auto* condition : {&action.start, &action.over_all, &action.end}) {
      add(condition->facts);
      add(condition->comparisons);
    }
    for (const auto* effects : {&action.at_start, &action.at_end}) {
      add(effects->add);
      add(effects->remove);
      for (const NumericEffect& effect : effects->numbers) {
        add({static_cast<int>(effect.kind), effect.number});
        effect.value.append_key(key);
      }
    }
    for (const GroundDuration& duration : action.duration) {
      add({static_cast<int>(duration.comparison), duration.at_end});
      duration.bound.append_key(key);
    }
    keys.emplace_back(std::move(key), a);
  }
  std::ranges::sort(keys);
  ById<char> keep(task.actions.size(), 1);
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) keep[keys[i].second] = 0;
  compact(task.actions, keep);
}

/// Numbers without a value that keep the goal out of reach. Keeps only the actions that would help.
void find_missing_values(GroundTask& task, const Relaxation& relaxation, Budget& budget) {
  const Relaxation with_values(task, budget, true);
  if (budget.over() || !with_values.reaches(task.goal)) return;
  keep_applicable(task, with_values);
  drop_irrelevant(task, budget);
  if (budget.over()) return;
  ById<char> missing(task.numbers.size(), 0);
  const auto read = [&](const GroundExpression& expression) {
    expression.for_each_number([&](int n) {
      if (!relaxation.has_value(n)) missing[n] = 1;
    });
  };
  const auto read_condition = [&](const GroundCondition& condition) {
    for (const int c : condition.comparisons) read(task.comparisons[c].expression);
  };
  read_condition(task.goal);
  for (const GroundAction& action : task.actions) {
    for (const auto* condition : {&action.start, &action.over_all, &action.end}) read_condition(*condition);
    for (const GroundDuration& duration : action.duration) read(duration.bound);
  }
  for (std::size_t n = 0; n < missing.size(); ++n)
    if (missing[n]) task.missing_values.push_back(static_cast<int>(n));
}

/// Keeps what can happen and what is asked for; false if the goal is out of reach.
bool keep_useful(GroundTask& task, Budget& budget) {
  const Relaxation relaxation(task, budget);
  if (budget.over()) return true;
  if (!relaxation.reaches(task.goal)) {
    find_missing_values(task, relaxation, budget);
    return false;
  }
  keep_applicable(task, relaxation);
  for (GroundAction& action : task.actions)
    std::erase_if(action.conditional, [&](const ConditionalEffects& conditional) {
      return !relaxation.reaches(conditional) || (conditional.at_start.empty() && conditional.at_end.empty());
    });
  std::erase_if(task.axioms, [&](const Axiom& axiom) { return !relaxation.reaches(axiom.body); });
  drop_irrelevant(task, budget);
  if (budget.over()) return true;
  budget.spend(Work::kGround, kLookWork * static_cast<std::int64_t>(task.actions.size()));
  drop_facts(task);
  if (!budget.over()) drop_numbers(task, budget);
  return true;
}

/// The same with what no pair of facts allows left out.
bool keep_possible(GroundTask& task, Budget& budget) {
  const Possible possible = possible_by_pairs(task, budget);
  if (budget.over()) return true;
  if (!possible.goal) return false;
  if (std::ranges::find(possible.actions, 0) == possible.actions.end()) return true;
  compact(task.actions, possible.actions);
  return keep_useful(task, budget);
}

}  // namespace

void prune_by_facts(GroundTask& task, Budget& budget) {
  task.proved_unsolvable = task.proved_unsolvable || !keep_useful(task, budget);
}

void prune(GroundTask& task, Budget& budget) {
  prune_by_facts(task, budget);
  if (budget.over() || task.proved_unsolvable) return;
  task.proved_unsolvable = !keep_possible(task, budget);
  if (budget.over() || task.proved_unsolvable) return;
  put_significant_numbers_first(task);
  drop_copies(task, budget);
  if (!budget.over()) offer_durations(task, budget);
}

}  // namespace cxlab::planner
