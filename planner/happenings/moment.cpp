#include "planner/happenings/moment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "planner/ground/sorted.h"
#include "planner/happenings/linear_program.h"
#include "planner/search/split.h"

namespace cxlab::planner {

namespace {

constexpr double kMicro = static_cast<double>(kMicrosPerSecond);
constexpr double kLongest = 1e9;       ///< seconds; validators accept no later time
constexpr double kNoWeight = 1e-12;    ///< weights that are left by rounding
constexpr double kRounding = 1e-4;     ///< microseconds by which a computed time may miss a whole one
constexpr double kSlack = 1e-6;        ///< by which a value may miss what is asked for in proofs
constexpr double kNothing = 1e-9;      ///< by which a computed value may miss it in plans, which validators judge again
constexpr double kMostFollowed = 5;    ///< copies of an action that are followed one by one where there are no more
constexpr double kPositive = 1e-6;     ///< the least value that is asked for where one is to be positive
constexpr std::int64_t kStepWork = 2;  ///< in pieces of Work::kNode
/// What a step spends for each pair of points, and for each action that may come next, in pieces of Work::kTimes.
constexpr std::int64_t kLooksOfPair = 20, kLooksOfCandidate = 4;

TimedNumber plus(const TimedNumber& a, const TimedNumber& b, double factor) {
  TimedNumber sum{a.constant + factor * b.constant, a.weights};
  for (const auto& [point, weight] : b.weights) {
    const auto place = std::ranges::lower_bound(sum.weights, point, {}, &std::pair<int, double>::first);
    if (place != sum.weights.end() && place->first == point)
      place->second += factor * weight;
    else
      sum.weights.insert(place, {point, factor * weight});
  }
  std::erase_if(sum.weights, [](const auto& entry) { return std::abs(entry.second) < kNoWeight; });
  return sum;
}

TimedNumber scaled(TimedNumber number, double factor) {
  number.constant *= factor;
  for (auto& entry : number.weights) entry.second *= factor;
  std::erase_if(number.weights, [](const auto& entry) { return std::abs(entry.second) < kNoWeight; });
  return number;
}

TimedNumber distance(int from, int to, double factor = 1) {
  TimedNumber value;
  if (from == to) return value;
  value.weights = {{from, -factor}, {to, factor}};
  std::ranges::sort(value.weights);
  return value;
}

/// Writes points at a fixed distance as one.
void simplify(const Zone& zone, TimedNumber& value) {
  for (std::size_t i = 0; i < value.weights.size();) {
    const auto [point, weight] = value.weights[i];
    int same = 0;
    while (same < point && !zone.is_fixed(same, point)) ++same;
    if (same == point) {
      ++i;
      continue;
    }
    const double away = weight * in_seconds(zone.most(same, point));
    value.weights.erase(value.weights.begin() + static_cast<std::ptrdiff_t>(i));
    value.constant += away;
    value = plus(value, TimedNumber{0, {{same, weight}}}, 1);
    i = 0;
  }
}

bool mentions_duration(const GroundAction& action, const GroundTask& task) {
  bool found = reads_duration(action);
  for (const GroundDuration& duration : action.duration) found = found || duration.at_end;
  for_each_condition(action, [&](const GroundCondition& condition) {
    for (const int c : condition.comparisons) found = found || task.comparisons[c].expression.mentions_duration();
  });
  for_each_effects(action, [&](const GroundEffects& effects) {
    for (const NumericEffect& effect : effects.numbers) found = found || effect.value.mentions_duration();
  });
  for (const ContinuousEffect& effect : action.continuous) found = found || effect.rate.mentions_duration();
  return found;
}

}  // namespace

Moments::Moments(const GroundTask& task, const Simulator& simulator, Budget& budget, Options options)
    : task_(task),
      simulator_(simulator),
      budget_(budget),
      touches_(task, Touches::kPointsOnly, options.relaxed || options.certain ? Touches::kCertain : Touches::kApart),
      options_(options) {
  ById<char> lasts(task.facts.size(), 1);  // nothing deletes it
  for (const GroundAction& action : task.actions)
    for_each_effects(action, [&](const GroundEffects& effects) {
      for (const int f : effects.remove) lasts[f] = 0;
    });
  for (const TimedEvent& event : task.events)
    for (const int f : event.effects.remove) lasts[f] = 0;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    const bool chooses = action.stretch > 0 || action.aim >= 0;  // here all durations are open
    if (!chooses) candidates_.push_back(static_cast<int>(a));
    bool once = task.axioms.empty() && action.conditional.empty() && action.continuous.empty();
    for (const auto* effects : {&action.at_start, &action.at_end})
      once =
          once && effects->numbers.empty() && std::ranges::all_of(effects->add, [&](int f) { return lasts[f] != 0; });
    repeats_nothing_.push_back(once);
    reads_duration_.push_back(mentions_duration(action, task));
    most_at_once_.push_back(most_copies(action));
  }
  for (const Axiom& axiom : task.axioms) axioms_read_numbers_ |= !axiom.body.comparisons.empty();
}

namespace {

/// By how much effects change the gap of a comparison; none if that depends on more than the effects.
std::optional<double> change_of(const LinearForm& gap, const GroundEffects& effects) {
  double sum = 0;
  for (const NumericEffect& effect : effects.numbers) {
    const auto weight = std::ranges::find(gap.weights, effect.number, &std::pair<int, double>::first);
    if (weight == gap.weights.end()) continue;
    if (effect.kind != NumericEffect::Kind::kIncrease || !effect.value.is_constant()) return std::nullopt;
    sum += weight->second * effect.value.steps[0].value;
  }
  return sum;
}

}  // namespace

