#include <algorithm>
#include <cmath>
#include <numeric>

#include "planner/ground/ground.h"
#include "planner/ground/mutex.h"

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostAims = 8;     ///< copies of an action that last until a comparison turns
constexpr std::int64_t kActionWork = 4;  ///< of looking at all that an action asks and does, in pieces of Work::kGround
constexpr std::size_t kLooksOfWork = 32;  ///< looks at whether a comparison or an axiom is known already, in one piece

/// What can happen if nothing is ever deleted and numbers go as far as they like in each direction in which they move.
/// The beginning of an action asks for its start condition only: others may bring about the rest while it runs.
/// A number without a value has none until one is assigned; before that what reads it or changes it cannot happen.
/// Says nothing if the budget ends.
class Relaxation {
 public:
  /// `any_value`: as if every number without a value had the right one.
  Relaxation(const GroundTask& task, Budget& budget, bool any_value = false)
      : task_(task), budget_(budget), any_value_(any_value), useless_(task.actions.size(), 0) {
    for (bool changed = true; changed && !budget.over();) {  // what can begin but never end is in no plan
      spread();
      changed = false;
      for (std::size_t a = 0; a < task.actions.size(); ++a)
        if (begun_[a] && !ended_[a]) useless_[a] = 1, changed = true;
    }
  }

  bool reaches(const GroundCondition& condition) const {
    return std::ranges::all_of(condition.facts, [this](int f) { return fact_[f] != 0; }) &&
           std::ranges::all_of(condition.comparisons, [this](int c) { return comparison_[c] != 0; });
  }
  bool applicable(std::size_t action) const { return ended_[action] != 0; }
  bool has_value(int number) const { return defined_[number] != 0; }

 private:
  bool has_value(const GroundExpression& expression) const {
    return any_value_ || std::ranges::all_of(expression.steps, [this](const GroundExpression::Step& step) {
             return step.kind == GroundExpression::Kind::kNumber ? defined_[step.number] != 0 : !std::isnan(step.value);
           });
  }
  bool has_values(const GroundEffects& effects) const {
    return any_value_ || std::ranges::all_of(effects.numbers, [this](const NumericEffect& effect) {
             return has_value(effect.value) && (effect.kind == NumericEffect::Kind::kAssign || defined_[effect.number]);
           });
  }
  bool has_duration(const GroundAction& action, bool ends) const {
    return std::ranges::all_of(action.duration, [&](const GroundDuration& duration) {
      return (duration.at_end && !ends) || has_value(duration.bound);
    });
  }

  void spread() {
    fact_.assign(task_.facts.size(), 0);
    comparison_.assign(task_.comparisons.size(), 0);
    begun_.assign(task_.actions.size(), 0);
    ended_.assign(task_.actions.size(), 0);
    up_.assign(task_.numbers.size(), 0);
    down_.assign(task_.numbers.size(), 0);
    defined_.assign(task_.numbers.size(), 0);
    for (std::size_t n = 0; n < task_.numbers.size(); ++n) defined_[n] = !std::isnan(task_.initial_numbers[n]);
    for (std::size_t f = 0; f < task_.facts.size(); ++f)
      fact_[f] = task_.initial_facts[f] || (task_.facts[f].derived && task_.facts[f].is_complement);
    for (std::size_t c = 0; c < task_.comparisons.size(); ++c) {
      const GroundComparison& comparison = task_.comparisons[c];
      comparison_[c] = comparison.holds(task_.initial_numbers.data()) ||
                       (any_value_ && std::isnan(comparison.expression.evaluate(task_.initial_numbers.data())));
    }
    refresh();
    for (const TimedEvent& event : task_.events) apply(event.effects);
    for (bool changed = true; changed && !budget_.over();) changed = round();
  }

  void look(std::size_t count) {
    looks_ += count;
    budget_.spend(Work::kGround, static_cast<std::int64_t>(looks_ / kLooksOfWork));
    looks_ %= kLooksOfWork;
  }

