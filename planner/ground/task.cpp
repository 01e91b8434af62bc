#include "planner/ground/task.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <span>

#include "planner/ground/sorted.h"
#include "planner/pddl/syntax.h"
#include "planner/state/number.h"

namespace cxlab::planner {

namespace {

constexpr std::size_t kDeepest = kDeepestNesting + 56;  ///< operands that wait in one expression

LinearForm times(LinearForm form, double factor) {
  for (auto& [number, weight] : form.weights) weight *= factor;
  std::erase_if(form.weights, [](const auto& entry) { return entry.second == 0; });
  form.constant *= factor;
  form.duration_weight *= factor;
  return form;
}

LinearForm plus(const LinearForm& a, const LinearForm& b) {
  LinearForm sum{a.is_linear && b.is_linear, {}, a.constant + b.constant, a.duration_weight + b.duration_weight};
  std::map<int, double> weights(a.weights.begin(), a.weights.end());
  for (const auto& [number, weight] : b.weights) weights[number] += weight;
  std::ranges::copy_if(weights, std::back_inserter(sum.weights), [](const auto& entry) { return entry.second != 0; });
  return sum;
}

bool is_number(const LinearForm& form) { return form.is_linear && form.weights.empty() && form.duration_weight == 0; }

}  // namespace

namespace {

using Stack = std::array<double, kDeepest>;

/// How many operands are left on the stack; 0 if it is too small.
std::size_t evaluate_steps(std::span<const GroundExpression::Step> steps, const double* numbers, double duration_s,
                           double total_time_s, Stack& stack) {
  using Kind = GroundExpression::Kind;
  std::size_t top = 0;
  for (const GroundExpression::Step& step : steps) {
    switch (step.kind) {
      case Kind::kConstant: stack[top++] = step.value; break;
      case Kind::kFunction: stack[top++] = numbers[step.number]; break;
      case Kind::kDuration: stack[top++] = duration_s; break;
      case Kind::kTotalTime: stack[top++] = total_time_s; break;
      case Kind::kNegate: stack[top - 1] = -stack[top - 1]; break;
      default: {
        const double right = stack[--top];
        double& left = stack[top - 1];
        if (step.kind == Kind::kAdd) left = sum(left, right);
        if (step.kind == Kind::kSubtract) left = difference(left, right);
        if (step.kind == Kind::kMultiply) left = product(left, right);
        if (step.kind == Kind::kDivide) left = quotient(left, right);
      }
    }
    if (!std::isfinite(stack[top - 1])) stack[top - 1] = std::numeric_limits<double>::quiet_NaN();
    if (top == kDeepest) return 0;
  }
  return top;
}

}  // namespace

double GroundExpression::evaluate(const double* numbers, double duration_s, double total_time_s) const {
  Stack stack;
  const bool whole = evaluate_steps(steps, numbers, duration_s, total_time_s, stack) == 1;
  return whole ? stack[0] : std::numeric_limits<double>::quiet_NaN();
}

std::pair<double, double> GroundExpression::sides(const double* numbers, double duration_s) const {
  Stack stack;
  const std::span most(steps.data(), steps.size() - 1);
  if (evaluate_steps(most, numbers, duration_s, 0, stack) == 2) return {stack[0], stack[1]};
  return {std::numeric_limits<double>::quiet_NaN(), 0};
}

GroundComparison GroundComparison::of(Kind kind, GroundExpression left, const GroundExpression& right) {
  const LinearForm one = linear_form(left), other = linear_form(right);
  const bool separate =
      (one.constant == 0 || other.constant == 0) && (one.duration_weight == 0 || other.duration_weight == 0) &&
      std::ranges::none_of(one.weights, [&](const auto& entry) {
        return std::ranges::find(other.weights, entry.first, &std::pair<int, double>::first) != other.weights.end();
      });
  left.steps.insert(left.steps.end(), right.steps.begin(), right.steps.end());
  left.steps.push_back({GroundExpression::Kind::kSubtract, -1, 0});
  LinearForm difference = linear_form_of_all(left);
  return {kind, std::move(left), std::move(difference), separate};
}

double GroundComparison::gap(const double* numbers, double duration_s) const {
  if (linear.is_linear && separate) {
    double value = linear.constant + linear.duration_weight * duration_s;
    double largest = std::max({1.0, std::abs(linear.constant), std::abs(linear.duration_weight * duration_s)});
    for (const auto& [number, weight] : linear.weights) {
      const double term = weight * numbers[number];
      value += term;
      largest = std::max(largest, std::abs(term));
    }
    // No side is larger than all terms together: what is far above all rounding errors needs no look at the sides.
    constexpr double kSure = 1e-12;
    if (std::abs(value) > kSure * largest * static_cast<double>(linear.weights.size() + 2)) return value;
  }
  const auto [left, right] = expression.sides(numbers, duration_s);
  return is_same(left, right) ? 0 : left - right;
}

void GroundExpression::append_key(std::string& key) const {
  for (const Step& step : steps) {
    key += static_cast<char>(step.kind);
    key.append(reinterpret_cast<const char*>(&step.number), sizeof step.number);
    key.append(reinterpret_cast<const char*>(&step.value), sizeof step.value);
  }
  key += '|';
}

LinearForm linear_form(const GroundExpression& expression) {
  using Kind = GroundExpression::Kind;
  std::vector<LinearForm> stack;
  const auto take = [&stack] {
    LinearForm form = std::move(stack.back());
    stack.pop_back();
    return form;
  };
  for (const GroundExpression::Step& step : expression.steps) {
    LinearForm form;
    form.is_linear = true;
    switch (step.kind) {
      case Kind::kConstant: form.constant = step.value; break;
      case Kind::kFunction: form.weights.emplace_back(step.number, 1.0); break;
      case Kind::kDuration: form.duration_weight = 1; break;
      case Kind::kTotalTime: form.is_linear = false; break;
      case Kind::kNegate: form = times(take(), -1); break;
      case Kind::kAdd:
      case Kind::kSubtract: {
        const LinearForm right = times(take(), step.kind == Kind::kAdd ? 1 : -1);
        form = plus(take(), right);
        break;
      }
      case Kind::kMultiply: {
        const LinearForm right = take(), left = take();
        if (is_number(right))
          form = times(left, right.constant);
        else if (is_number(left))
          form = times(right, left.constant);
        else
          form.is_linear = false;
        break;
      }
      case Kind::kDivide: {
        const LinearForm right = take(), left = take();
        if (is_number(right) && right.constant != 0)
          form = times(left, 1 / right.constant);
        else
          form.is_linear = false;
        break;
      }
    }
    stack.push_back(std::move(form));
  }
  return stack.size() == 1 ? stack[0] : LinearForm{};
}

LinearForm linear_form_of_all(const GroundExpression& expression) {
  LinearForm form = linear_form(expression);
  expression.for_each_number([&](int number) {
    if (std::ranges::find(form.weights, number, &std::pair<int, double>::first) == form.weights.end())
      form.is_linear = false;
  });
  return form;
}

ById<char> significant_numbers(const GroundTask& task) {
  ById<char> significant(task.numbers.size(), 0);
  const auto read = [&significant](const GroundExpression& expression) {
    expression.for_each_number([&significant](int n) { significant[n] = 1; });
  };
  const auto read_by = [&read](const GroundEffects& effects) {
    for (const NumericEffect& effect : effects.numbers) read(effect.value);
  };
  for (std::size_t n = 0; n < significant.size(); ++n)
    significant[n] = std::isnan(task.initial_numbers[n]);  // it cannot be changed before it has a value
  for (const GroundComparison& comparison : task.comparisons) read(comparison.expression);
  for (const TimedEvent& event : task.events) read_by(event.effects);
  for (const GroundAction& action : task.actions) {
    for (const GroundDuration& duration : action.duration) read(duration.bound);
    for (const ContinuousEffect& effect : action.continuous) read(effect.rate);
    for_each_effects(action, read_by);
  }
  return significant;
}

ById<std::vector<int>> bases_of_facts(const GroundTask& task) {
  ById<std::vector<int>> bases(task.facts.size());
  for (std::size_t f = 0; f < task.facts.size(); ++f)
    if (!task.facts[f].derived) bases[f] = {task.positive(static_cast<int>(f))};
  for (bool changed = !task.axioms.empty(); changed;) {
    changed = false;
    for (const Axiom& axiom : task.axioms) {
      std::vector<int> of_head = bases[axiom.head];
      for (const int f : axiom.body.facts) {
        const std::vector<int>& more = bases[task.facts[f].derived ? task.positive(f) : f];
        of_head.insert(of_head.end(), more.begin(), more.end());
      }
      for (const int c : axiom.body.comparisons)
        task.comparisons[c].expression.for_each_number(
            [&](int n) { of_head.push_back(static_cast<int>(task.facts.size()) + n); });
      sort_unique(of_head);
      if (of_head.size() != bases[axiom.head].size()) {
        bases[axiom.head] = std::move(of_head);
        changed = true;
      }
    }
  }
  for (std::size_t f = 0; f < task.facts.size(); ++f)
    if (task.facts[f].derived && task.facts[f].is_complement) bases[f] = bases[task.facts[f].complement];
  return bases;
}

DurationRange constant_durations(const GroundAction& action) {
  DurationRange range{0, action.durative ? DurationRange::kForever : 0};
  for (const GroundDuration& duration : action.duration) {
    if (!duration.bound.is_constant()) continue;
    const Micros bound = in_micros(duration.bound.steps[0].value);
    if (duration.comparison != Comparison::kLessEqual) range.least = std::max(range.least, bound);
    if (duration.comparison != Comparison::kGreaterEqual) range.most = std::min(range.most, bound);
  }
  return range;
}

}  // namespace cxlab::planner