/// How many copies of `action` the gap of a comparison has room for at once, if each copy takes a part of the gap at
/// its start. Only the ends of actions may give back, and no more than they took; else the number is not known (none).
std::optional<double> Moments::room(const LinearForm& gap, const GroundAction& action) const {
  const auto touches = [&](int number) {
    return std::ranges::find(gap.weights, number, &std::pair<int, double>::first) != gap.weights.end();
  };
  for (const TimedEvent& event : task_.events)
    for (const NumericEffect& effect : event.effects.numbers)
      if (touches(effect.number)) return std::nullopt;
  for (const GroundAction& other : task_.actions) {
    for (const ContinuousEffect& effect : other.continuous)
      if (touches(effect.number)) return std::nullopt;
    for (const ConditionalEffects& conditional : other.conditional)
      for (const auto* effects : {&conditional.at_start, &conditional.at_end})
        for (const NumericEffect& effect : effects->numbers)
          if (touches(effect.number)) return std::nullopt;
    const std::optional<double> first = change_of(gap, other.at_start), last = change_of(gap, other.at_end);
    if (!first || !last || !(*first <= 0) || !(*first + *last <= 0)) return std::nullopt;
  }
  const double takes = -*change_of(gap, action.at_start);
  double all = gap.constant;
  for (const auto& [number, weight] : gap.weights) all += weight * task_.initial_numbers[number];
  return takes > 0 && std::isfinite(all) ? std::optional(std::max(0.0, std::floor(all / takes + kSlack)))
                                         : std::nullopt;
}

/// As many copies as its conditions over all leave room for may end at an instant at which as many begin.
int Moments::most_copies(const GroundAction& action) const {
  int most = std::numeric_limits<int>::max();
  if (!action.durative || constant_durations(action).least <= 0) return most;
  for (const int c : action.over_all.comparisons) {
    const LinearForm& gap = task_.comparisons[c].linear;
    if (!gap.is_linear || gap.duration_weight != 0) continue;
    if (const std::optional<double> copies = room(gap, action); copies && *copies < kMostFollowed)
      most = std::min(most, 2 * static_cast<int>(*copies));
  }
  return most;
}

Moment Moments::initial() const {
  Moment moment;
  moment.state = simulator_.initial();
  moment.origin = moment.now = moment.zone.add_point();
  tidy(moment);
  return moment;
}

// ---- numbers -------------------------------------------------------------------------------------------------------

TimedNumber Moments::number(const Moment& moment, int number) const {
  const auto place = std::ranges::lower_bound(moment.varying, number, {}, &std::pair<int, TimedNumber>::first);
  if (place != moment.varying.end() && place->first == number) return place->second;
  return {simulator_.numbers(moment.state.data())[number], {}};
}

void Moments::set_number(Moment& moment, int number, TimedNumber value) const {
  double& stored = reinterpret_cast<double*>(moment.state.data() + task_.words())[number];
  const auto place = std::ranges::lower_bound(moment.varying, number, {}, &std::pair<int, TimedNumber>::first);
  const bool known = place != moment.varying.end() && place->first == number;
  if (value.is_constant()) {
    stored = value.constant + 0.0;  // no negative zero: equal states have equal bits
    if (known) moment.varying.erase(place);
    return;
  }
  stored = 0;
  if (known)
    place->second = std::move(value);
  else
    moment.varying.insert(place, {number, std::move(value)});
}

TimedNumber Moments::duration(const Moment& moment, const Moment::Running& running) {
  if (running.start < 0 || running.end < 0) return {};
  TimedNumber value = distance(running.start, running.end);
  simplify(moment.zone, value);
  return value;
}

namespace {

/// Runs steps on numbers that may depend on times; what is left on the stack. None where numbers that do are multiplied
/// with each other, or divided by.
template <class Number>
std::optional<std::vector<TimedNumber>> run(std::span<const GroundExpression::Step> steps, const Number& number,
                                            const TimedNumber& duration) {
  using Kind = GroundExpression::Kind;
  std::vector<TimedNumber> stack;
  for (const GroundExpression::Step& step : steps) {
    switch (step.kind) {
      case Kind::kConstant: stack.push_back({step.value, {}}); continue;
      case Kind::kFunction: stack.push_back(number(step.number)); continue;
      case Kind::kDuration: stack.push_back(duration); continue;
      case Kind::kTotalTime: return std::nullopt;
      case Kind::kNegate: stack.back() = scaled(std::move(stack.back()), -1); continue;
      default: break;
    }
    const TimedNumber right = std::move(stack.back());
    stack.pop_back();
    TimedNumber& left = stack.back();
    if (step.kind == Kind::kAdd || step.kind == Kind::kSubtract) {
      left = plus(left, right, step.kind == Kind::kAdd ? 1 : -1);
    } else if (step.kind == Kind::kMultiply) {
      if (!left.is_constant() && !right.is_constant()) return std::nullopt;
      left = left.is_constant() ? scaled(right, left.constant) : scaled(std::move(left), right.constant);
    } else {
      if (!right.is_constant()) return std::nullopt;
      if (left.is_constant())
        left.constant /= right.constant;
      else
        left = scaled(std::move(left), 1 / right.constant);
    }
  }
  return stack;
}

}  // namespace