  bool round() {
    bool changed = false;
    look(task_.axioms.size());
    for (std::size_t a = 0; a < task_.actions.size(); ++a) {
      budget_.spend(Work::kGround, 1);
      if (budget_.over()) return false;
      const GroundAction& action = task_.actions[a];
      if (useless_[a] || (ended_[a] && action.conditional.empty()) || !reaches(action.start)) continue;
      if (!begun_[a]) {
        if (!has_duration(action, false)) continue;
        begun_[a] = 1;
        changed = true;
        apply(action.at_start);
        for (const ContinuousEffect& effect : action.continuous) move_number(effect.number, effect.rate);
        refresh();
      }
      if (!ended_[a] && reaches(action.over_all) && reaches(action.end) && has_duration(action, true)) {
        ended_[a] = 1;
        changed = true;
        apply(action.at_end);
      }
      for (const ConditionalEffects& conditional : action.conditional) {
        if (!reaches(conditional.start)) continue;
        if (has_values(conditional.at_start)) changed |= apply(conditional.at_start);
        if (ended_[a] && reaches(conditional.over_all) && reaches(conditional.end) && has_values(conditional.at_end))
          changed |= apply(conditional.at_end);
      }
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
        up_[effect.number] = down_[effect.number] = defined_[effect.number] = 1;
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
    look(task_.comparisons.size());
    for (std::size_t c = 0; c < task_.comparisons.size(); ++c) {
      const GroundComparison& comparison = task_.comparisons[c];
      if (comparison_[c] || !has_value(comparison.expression)) continue;
      comparison_[c] = !comparison.linear.is_linear || comparison.linear.duration_weight != 0;
      for (const auto& [number, weight] : comparison.linear.weights) {
        const bool rises = weight > 0 ? up_[number] : down_[number], falls = weight > 0 ? down_[number] : up_[number];
        if (rises || (falls && comparison.kind == GroundComparison::Kind::kZero)) comparison_[c] = 1;
      }
    }
  }

  const GroundTask& task_;
  Budget& budget_;
  std::size_t looks_ = 0;
  bool any_value_;
  std::vector<char> useless_;  ///< by action
  std::vector<char> fact_, comparison_, begun_, ended_, up_, down_, defined_;
};

template <class Visit>
void for_each_condition(GroundTask& task, const Visit& visit) {
  for (GroundAction& action : task.actions) {
    visit(action.start), visit(action.over_all), visit(action.end);
    for (ConditionalEffects& conditional : action.conditional)
      visit(conditional.start), visit(conditional.over_all), visit(conditional.end);
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

/// Whether an event may bring about a part of the goal.
bool events_help_goal(const GroundTask& task) {
  if (task.events.empty()) return false;
  if (std::ranges::any_of(task.goal.facts, [&](int f) { return task.facts[f].derived; })) return true;
  const auto reads = [&](int number) {
    return std::ranges::any_of(task.goal.comparisons, [&](int c) {
      return std::ranges::any_of(task.comparisons[c].expression.steps,
                                 [&](const auto& step) { return step.number == number; });
    });
  };
  return std::ranges::any_of(task.events, [&](const TimedEvent& event) {
    return std::ranges::any_of(event.effects.add,
                               [&](int f) { return std::ranges::binary_search(task.goal.facts, f); }) ||
           std::ranges::any_of(event.effects.numbers,
                               [&](const NumericEffect& effect) { return reads(effect.number); });
  });
}

void keep_applicable(GroundTask& task, const Relaxation& relaxation) {
  std::vector<char> keep(task.actions.size(), 0);
  for (std::size_t a = 0; a < task.actions.size(); ++a) keep[a] = relaxation.applicable(a);
  compact(task.actions, keep);
}

/// Keeps actions that add a fact that is asked for, or change a number that is read, counting what the goal and kept
/// actions ask for.
void drop_irrelevant(GroundTask& task, Budget& budget) {
  if (events_help_goal(task)) return;  // any action may be needed to wait for them
  std::vector<char> fact(task.facts.size(), 0), number(task.numbers.size(), 0), keep(task.actions.size(), 0);
  std::vector<std::vector<int>> adders(task.facts.size()), removers(task.facts.size()), changers(task.numbers.size());
  const auto note = [&](const GroundEffects& effects, int action) {
    for (const int f : effects.add) adders[f].push_back(action);
    for (const int f : effects.remove) removers[f].push_back(action);
    for (const NumericEffect& effect : effects.numbers) changers[effect.number].push_back(action);
  };
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    note(action.at_start, static_cast<int>(a)), note(action.at_end, static_cast<int>(a));
    for (const ConditionalEffects& conditional : action.conditional)
      note(conditional.at_start, static_cast<int>(a)), note(conditional.at_end, static_cast<int>(a));
    for (const ContinuousEffect& effect : action.continuous) changers[effect.number].push_back(static_cast<int>(a));
  }
  std::vector<int> queue;  // actions to look at
  const auto take = [&](int action) {
    if (!keep[action]) keep[action] = 1, queue.push_back(action);
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
    budget.spend(Work::kGround, kActionWork);
    if (budget.over()) return;
    ask(action.start), ask(action.over_all), ask(action.end);
    for (const ConditionalEffects& conditional : action.conditional)
      for (const GroundCondition* condition : {&conditional.start, &conditional.over_all, &conditional.end})
        ask(*condition), deny(*condition);
    for (const GroundDuration& duration : action.duration) ask_number(duration.bound);
    for (const auto* effects : {&action.at_start, &action.at_end})
      for (const NumericEffect& effect : effects->numbers) ask_number(effect.value);
    for (const ConditionalEffects& conditional : action.conditional)
      for (const auto* effects : {&conditional.at_start, &conditional.at_end})
        for (const NumericEffect& effect : effects->numbers) ask_number(effect.value);
    for (const ContinuousEffect& effect : action.continuous) ask_number(effect.rate);
  }
  compact(task.actions, keep);
}

/// Actions that ask and do the same are one: keeps the first.
void drop_copies(GroundTask& task, Budget& budget) {
  std::vector<std::pair<std::string, std::size_t>> keys;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    budget.spend(Work::kGround, kActionWork);
    if (budget.over()) return;
    const GroundAction& action = task.actions[a];
    if (!action.conditional.empty() || !action.continuous.empty()) continue;
    std::string key(1, static_cast<char>('0' + action.durative));
    const auto add = [&key](const std::vector<int>& ids) {
      for (const int id : ids) key.append(reinterpret_cast<const char*>(&id), sizeof id);
      key += '|';
      key.append(4, '\xff');
    };
    const auto add_expression = [&key](const GroundExpression& expression) {
      for (const auto& step : expression.steps) {
        key += static_cast<char>(step.kind);
        key.append(reinterpret_cast<const char*>(&step.number), sizeof step.number);
        key.append(reinterpret_cast<const char*>(&step.value), sizeof step.value);
      }
      key += '|';
    };
    for (const auto* condition : {&action.start, &action.over_all, &action.end})
      add(condition->facts), add(condition->comparisons);
    for (const auto* effects : {&action.at_start, &action.at_end}) {
      add(effects->add), add(effects->remove);
      for (const NumericEffect& effect : effects->numbers) {
        add({static_cast<int>(effect.kind), effect.number});
        add_expression(effect.value);
      }
    }
    for (const GroundDuration& duration : action.duration) {
      add({static_cast<int>(duration.comparison), duration.at_end});
      add_expression(duration.bound);
    }
    keys.emplace_back(std::move(key), a);
  }
  std::ranges::sort(keys);
  std::vector<char> keep(task.actions.size(), 1);
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].first == keys[i - 1].first) keep[keys[i].second] = 0;
  compact(task.actions, keep);
}

