#include "planner/ground/relaxation.h"

#include <algorithm>
#include <cmath>

namespace cxlab::planner {

Relaxation::Relaxation(const GroundTask& task, Budget& budget, bool any_value)
    : task_(task), budget_(budget), any_value_(any_value), useless_(task.actions.size(), 0) {
  for (bool changed = true; changed && !budget.over();) {  // what can begin but never end is in no plan
    spread();
    changed = false;
    for (std::size_t a = 0; a < task.actions.size(); ++a)
      if (begun_[a] && !ended_[a]) {
        useless_[a] = 1;
        changed = true;
      }
  }
}

bool Relaxation::reaches(const GroundCondition& condition) const {
  return std::ranges::all_of(condition.facts, [this](int f) { return fact_[f] != 0; }) &&
         std::ranges::all_of(condition.comparisons, [this](int c) { return comparison_[c] != 0; });
}

bool Relaxation::has_value(const GroundExpression& expression) const {
  return any_value_ || std::ranges::all_of(expression.steps, [this](const GroundExpression::Step& step) {
           return step.kind == GroundExpression::Kind::kFunction ? defined_[step.number] != 0 : !std::isnan(step.value);
         });
}

bool Relaxation::has_values(const GroundEffects& effects) const {
  return any_value_ || std::ranges::all_of(effects.numbers, [this](const NumericEffect& effect) {
           return has_value(effect.value) && (effect.kind == NumericEffect::Kind::kAssign || defined_[effect.number]);
         });
}

bool Relaxation::has_duration(const GroundAction& action, bool ends) const {
  return std::ranges::all_of(action.duration, [&](const GroundDuration& duration) {
    return (duration.at_end && !ends) || has_value(duration.bound);
  });
}

void Relaxation::spread() {
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

void Relaxation::look(std::size_t count) {
  looks_ += count;
  budget_.spend(Work::kGround, static_cast<std::int64_t>(looks_ / kLooksOfWork));
  looks_ %= kLooksOfWork;
}

bool Relaxation::round() {
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
    if (!fact_[axiom.head] && reaches(axiom.body)) {
      fact_[axiom.head] = 1;
      changed = true;
    }
  return changed;
}

bool Relaxation::apply(const GroundEffects& effects) {
  bool changed = false;
  for (const int f : effects.add)
    if (!fact_[f]) {
      fact_[f] = 1;
      changed = true;
    }
  if (move(effects)) {
    changed = true;
    refresh();
  }
  return changed;
}

bool Relaxation::move(const GroundEffects& effects) {
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

bool Relaxation::move_number(int number, const GroundExpression& change) {
  const bool known = change.is_constant();
  const bool up = !known || change.steps[0].value > 0, down = !known || change.steps[0].value < 0;
  const bool changed = (up && !up_[number]) || (down && !down_[number]);
  up_[number] |= static_cast<char>(up);
  down_[number] |= static_cast<char>(down);
  return changed;
}

void Relaxation::refresh() {
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

}  // namespace cxlab::planner