/// None: it cannot be followed.
std::optional<TimedNumber> Moments::evaluate(const Moment& moment, const GroundExpression& expression,
                                             const TimedNumber& duration) const {
  if (moment.varying.empty() && duration.is_constant())
    return TimedNumber{expression.evaluate(simulator_.numbers(moment.state.data()), duration.constant), {}};
  auto stack = run(expression.steps, [&](int n) { return number(moment, n); }, duration);
  if (!stack) return std::nullopt;
  if (!std::isfinite(stack->back().constant)) return TimedNumber{std::nan(""), {}};
  return std::move(stack->back());
}

std::optional<TimedNumber> Moments::gap(const Moment& moment, int index, const TimedNumber& duration) const {
  const GroundComparison& comparison = task_.comparisons[index];
  if (moment.varying.empty() && duration.is_constant())
    return TimedNumber{comparison.gap(simulator_.numbers(moment.state.data()), duration.constant), {}};
  bool constant = duration.is_constant() || !comparison.expression.mentions_duration();
  for (const auto& [number, value] : moment.varying) constant = constant && !comparison.expression.mentions(number);
  if (constant) return TimedNumber{comparison.gap(simulator_.numbers(moment.state.data()), duration.constant), {}};
  const std::span most(comparison.expression.steps.data(), comparison.expression.steps.size() - 1);
  const auto stack = run(most, [&](int n) { return number(moment, n); }, duration);
  if (!stack || stack->size() != 2) return std::nullopt;
  TimedNumber value = plus((*stack)[0], (*stack)[1], -1);
  if (std::isnan(value.constant)) return TimedNumber{std::nan(""), {}};
  simplify(moment.zone, value);
  return value;
}

/// Whether a comparison accepts a value that depends on no time. It may have been computed from times.
bool Moments::accepts(int comparison, double gap) const {
  const GroundComparison& each = task_.comparisons[comparison];
  if (!options_.relaxed) return each.accepts(gap);
  return each.kind == GroundComparison::Kind::kZero ? std::abs(gap) <= kSlack : gap >= -kSlack;
}

/// Asks the times for it. False if no times are left.
bool Moments::demand(Moment& moment, TimedDemand demand) const {
  using Kind = GroundComparison::Kind;
  TimedNumber& value = demand.value;
  simplify(moment.zone, value);
  if (value.is_constant()) {
    const double slack = options_.relaxed ? kSlack : kNothing;
    if (demand.kind == Kind::kPositive && !options_.relaxed) return value.constant > 0;
    return demand.kind == Kind::kZero ? std::abs(value.constant) <= slack : value.constant >= -slack;
  }
  if (value.weights.size() > 2) {
    if (std::ranges::find(moment.demands, demand) == moment.demands.end()) moment.demands.push_back(std::move(demand));
    return true;
  }
  auto [from, to] = std::pair(value.weights[0].first, value.weights[1].first);
  double weight = value.weights[1].second;
  if (weight < 0) {
    std::swap(from, to);
    weight = -weight;
  }
  const double exact = -value.constant / weight * kMicro;  // that `to` is after `from` at least, or exactly
  if (!(std::abs(exact) < kLongest * kMicro)) return demand.kind != Kind::kZero && exact < 0;
  const double below = std::floor(exact + kRounding), above = std::ceil(exact - kRounding);
  const auto require = [&](int a, int b, double least) {
    return moment.zone.require(a, b, static_cast<Micros>(least));
  };
  if (demand.kind == Kind::kZero) {
    if (options_.relaxed) return require(from, to, below) && require(to, from, -above);
    return require(from, to, std::round(exact)) && require(to, from, -std::round(exact));
  }
  if (options_.relaxed) return require(from, to, below);
  return require(from, to, demand.kind == Kind::kPositive ? below + 1 : above);
}

bool Moments::demand(Moment& moment, const GroundCondition& condition, const TimedNumber& duration) const {
  for (const int f : condition.facts)
    if (!is_set(moment.state.data(), f)) return false;
  for (const int c : condition.comparisons) {
    std::optional<TimedNumber> value = gap(moment, c, duration);
    if (!value) return leave_out();
    const GroundComparison::Kind kind = task_.comparisons[c].kind;
    if (value->is_constant() ? !accepts(c, value->constant) : !demand(moment, {*value, kind})) return false;
  }
  return true;
}

/// The next sign, which the times are asked for; none: it is still to be chosen, or no times have it.
std::optional<int> Moments::sign(Step& step, const TimedNumber& value) const {
  if (value.is_constant()) return value.constant > 0 ? 1 : value.constant < 0 ? -1 : 0;
  if (step.used == step.signs.size()) {
    step.open = true;
    return std::nullopt;
  }
  const int chosen = step.signs[step.used++];
  const auto kind = chosen == 0 ? GroundComparison::Kind::kZero : GroundComparison::Kind::kPositive;
  if (!demand(step.moment, {chosen < 0 ? scaled(value, -1) : value, kind})) return std::nullopt;
  return chosen;
}

std::optional<bool> Moments::holds(Step& step, const GroundCondition& condition, const TimedNumber& duration) const {
  for (const int f : condition.facts)
    if (!is_set(step.moment.state.data(), f)) return false;
  for (const int c : condition.comparisons) {
    const std::optional<TimedNumber> value = gap(step.moment, c, duration);
    if (!value) {
      leave_out();
      return std::nullopt;
    }
    if (value->is_constant() && std::isnan(value->constant)) return false;
    const std::optional<int> chosen = sign(step, *value);
    if (!chosen) return std::nullopt;
    if (!task_.comparisons[c].accepts(*chosen)) return false;
  }
  return true;
}