/// Comparisons that the length of the action may turn, those of the goal and its own first.
std::vector<int> aims(const GroundTask& task, const GroundAction& action) {
  std::vector<char> changes(task.numbers.size(), 0);
  for (const ContinuousEffect& effect : action.continuous) changes[effect.number] = 1;
  for (const auto* effects : {&action.at_start, &action.at_end})
    for (const NumericEffect& effect : effects->numbers) changes[effect.number] = 1;
  std::vector<int> order = task.goal.comparisons;
  order.insert(order.end(), action.over_all.comparisons.begin(), action.over_all.comparisons.end());
  for (std::size_t c = 0; c < task.comparisons.size(); ++c) order.push_back(static_cast<int>(c));
  std::vector<int> found;
  for (const int c : order) {
    const LinearForm& linear = task.comparisons[c].linear;
    if (found.size() == kMostAims) break;
    if (linear.is_linear && std::ranges::find(found, c) == found.end() &&
        std::ranges::any_of(linear.weights, [&](const auto& weight) { return changes[weight.first] != 0; }))
      found.push_back(c);
  }
  return found;
}

/// Numbers without a value that keep the goal out of reach. Of the actions those stay that would help.
void find_missing_values(GroundTask& task, const Relaxation& relaxation, Budget& budget) {
  const Relaxation with_values(task, budget, true);
  if (budget.over() || !with_values.reaches(task.goal)) return;
  keep_applicable(task, with_values);
  drop_irrelevant(task, budget);
  if (budget.over()) return;
  std::vector<char> missing(task.numbers.size(), 0);
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

/// Where effects depend on a duration that may be chosen, the action is there with several.
void offer_durations(GroundTask& task, Budget& budget) {
  const auto mentions = [](const GroundExpression& expression) {
    return std::ranges::any_of(expression.steps,
                               [](const auto& step) { return step.kind == GroundExpression::Kind::kDuration; });
  };
  std::vector<GroundAction> offered;
  for (GroundAction& action : task.actions) {
    budget.spend(Work::kGround, 1);
    if (budget.over()) return;
    bool depends = !action.continuous.empty();
    for (const auto* effects : {&action.at_start, &action.at_end})
      for (const NumericEffect& effect : effects->numbers) depends = depends || mentions(effect.value);
    for (const auto* condition : {&action.start, &action.over_all, &action.end})
      for (const int c : condition->comparisons) depends = depends || mentions(task.comparisons[c].expression);
    const bool chosen = action.durative && depends && std::ranges::none_of(action.duration, [](const auto& d) {
                          return d.comparison == Comparison::kEqual;
                        });
    if (!chosen) {
      offered.push_back(std::move(action));
      continue;
    }
    budget.spend(Work::kGround, static_cast<std::int64_t>(task.comparisons.size()) +
                                    kActionWork * static_cast<std::int64_t>(kMostAims));
    for (const int aim : aims(task, action)) offered.push_back(action), offered.back().aim = aim;
    offered.push_back(action);
    for (const double stretch : {0.125, 0.25, 0.5, 1.0}) offered.push_back(action), offered.back().stretch = stretch;
  }
  task.actions = std::move(offered);
}

void drop_facts(GroundTask& task) {
  // What makes a fact true that is true already must still keep clear of what reads it.
  std::vector<char> added(task.facts.size(), 0), removed(added), asked(added);
  for_each_effects(task, [&](GroundEffects& effects) {
    for (const int f : effects.add) added[f] = 1;
    for (const int f : effects.remove) removed[f] = 1;
  });
  for_each_condition(task, [&](GroundCondition& condition) {
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
  const std::vector<int> renamed = compact(task.facts, asked);
  compact(task.initial_facts, asked);
  for_each_condition(task, [&](GroundCondition& condition) { rename(condition.facts, renamed); });
  for_each_effects(task,
                   [&](GroundEffects& effects) { rename(effects.add, renamed), rename(effects.remove, renamed); });
  for (Axiom& axiom : task.axioms) axiom.head = renamed[axiom.head];
  for (GroundFact& fact : task.facts)
    if (fact.complement >= 0) fact.complement = renamed[fact.complement];
}

void rename_numbers(GroundTask& task, const std::vector<int>& renamed) {
  for (GroundComparison& comparison : task.comparisons) {
    rename(comparison.expression, renamed);
    comparison.linear = linear_form(comparison.expression);
  }
  for_each_effects(task, [&](GroundEffects& effects) {
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

void drop_numbers(GroundTask& task, Budget& budget) {
  std::vector<char> asked(task.numbers.size(), 0), used(task.comparisons.size(), 0);
  const auto ask = [&asked](const GroundExpression& expression) {
    expression.for_each_number([&asked](int n) { asked[n] = 1; });
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
    budget.spend(Work::kGround, static_cast<std::int64_t>(task.actions.size()));
    if (budget.over()) return;
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
  for_each_effects(task, [&](GroundEffects& effects) {
    std::erase_if(effects.numbers, [&](const NumericEffect& effect) { return numbers[effect.number] < 0; });
  });
  for (GroundAction& action : task.actions)
    std::erase_if(action.continuous, [&](const ContinuousEffect& effect) { return numbers[effect.number] < 0; });
  rename_numbers(task, numbers);
}

void put_telling_numbers_first(GroundTask& task) {
  const std::vector<char> telling = telling_numbers(task);
  std::vector<int> order(telling.size()), place(telling.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(), [&](int n) { return telling[n] != 0; });
  const std::vector<GroundNumber> numbers = task.numbers;
  const std::vector<double> values = task.initial_numbers;
  for (std::size_t to = 0; to < order.size(); ++to) {
    place[order[to]] = static_cast<int>(to);
    task.numbers[to] = numbers[order[to]];
    task.initial_numbers[to] = values[order[to]];
  }
  rename_numbers(task, place);
}

/// Keeps what can happen and what somebody asks for; false if the goal is out of reach.
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
      return !relaxation.reaches(conditional.start) || !relaxation.reaches(conditional.over_all) ||
             !relaxation.reaches(conditional.end) || (conditional.at_start.empty() && conditional.at_end.empty());
    });
  std::erase_if(task.axioms, [&](const Axiom& axiom) { return !relaxation.reaches(axiom.body); });
  drop_irrelevant(task, budget);
  if (budget.over()) return true;
  budget.spend(Work::kGround, kActionWork * static_cast<std::int64_t>(task.actions.size()));
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

void prune(GroundTask& task, Budget& budget) {
  if (task.proved_unsolvable || !keep_useful(task, budget) || (!budget.over() && !keep_possible(task, budget))) {
    task.proved_unsolvable = true;
    return;
  }
  if (budget.over()) return;
  put_telling_numbers_first(task);
  drop_copies(task, budget);
  if (!budget.over()) offer_durations(task, budget);
}

}  // namespace cxlab::planner
