#include "planner/search/simulator.h"

#include <algorithm>
#include <cmath>

#include "planner/ground/sorted.h"
#include "planner/state/number.h"

namespace cxlab::planner {

namespace {

constexpr double kSecond = static_cast<double>(kMicrosPerSecond);
constexpr Micros kLongStretch = 1000;  ///< times the shortest duration, where none is the longest
constexpr double kLongest = 1e12;      ///< seconds; beyond it a duration is not taken for one

void append(const GroundEffects& more, GroundEffects& to) {
  to.add.insert(to.add.end(), more.add.begin(), more.add.end());
  to.remove.insert(to.remove.end(), more.remove.begin(), more.remove.end());
  to.numbers.insert(to.numbers.end(), more.numbers.begin(), more.numbers.end());
}

void apply_numbers(const std::vector<NumericEffect>& effects, double* numbers, double duration_s) {
  std::vector<double> values;  // all are read before one is changed
  for (const NumericEffect& effect : effects) values.push_back(effect.value.evaluate(numbers, duration_s));
  for (std::size_t i = 0; i < values.size(); ++i) change(numbers[effects[i].number], effects[i].kind, values[i]);
}

/// Whether what these effects have changed is a number: none is too large, or divided by zero.
bool have_values(const std::vector<NumericEffect>& effects, const double* numbers) {
  return std::ranges::all_of(effects,
                             [numbers](const NumericEffect& effect) { return std::isfinite(numbers[effect.number]); });
}

void apply_continuous(const std::vector<ContinuousEffect>& effects, double* numbers, double duration_s) {
  std::vector<double> changes;
  for (const ContinuousEffect& effect : effects)
    changes.push_back(product(effect.rate.evaluate(numbers, duration_s), duration_s));
  for (std::size_t i = 0; i < changes.size(); ++i)
    numbers[effects[i].number] = sum(numbers[effects[i].number], changes[i]);
}

}  // namespace

void change(double& number, NumericEffect::Kind kind, double value) {
  switch (kind) {
    case NumericEffect::Kind::kAssign: number = value; break;
    case NumericEffect::Kind::kIncrease: number = sum(number, value); break;
    case NumericEffect::Kind::kScale: number = product(number, value); break;
    case NumericEffect::Kind::kDivide: number = quotient(number, value); break;
  }
  number += 0.0;  // no negative zero: equal states have equal bits
}

Simulator::Simulator(const GroundTask& task)
    : task_(task), fact_words_(task.words()), words_(fact_words_ + static_cast<int>(task.numbers.size())) {
  const std::vector<char> significant = significant_numbers(task);
  significant_words_ =
      fact_words_ +
      static_cast<int>(std::ranges::find(significant.rbegin(), significant.rend(), 1).base() - significant.begin());
  for (const GroundAction& action : task.actions) whole_.push_back(make_whole(action));
}

Simulator::Whole Simulator::make_whole(const GroundAction& action) const {
  Whole whole;
  whole.condition = action.start;
  for (const GroundCondition* later : {&action.over_all, &action.end}) {
    for (const int f : later->facts) {
      if (contains(action.at_start.remove, f)) whole.impossible = true;
      const bool derived = task_.facts[f].derived;  // may change with the beginning: looked at when it is applied
      if (!contains(action.at_start.add, f) && !derived && action.conditional.empty())
        whole.condition.facts.push_back(f);
    }
    if (action.at_start.numbers.empty() && action.continuous.empty() && action.conditional.empty())
      for (const int c : later->comparisons)
        if (task_.comparisons[c].linear.is_linear && task_.comparisons[c].linear.duration_weight == 0)
          whole.condition.comparisons.push_back(c);
  }
  sort_unique(whole.condition.facts);
  sort_unique(whole.condition.comparisons);
  std::vector<int> kept;
  for (const int f : action.at_start.add)
    if (!contains(action.at_end.remove, f)) kept.push_back(f);
  std::ranges::set_union(kept, action.at_end.add, std::back_inserter(whole.effects.add));
  std::ranges::set_union(action.at_start.remove, action.at_end.remove, std::back_inserter(whole.effects.remove));
  std::erase_if(whole.effects.remove, [&](int f) { return contains(whole.effects.add, f); });
  whole.numbers = action.at_start.numbers;
  whole.numbers.insert(whole.numbers.end(), action.at_end.numbers.begin(), action.at_end.numbers.end());
  whole.plain =
      action.conditional.empty() && action.continuous.empty() && task_.axioms.empty() &&
      std::ranges::none_of(action.duration, &GroundDuration::at_end) &&
      std::ranges::all_of(whole.numbers, [](const NumericEffect& effect) { return effect.value.is_constant(); });
  const auto constant = [](const GroundDuration& duration) { return duration.bound.is_constant() && !duration.at_end; };
  if (!action.durative) {
    whole.fixed = true;
  } else if (action.aim < 0 && std::ranges::all_of(action.duration, constant)) {
    const PackedState none(static_cast<std::size_t>(words_), 0);
    const int index = static_cast<int>(&action - task_.actions.data());
    if (const std::optional<DurationRange> range = durations(index, none.data())) {
      whole.fixed = true;
      whole.duration = *chosen(index, *range, none.data());
    } else {
      whole.impossible = true;
    }
  }
  for (const auto* condition : {&action.over_all, &action.end})
    for (const int c : condition->comparisons)
      if (!contains(whole.condition.comparisons, c)) whole.plain = false;
  if (action.durative && whole.fixed && whole.duration < kSeparation) whole.plain = false;
  return whole;
}

PackedState Simulator::initial() const {
  PackedState state(static_cast<std::size_t>(words_), 0);
  for (std::size_t f = 0; f < task_.facts.size(); ++f)
    if (task_.initial_facts[f]) set(state.data(), static_cast<int>(f));
  std::ranges::copy(task_.initial_numbers, mutable_numbers(state.data()));
  derive(state.data());
  return state;
}

bool Simulator::holds(const GroundCondition& condition, const Word* state, double duration_s) const {
  for (const int f : condition.facts)
    if (!is_set(state, f)) return false;
  for (const int c : condition.comparisons)
    if (!task_.comparisons[c].holds(numbers(state), duration_s)) return false;
  return true;
}

std::optional<DurationRange> Simulator::durations(int action, const Word* state) const {
  DurationRange range{kSeparation, DurationRange::kForever};
  for (const GroundDuration& constraint : task_.actions[action].duration) {
    if (constraint.at_end) continue;  // looked at when the action ends
    const double bound = constraint.bound.evaluate(numbers(state));
    if (!(std::abs(bound) < kLongest)) return std::nullopt;
    const Micros micros = in_micros(bound);
    if (micros < 0 && constraint.comparison != Comparison::kGreaterEqual) return std::nullopt;
    if (constraint.comparison == Comparison::kEqual)
      range.least = range.least == kSeparation ? micros : std::max(range.least, micros);
    else if (constraint.comparison == Comparison::kGreaterEqual)
      range.least = std::max(range.least, micros);
    if (constraint.comparison != Comparison::kGreaterEqual) range.most = std::min(range.most, micros);
  }
  if (range.least > range.most) return std::nullopt;
  return range;
}

std::optional<DurationRange> Simulator::durations_of_copy(int action, const Word* state) const {
  const GroundAction& a = task_.actions[action];
  const std::optional<DurationRange> range = durations(action, state);
  if (!range || (a.stretch == 0 && a.aim < 0)) return range;
  const std::optional<Micros> length = chosen(action, *range, state);
  if (!length) return std::nullopt;
  return DurationRange{*length, *length};
}

std::optional<Micros> Simulator::chosen(int action, const DurationRange& range, const Word* state) const {
  if (task_.actions[action].aim >= 0) return aimed(task_.actions[action], range, state);
  const double stretch = task_.actions[action].stretch;
  if (stretch == 0) return range.least;
  const Micros most = std::min(range.most, std::max(range.least, kMicrosPerSecond) * kLongStretch);
  return range.least + static_cast<Micros>(stretch * static_cast<double>(std::max<Micros>(0, most - range.least)));
}

/// The duration at whose end the comparison turns, on the side where it holds if there is one.
std::optional<Micros> Simulator::aimed(const GroundAction& action, const DurationRange& range,
                                       const Word* state) const {
  const double first = in_seconds(range.least);
  const double at_first = value_after(action, state, first), slope = value_after(action, state, first + 1) - at_first;
  const double exact = (first - at_first / slope) * kSecond;
  if (!(std::abs(exact) < kLongest * kSecond)) return std::nullopt;
  for (const double length :
       {std::round(exact), std::floor(exact), std::ceil(exact), std::round(exact) + 1, std::round(exact) - 1}) {
    const Micros micros = static_cast<Micros>(length);
    if (micros < range.least || micros > range.most) continue;
    if (task_.comparisons[action.aim].accepts(value_after(action, state, length / kSecond))) return micros;
  }
  return std::nullopt;
}

/// What the action that does nothing but change numbers makes of the value of its aim.
double Simulator::value_after(const GroundAction& action, const Word* state, double duration_s) const {
  ById<double> after(numbers(state), numbers(state) + task_.numbers.size());
  apply_numbers(action.at_start.numbers, after.data(), duration_s);
  apply_continuous(action.continuous, after.data(), duration_s);
  apply_numbers(action.at_end.numbers, after.data(), duration_s);
  return task_.comparisons[action.aim].gap(after.data(), duration_s);
}

bool Simulator::apply(int action, Word* state, Micros& duration) const {
  const Whole& whole = whole_[action];
  if (whole.fixed) {
    duration = whole.duration;
  } else {
    const std::optional<DurationRange> range = durations(action, state);
    const std::optional<Micros> length = range ? chosen(action, *range, state) : std::nullopt;
    if (!length) return false;
    duration = *length;
  }
  return apply_with(action, state, duration);
}

bool Simulator::apply_with(int action, Word* state, Micros duration) const {
  const Whole& whole = whole_[action];
  const GroundAction& a = task_.actions[action];
  if (whole.impossible || !holds(whole.condition, state, in_seconds(duration))) return false;
  // The beginning of an action that was cut takes no time, but the whole action must be able to last.
  if (!a.durative && !a.duration.empty() && !durations(action, state)) return false;
  if (whole.plain) {
    for (const int f : whole.effects.remove) reset(state, f);
    for (const int f : whole.effects.add) set(state, f);
    for (const NumericEffect& effect : whole.numbers)
      change(mutable_numbers(state)[effect.number], effect.kind, effect.value.steps[0].value);
    return have_values(whole.numbers, numbers(state));
  }
  Remembered remembered;
  // Its beginning and its end are one happening. Effects under conditions may interfere.
  if (a.durative && duration < kSeparation && (!a.conditional.empty() || !holds(a.end, state, in_seconds(duration))))
    return false;
  if (!begin(action, state, duration, remembered)) return false;
  if (!a.durative) return true;
  return over_all_holds(action, state, duration) && end(action, state, duration, remembered);
}

bool Simulator::begin(int action, Word* state, Micros duration, Remembered& remembered) const {
  const GroundAction& a = task_.actions[action];
  const double seconds = in_seconds(duration);
  if (!holds(a.start, state, seconds)) return false;
  remembered.clear();
  GroundEffects fired;
  for (const ConditionalEffects& conditional : a.conditional) {
    remembered.push_back(static_cast<char>(holds(conditional.start, state, seconds)));
    if (remembered.back()) append(conditional.at_start, fired);
  }
  if (fired.empty()) {
    apply_effects(a.at_start, state, seconds);
    return have_values(a.at_start.numbers, numbers(state));
  }
  GroundEffects all = a.at_start;
  append(fired, all);
  apply_effects(all, state, seconds);
  return have_values(all.numbers, numbers(state));
}

bool Simulator::end(int action, Word* state, Micros duration, const Remembered& remembered) const {
  const GroundAction& a = task_.actions[action];
  const double seconds = in_seconds(duration);
  if (!a.continuous.empty()) {
    apply_continuous(a.continuous, mutable_numbers(state), seconds);
    for (const ContinuousEffect& effect : a.continuous)
      if (std::isnan(numbers(state)[effect.number])) return false;
    derive(state);
    if (!over_all_holds(action, state, duration)) return false;  // linear in time: both ends decide
  }
  return finish(action, state, duration, remembered);
}

bool Simulator::finish(int action, Word* state, Micros duration, const Remembered& remembered) const {
  const GroundAction& a = task_.actions[action];
  const double seconds = in_seconds(duration);
  if (!holds(a.end, state, seconds)) return false;
  for (const GroundDuration& constraint : a.duration) {
    if (!constraint.at_end) continue;
    const double bound = constraint.bound.evaluate(numbers(state));
    if (constraint.comparison != Comparison::kLessEqual && !(seconds >= bound - 1e-6)) return false;
    if (constraint.comparison != Comparison::kGreaterEqual && !(seconds <= bound + 1e-6)) return false;
  }
  if (a.conditional.empty()) {
    apply_effects(a.at_end, state, seconds);
    return have_values(a.at_end.numbers, numbers(state));
  }
  GroundEffects all = a.at_end;
  for (std::size_t i = 0; i < a.conditional.size(); ++i) {
    const ConditionalEffects& conditional = a.conditional[i];
    if (remembered[i] && holds(conditional.over_all, state, seconds) && holds(conditional.end, state, seconds))
      append(conditional.at_end, all);
  }
  apply_effects(all, state, seconds);
  return have_values(all.numbers, numbers(state));
}

bool Simulator::over_all_holds(int action, const Word* state, Micros duration) const {
  return holds(task_.actions[action].over_all, state, in_seconds(duration));
}

bool Simulator::is_lasting_goal(const Word* state, int next_event) const {
  const int events = static_cast<int>(task_.events.size());
  if (next_event == events) return is_goal(state);
  PackedState later(state, state + words());
  for (int event = next_event; event < events; ++event) apply_event(event, later.data());
  return is_goal(later.data());
}

void Simulator::apply_event(int event, Word* state) const { apply_effects(task_.events[event].effects, state, 0); }

void Simulator::apply_effects(const GroundEffects& effects, Word* state, double duration_s) const {
  apply_numbers(effects.numbers, mutable_numbers(state), duration_s);
  for (const int f : effects.remove) reset(state, f);
  for (const int f : effects.add) set(state, f);
  derive(state);
}

void Simulator::derive(Word* state) const {
  derive(state, [&](const GroundCondition& body) { return holds(body, state); });
}

}  // namespace cxlab::planner