bool Moments::derive(Step& step) const {
  if (!axioms_read_numbers_ || step.moment.varying.empty()) {
    simulator_.derive(step.moment.state.data());
    return true;
  }
  bool right = true;
  simulator_.derive(step.moment.state.data(), [&](const GroundCondition& body) {
    const std::optional<bool> is_true = right ? holds(step, body, {}) : std::nullopt;
    right = right && is_true.has_value();
    return is_true.value_or(false);
  });
  return right;
}

// ---- one step ------------------------------------------------------------------------------------------------------

bool Moments::conflict(const Moment::Recent& one, const Moment::Recent& other) const {
  const auto each = [this](const Moment::Recent& of, const auto& visit) {
    if (visit(touches_.of_happening(of.action))) return true;
    return std::ranges::any_of(of.fired, [&](int i) { return visit(touches_.of_conditional(of.action, i)); });
  };
  return each(one, [&](std::span<const Touch> mine) {
    return each(other, [&](std::span<const Touch> theirs) {
      return Touches::conflict_at_instant(mine, one.at_end, theirs, other.at_end);
    });
  });
}

bool Moments::keep_clear(Moment& moment, const Moment::Recent& happening) const {
  return std::ranges::all_of(moment.recent, [&](const Moment::Recent& recent) {
    return !conflict(happening, recent) ||
           (recent.point != happening.point && moment.zone.require(recent.point, happening.point, options_.separation));
  });
}

/// By number: whether it may change while time passes.
ById<char> Moments::changing_numbers(const Moment& moment) const {
  ById<char> changes(task_.numbers.size(), 0);
  for (const Moment::Running& running : moment.running)
    for (const ContinuousEffect& effect : task_.actions[running.action].continuous) changes[effect.number] = 1;
  return changes;
}

/// Whether a condition over all of a copy that is not followed holds now, or may: numbers that depend on times can do.
bool Moments::may_hold(const Moment& moment, const GroundCondition& over_all, const ById<char>& changes) const {
  for (const int f : over_all.facts)
    if (!is_set(moment.state.data(), f)) return false;
  for (const int c : over_all.comparisons) {
    const GroundExpression& expression = task_.comparisons[c].expression;
    bool moves = expression.mentions_duration();
    expression.for_each_number([&](int n) { moves = moves || changes[n] != 0; });
    if (moves) continue;
    const std::optional<TimedNumber> value = gap(moment, c, {});
    if (value && value->is_constant() && !accepts(c, value->constant)) return false;
  }
  return true;
}

/// Time passes: copies that are not followed run only where their conditions over all hold.
void Moments::let_beyond_pass(Moment& moment, const ById<char>& changes) const {
  moment.beyond.insert(moment.beyond.end(), moment.joining.begin(), moment.joining.end());
  moment.joining.clear();
  sort_unique(moment.beyond);
  std::erase_if(moment.beyond, [&](int action) { return !may_hold(moment, task_.actions[action].over_all, changes); });
}

/// Lets time pass until `point`; nothing happens in between. `ending`: the place of the step that ends then, or -1.
bool Moments::pass_to(Step& step, int point, int ending) const {
  Moment& moment = step.moment;
  if (!moment.zone.require(moment.now, point, 0)) return false;
  if (moment.next_event < static_cast<int>(task_.events.size()) &&  // which does not wait
      !moment.zone.require(point, moment.origin, -task_.events[moment.next_event].time))
    return false;
  for (std::size_t r = 0; r < moment.running.size(); ++r)
    if (static_cast<int>(r) != ending && !moment.zone.require(point, moment.running[r].end, 0)) return false;
  if (!moment.beyond.empty() || !moment.joining.empty()) let_beyond_pass(moment, changing_numbers(moment));
  std::vector<std::pair<int, TimedNumber>> rates;
  for (const Moment::Running& running : moment.running)
    for (const ContinuousEffect& effect : task_.actions[running.action].continuous) {
      const std::optional<TimedNumber> rate = evaluate(moment, effect.rate, duration(moment, running));
      if (!rate || !rate->is_constant()) return leave_out();
      if (std::isnan(rate->constant)) return false;
      if (rate->constant != 0) rates.emplace_back(effect.number, distance(moment.now, point, rate->constant));
    }
  struct Held {
    const GroundCondition* condition;
    std::size_t running;
    std::vector<TimedNumber> before;
  };
  std::vector<Held> held;  // what counts while time passes
  const auto note = [&](const GroundCondition& condition, std::size_t running) {
    held.push_back({&condition, running, {}});
    for (const int c : condition.comparisons) {
      std::optional<TimedNumber> value = gap(moment, c, duration(moment, moment.running[running]));
      if (!value) return leave_out();
      held.back().before.push_back(*std::move(value));
    }
    return true;
  };
  for (std::size_t r = 0; r < moment.running.size(); ++r)
    if (!note(task_.actions[moment.running[r].action].over_all, r)) return false;
  std::vector<TimedNumber> of_axioms;
  if (axioms_read_numbers_ && !rates.empty())
    for (const Axiom& axiom : task_.axioms)
      for (const int c : axiom.body.comparisons) {
        const std::optional<TimedNumber> value = gap(moment, c, {});
        if (!value) return leave_out();
        of_axioms.push_back(*value);
      }
  for (Moment::Running& running : moment.running)  // effects whose condition over all is broken do not come about
    for (std::size_t i = 0; i < running.remembered.size(); ++i) {
      const GroundCondition& over_all = task_.actions[running.action].conditional[i].over_all;
      if (!running.remembered[i] || over_all.empty()) continue;
      const std::optional<bool> now = holds(step, over_all, duration(moment, running));
      if (!now) return false;
      running.remembered[i] = *now;
    }
  for (const auto& [number, change] : rates) set_number(moment, number, plus(this->number(moment, number), change, 1));
  if (!of_axioms.empty()) {
    std::size_t next = 0;
    for (const Axiom& axiom : task_.axioms)
      for (const int c : axiom.body.comparisons) {
        const std::optional<TimedNumber> after = gap(moment, c, {});
        if (!after) return leave_out();
        const TimedNumber& before = of_axioms[next++];
        if (before == *after) continue;
        const std::optional<int> first = sign(step, before), second = first ? sign(step, *after) : first;
        if (!second) return false;
        if (*first != *second) return leave_out();  // a derived fact may change while nothing happens
      }
    if (!derive(step)) return false;
  }
  for (const Held& each : held) {
    const TimedNumber lasts = duration(moment, moment.running[each.running]);
    for (std::size_t i = 0; i < each.condition->comparisons.size(); ++i) {
      const int c = each.condition->comparisons[i];
      const std::optional<TimedNumber> after = gap(moment, c, lasts);
      if (!after) return leave_out();
      const TimedNumber& before = each.before[i];
      if (before.is_constant() && after->is_constant()) {
        if (!accepts(c, before.constant) || !accepts(c, after->constant)) return false;
        continue;
      }
      // Linear in between, so that both ends decide; a value above 0 may begin or end at 0.
      const auto at_ends = task_.comparisons[c].kind == GroundComparison::Kind::kZero
                               ? GroundComparison::Kind::kZero
                               : GroundComparison::Kind::kNotNegative;
      if (!demand(moment, {before, at_ends}) || !demand(moment, {*after, at_ends})) return false;
      if (task_.comparisons[c].kind == GroundComparison::Kind::kPositive &&
          !demand(moment, {plus(before, *after, 1), GroundComparison::Kind::kPositive}))
        return false;
    }
    for (const int f : each.condition->facts)
      if (!is_set(moment.state.data(), f)) return false;
  }
  for (Moment::Running& running : moment.running)
    for (std::size_t i = 0; i < running.remembered.size(); ++i) {
      const GroundCondition& over_all = task_.actions[running.action].conditional[i].over_all;
      if (!running.remembered[i] || over_all.comparisons.empty()) continue;
      const std::optional<bool> still = holds(step, over_all, duration(moment, running));
      if (!still) return false;
      running.remembered[i] = *still;
    }
  moment.now = point;
  return true;
}

