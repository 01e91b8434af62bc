// Numbers of a moment, and the conditions on them: what they ask of the times.

#include <algorithm>
#include <cmath>

#include "planner/happenings/moment.h"

namespace cxlab::planner {

namespace {

constexpr double kMicro = static_cast<double>(kMicrosPerSecond);
constexpr double kRounding = 1e-4;  ///< microseconds by which a computed time may miss a whole one
constexpr double kNothing = 1e-9;   ///< by which a computed value may miss it in plans, which validators judge again

}  // namespace

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
  TimedNumber value = time_between(running.start, running.end);
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
  return each.kind == GroundComparison::Kind::kZero ? std::abs(gap) <= kSlackInProofs : gap >= -kSlackInProofs;
}

/// Asks the times for it. False if no times are left.
bool Moments::demand(Moment& moment, TimedDemand demand) const {
  using Kind = GroundComparison::Kind;
  TimedNumber& value = demand.value;
  simplify(moment.zone, value);
  if (value.is_constant()) {
    const double slack = options_.relaxed ? kSlackInProofs : kNothing;
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
  if (!(std::abs(exact) < kLongestTime * kMicro)) return demand.kind != Kind::kZero && exact < 0;
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

}  // namespace cxlab::planner