/// What the durations of an action allow, as far as it is known at its start or at its end.
bool Moments::limit_duration(Moment& moment, const Moment::Running& running, bool at_end) const {
  for (const GroundDuration& limit : task_.actions[running.action].duration) {
    if (limit.at_end != at_end) continue;
    const std::optional<TimedNumber> bound = evaluate(moment, limit.bound, {});
    if (!bound) return leave_out();
    if (std::isnan(bound->constant)) return false;
    if (limit.comparison == Comparison::kLessEqual && bound->constant >= kLongest) continue;  // none
    if (limit.comparison == Comparison::kGreaterEqual && bound->constant <= -kLongest) continue;
    if (!(std::abs(bound->constant) < kLongest)) return false;
    const TimedNumber length = distance(running.start, running.end);
    const TimedNumber over = plus(length, *bound, -1);
    const auto not_negative = GroundComparison::Kind::kNotNegative;
    const bool exact = limit.comparison == Comparison::kEqual;
    if (limit.comparison != Comparison::kLessEqual && limit.comparison != Comparison::kGreaterEqual && !exact)
      return false;
    if (exact && bound->is_constant() && !options_.relaxed) {
      const Micros micros = in_micros(bound->constant);
      if (!moment.zone.require(running.start, running.end, micros) ||
          !moment.zone.require(running.end, running.start, -micros))
        return false;
    } else if (exact ? !demand(moment, {over, GroundComparison::Kind::kZero})
                     : !demand(moment,
                               {limit.comparison == Comparison::kLessEqual ? scaled(over, -1) : over, not_negative})) {
      return false;
    }
  }
  return true;
}

bool Moments::apply(Step& step, const GroundEffects& effects, const TimedNumber& duration) const {
  Moment& moment = step.moment;
  std::vector<TimedNumber> values;  // all are read before one is changed
  for (const NumericEffect& effect : effects.numbers) {
    const std::optional<TimedNumber> value = evaluate(moment, effect.value, duration);
    if (!value) return leave_out();
    if (std::isnan(value->constant)) return false;
    values.push_back(*value);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const NumericEffect& effect = effects.numbers[i];
    TimedNumber value = number(moment, effect.number);
    if (effect.kind == NumericEffect::Kind::kAssign) {
      value = values[i];
    } else if (effect.kind == NumericEffect::Kind::kIncrease) {
      value = plus(value, values[i], 1);
    } else if (value.is_constant() || values[i].is_constant()) {
      value = value.is_constant() ? scaled(values[i], value.constant) : scaled(value, values[i].constant);
    } else {
      return leave_out();
    }
    if (!std::isfinite(value.constant)) return false;
    set_number(moment, effect.number, std::move(value));
  }
  for (const int f : effects.remove) reset(moment.state.data(), f);
  for (const int f : effects.add) set(moment.state.data(), f);
  return true;
}

namespace {

void append(const GroundEffects& more, GroundEffects& to) {
  to.add.insert(to.add.end(), more.add.begin(), more.add.end());
  to.remove.insert(to.remove.end(), more.remove.begin(), more.remove.end());
  to.numbers.insert(to.numbers.end(), more.numbers.begin(), more.numbers.end());
}

/// Among several alike only the last one counts: a distance from it is also a distance from those before.
void note(Moment& moment, Moment::Recent happening) {
  std::erase_if(moment.recent, [&](const Moment::Recent& recent) {
    return recent.action == happening.action && recent.at_end == happening.at_end && recent.fired == happening.fired;
  });
  moment.recent.push_back(std::move(happening));
}

}  // namespace

bool Moments::start(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  const GroundAction& action = task_.actions[happening.index];
  if (happening.beyond && (!action.continuous.empty() || reads_duration_[happening.index])) return leave_out();
  Moment::Running running{happening.index, moment.now, moment.now, {}};
  if (!happening.at_once) {
    running.start = moment.zone.add_point();
    if (!pass_to(step, running.start, -1)) return false;
  }
  Moment::Recent recent{happening.index, false, running.start, {}};
  if (!keep_clear(moment, recent)) return false;
  const bool lasts = action.durative && !happening.beyond;
  if (lasts) {
    running.end = moment.zone.add_point();
    if (!moment.zone.require(running.start, running.end, 0) || !limit_duration(moment, running, false)) return false;
  }
  const TimedNumber length = lasts ? duration(moment, running) : TimedNumber{};
  if (!demand(moment, action.start, length)) return false;
  GroundEffects all = action.at_start;
  for (const ConditionalEffects& conditional : action.conditional) {
    const std::optional<bool> fires = holds(step, conditional.start, length);
    if (!fires) return false;
    if (*fires && !conditional.at_start.empty()) recent.fired.push_back(static_cast<int>(running.remembered.size()));
    running.remembered.push_back(*fires);
    if (*fires) append(conditional.at_start, all);
  }
  if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
  if (options_.keep_everything) {
    DurationRange range{0, 0};
    if (lasts) range = {moment.zone.least(running.start, running.end), moment.zone.most(running.start, running.end)};
    moment.steps.push_back({happening.index, running.start, lasts ? running.end : running.start, range});
  }
  if (!apply(step, all, length)) return false;
  note(moment, std::move(recent));
  if (happening.beyond) {
    std::vector<int>& into = constant_durations(action).least > 0 ? moment.joining : moment.beyond;
    if (!contains(into, happening.index)) into.insert(std::ranges::lower_bound(into, happening.index), happening.index);
    return true;
  }
  if (lasts)
    moment.running.insert(std::ranges::upper_bound(moment.running, running.action, {}, &Moment::Running::action),
                          std::move(running));
  return true;
}

bool Moments::end(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  if (happening.beyond) {
    const GroundAction& action = task_.actions[happening.index];
    if (!happening.at_once && !pass_to(step, moment.zone.add_point(), -1)) return false;
    if (!contains(moment.beyond, happening.index)) return false;  // none of them ran until now
    Moment::Recent recent{happening.index, true, moment.now, {}};
    if (!keep_clear(moment, recent) || !demand(moment, action.end, {})) return false;
    GroundEffects all = action.at_end;
    for (std::size_t i = 0; i < action.conditional.size(); ++i) {
      const ConditionalEffects& conditional = action.conditional[i];
      if (conditional.at_end.empty()) continue;
      if (!conditional.start.empty() || !conditional.over_all.empty()) return leave_out();
      const std::optional<bool> fires = holds(step, conditional.end, {});
      if (!fires) return false;
      if (!*fires) continue;
      recent.fired.push_back(static_cast<int>(i));
      append(conditional.at_end, all);
    }
    if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
    note(moment, std::move(recent));
    return apply(step, all, {});
  }
  const int point = moment.running[static_cast<std::size_t>(happening.index)].end;
  if (happening.at_once ? !moment.zone.require(point, moment.now, 0) : !pass_to(step, point, happening.index))
    return false;
  const Moment::Running running = moment.running[static_cast<std::size_t>(happening.index)];
  moment.running.erase(moment.running.begin() + happening.index);
  Moment::Recent recent{running.action, true, moment.now, {}};
  if (!keep_clear(moment, recent) || !limit_duration(moment, running, true)) return false;
  const GroundAction& action = task_.actions[running.action];
  const TimedNumber length = duration(moment, running);
  if (!demand(moment, action.end, length)) return false;
  GroundEffects all = action.at_end;
  for (std::size_t i = 0; i < action.conditional.size(); ++i) {
    if (!running.remembered[i] || action.conditional[i].at_end.empty()) continue;
    const std::optional<bool> fires = holds(step, action.conditional[i].end, length);
    if (!fires) return false;
    if (!*fires) continue;
    recent.fired.push_back(static_cast<int>(i));
    append(action.conditional[i].at_end, all);
  }
  if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
  note(moment, std::move(recent));
  return apply(step, all, length);
}

bool Moments::event(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  const int point = happening.at_once ? moment.now : moment.zone.add_point();
  const TimedEvent& event = task_.events[happening.index];
  if (!moment.zone.require(moment.origin, point, event.time) || !moment.zone.require(point, moment.origin, -event.time))
    return false;
  if (!happening.at_once && !pass_to(step, point, -1)) return false;
  Moment::Recent recent{-2 - happening.index, false, point, {}};
  if (!keep_clear(moment, recent)) return false;
  note(moment, std::move(recent));
  ++moment.next_event;
  return apply(step, event.effects, {});
}

int Moments::rank(const Happening& happening, const Moment& moment) const {
  if (happening.kind == Happening::Kind::kEvent) return 0;
  if (happening.kind == Happening::Kind::kStart) return 1 + happening.index;
  const int action =
      happening.beyond ? happening.index : moment.running[static_cast<std::size_t>(happening.index)].action;
  return 1 + static_cast<int>(task_.actions.size()) + action;
}

bool Moments::step(Moment& moment, const Happening& happening, const Signs& signs, bool& open) const {
  budget_.spend(Work::kNode, kStepWork);
  budget_.spend(Work::kTimes, kLooksOfPair * moment.zone.points() * moment.zone.points());
  moment.last = rank(happening, moment);
  Step step{moment, signs, 0, false};
  bool taken = happening.kind == Happening::Kind::kStart ? start(step, happening)
               : happening.kind == Happening::Kind::kEnd ? end(step, happening)
                                                         : event(step, happening);
  taken = taken && derive(step);
  open = step.open;
  if (!taken || step.used < signs.size() || !tidy(moment)) return false;
  judge(moment);
  return true;
}

/// Whether time may pass after what has happened so far, or more must happen at this instant.
void Moments::judge(Moment& moment) const {
  moment.may_pass = true;
  moment.may_join = false;
  const ById<char> changes = changing_numbers(moment);
  for (std::size_t n = 0; n < changes.size(); ++n)
    if (changes[n] && std::isnan(number(moment, static_cast<int>(n)).constant)) moment.may_pass = false;
  for (const Moment::Running& running : moment.running) {
    const GroundCondition& over_all = task_.actions[running.action].over_all;
    for (const int f : over_all.facts)
      if (!is_set(moment.state.data(), f)) moment.may_pass = false;
    for (const int c : over_all.comparisons) {
      const std::optional<TimedNumber> value = gap(moment, c, duration(moment, running));
      bool moves = !value || !value->is_constant();
      task_.comparisons[c].expression.for_each_number([&](int n) { moves = moves || changes[n] != 0; });
      if (moves)
        moment.may_join = true;
      else if (!accepts(c, value->constant))
        moment.may_pass = false;
    }
  }
  // Copies that are not followed may end at the instant at which their conditions over all stop to hold, or begin at
  // the one at which these begin to hold.
  for (const auto* actions : {&moment.beyond, &moment.joining})
    for (const int action : *actions)
      if (!may_hold(moment, task_.actions[action].over_all, changes)) moment.may_join = true;
  if (!moment.may_pass) moment.may_join = true;
}

/// Forgets the points that nothing can depend on any more, and looks whether there are times at all.
bool Moments::tidy(Moment& moment) const {
  std::vector<TimedDemand> demands;
  for (bool changed = true; changed;) {
    demands = std::move(moment.demands);
    moment.demands.clear();
    for (TimedDemand& each : demands)
      if (!demand(moment, each)) return false;
    changed = moment.demands.size() < demands.size();
  }
  for (std::size_t i = moment.varying.size(); i-- > 0;) {
    auto [number, value] = moment.varying[i];
    simplify(moment.zone, value);
    set_number(moment, number, std::move(value));
  }
  if (!moment.demands.empty() && !solve(moment, -1)) return false;
  std::erase_if(moment.recent, [&](const Moment::Recent& recent) {
    return moment.zone.least(recent.point, moment.now) >= options_.separation;
  });
  if (options_.keep_everything) return true;
  std::vector<int> kept;
  ById<int> place(static_cast<std::size_t>(moment.zone.points()), -1);
  const auto keep = [&](int& point) {
    if (point < 0) return;
    if (place[point] < 0) {
      place[point] = static_cast<int>(kept.size());
      kept.push_back(point);
    }
    point = place[point];
  };
  const bool from_start = options_.keep_origin || moment.next_event < static_cast<int>(task_.events.size()) ||
                          !moment.varying.empty() || !moment.demands.empty();
  if (!from_start) moment.origin = -1;
  keep(moment.origin);
  keep(moment.now);
  for (Moment::Running& running : moment.running) {
    keep(running.end);
    if (!reads_duration_[running.action]) running.start = -1;
    keep(running.start);
  }
  std::ranges::sort(moment.recent, {},
                    [](const Moment::Recent& recent) { return std::tie(recent.action, recent.at_end, recent.fired); });
  for (Moment::Recent& recent : moment.recent) keep(recent.point);
  const auto keep_all = [&](TimedNumber& value) {
    for (auto& entry : value.weights) keep(entry.first);
    std::ranges::sort(value.weights);
  };
  for (auto& entry : moment.varying) keep_all(entry.second);
  for (TimedDemand& each : moment.demands) keep_all(each.value);
  moment.zone.keep(kept);
  return true;
}

/// Times after the origin in seconds, that of point `least` as early as it can be; none if there are none.
std::optional<ById<double>> Moments::solve(const Moment& moment, int least) const {
  const int points = moment.zone.points();
  std::vector<LinearRow> rows;
  const auto row = [&] { return LinearRow{std::vector<double>(static_cast<std::size_t>(points), 0), 0}; };
  for (int from = 0; from < points; ++from)
    for (int to = 0; to < points; ++to) {
      if (from == to || moment.zone.most(from, to) >= Zone::kAny) continue;
      LinearRow made = row();
      if (from != moment.origin) made.coefficients[static_cast<std::size_t>(from)] = -1;
      if (to != moment.origin) made.coefficients[static_cast<std::size_t>(to)] = 1;
      made.bound = in_seconds(moment.zone.most(from, to));
      rows.push_back(std::move(made));
    }
  for (const TimedDemand& demand : moment.demands) {
    LinearRow made = row();
    for (const auto& [point, weight] : demand.value.weights)
      if (point != moment.origin) made.coefficients[static_cast<std::size_t>(point)] = -weight;
    made.bound = demand.value.constant;
    if (demand.kind == GroundComparison::Kind::kPositive && !options_.relaxed) made.bound -= kPositive;
    rows.push_back(made);
    if (demand.kind != GroundComparison::Kind::kZero) continue;
    for (double& each : made.coefficients) each = -each;
    made.bound = -made.bound;
    rows.push_back(std::move(made));
  }
  std::vector<double> objective(static_cast<std::size_t>(points), 0);
  if (least >= 0 && least != moment.origin) objective[static_cast<std::size_t>(least)] = 1;
  std::int64_t work = 0;
  std::optional<std::vector<double>> found = minimize(rows, objective, &work);
  budget_.spend(Work::kTimes, work);
  return found ? std::optional(ById<double>(*std::move(found))) : std::nullopt;
}

bool Moments::fix(Moment& moment, int point, Micros time) const {
  if (!moment.zone.require(moment.origin, point, time) || !moment.zone.require(point, moment.origin, -time))
    return false;
  const std::vector<TimedDemand> demands = std::move(moment.demands);
  moment.demands.clear();
  for (const TimedDemand& each : demands)
    if (!demand(moment, each)) return false;
  return moment.demands.empty() || solve(moment, -1);
}

std::optional<ById<Micros>> Moments::times(const Moment& moment, int last) const {
  Moment fixed = moment;
  std::vector<int> order = {last};
  for (int point = 0; point < moment.zone.points(); ++point) order.push_back(point);
  for (const int point : order) {
    if (fixed.demands.empty()) break;
    const std::optional<ById<double>> found = solve(fixed, point);
    if (!found) return std::nullopt;
    const double exact = (*found)[point] * kMicro;
    bool placed = false;
    for (const double time : {std::ceil(exact - 1e-3), std::round(exact), std::floor(exact), std::ceil(exact) + 1}) {
      Moment next = fixed;
      if (placed || !fix(next, point, static_cast<Micros>(time))) continue;
      fixed = std::move(next);
      placed = true;
    }
    if (!placed) return std::nullopt;
  }
  ById<Micros> earliest;
  for (int point = 0; point < fixed.zone.points(); ++point) earliest.push_back(fixed.zone.least(fixed.origin, point));
  return earliest;
}

// ---- what may come next --------------------------------------------------------------------------------------------

/// Whether starting an action is needless: all lasting changes that it makes are made already or come from a running
/// action.
bool Moments::is_needless(const Moment& moment, int action) const {
  if (!repeats_nothing_[action]) return false;
  const GroundAction& each = task_.actions[action];
  const auto is_true = [&](int f) { return is_set(moment.state.data(), f); };
  if (!std::ranges::all_of(each.at_start.add, is_true)) return false;
  if (std::ranges::all_of(each.at_end.add, is_true)) return true;
  // Two copies of one fixed duration end in the order in which they began.
  const DurationRange range = constant_durations(each);
  return range.least == range.most &&
         std::ranges::find(moment.running, action, &Moment::Running::action) != moment.running.end();
}

std::vector<Happening> Moments::happenings(const Moment& moment) const {
  budget_.spend(Work::kTimes, kLooksOfCandidate * static_cast<std::int64_t>(candidates_.size()));
  std::vector<Happening> found;
  for (const bool at_once : {false, true}) {
    if (at_once ? !moment.may_join : !moment.may_pass) continue;
    const auto offer = [&](Happening happening) {
      happening.at_once = at_once;
      if (!at_once || rank(happening, moment) >= moment.last) found.push_back(happening);
    };
    for (std::size_t r = 0; r < moment.running.size(); ++r) offer({Happening::Kind::kEnd, static_cast<int>(r)});
    for (const int action : moment.beyond) offer({Happening::Kind::kEnd, action, false, true});
    if (moment.next_event < static_cast<int>(task_.events.size())) offer({Happening::Kind::kEvent, moment.next_event});
    for (const int action : candidates_) {
      const auto is_true = [&](int f) { return is_set(moment.state.data(), f); };
      if (!std::ranges::all_of(task_.actions[action].start.facts, is_true) || is_needless(moment, action)) continue;
      const auto copies = std::ranges::count(moment.running, action, &Moment::Running::action);
      if (copies >= most_at_once_[action]) continue;
      const bool few = most_at_once_[action] < std::numeric_limits<int>::max();
      if (copies < options_.copies || (options_.relaxed && few))
        offer({Happening::Kind::kStart, action});
      else if (options_.relaxed)
        offer({Happening::Kind::kStart, action, false, true});
      else
        capped_ = true;
    }
  }
  return found;
}

std::optional<Moment> Moments::at_goal(const Moment& moment) const {
  if (!moment.running.empty()) return std::nullopt;
  if (moment.next_event == static_cast<int>(task_.events.size())) {
    std::optional<Moment> last = moment;
    if (!demand(*last, task_.goal, {}) || (!last->demands.empty() && !solve(*last, -1))) last.reset();
    return last;
  }
  std::optional<Moment> reached;
  each_after(moment, {Happening::Kind::kEvent, moment.next_event}, [&](const Moment& after, const Signs&) {
    if (!reached) reached = at_goal(after);
  });
  return reached;
}

}  // namespace cxlab::planner
