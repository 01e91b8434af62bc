#include "planner/validator/crossing.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cxlab::planner {
namespace {

/// A quotient of polynomials.
struct Ratio {
  Polynomial above = {0};
  Polynomial below = {1};
};

Polynomial sum(const Polynomial& a, const Polynomial& b, double sign) {
  Polynomial result(std::max(a.size(), b.size()), 0);
  for (std::size_t i = 0; i < a.size(); ++i) result[i] += a[i];
  for (std::size_t i = 0; i < b.size(); ++i) result[i] += sign * b[i];
  return result;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result(a.size() + b.size() - 1, 0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < b.size(); ++k) result[i + k] += a[i] * b[k];
  return result;
}

Ratio sum(const Ratio& a, const Ratio& b, double sign) {
  return {sum(product(a.above, b.below), product(b.above, a.below), sign), product(a.below, b.below)};
}

double at(const Polynomial& polynomial, double t) {
  double value = 0;
  for (std::size_t i = polynomial.size(); i-- > 0;) value = value * t + polynomial[i];
  return value;
}

/// 1, -1, or 0 where the value is not above the rounding errors of its terms.
int sign_at(const Polynomial& polynomial, double t) {
  constexpr double kRounding = 0x1p-46;
  double largest = 0;
  for (std::size_t i = polynomial.size(); i-- > 0;) largest = largest * t + std::abs(polynomial[i]);
  const double value = at(polynomial, t);
  if (std::abs(value) <= kRounding * largest) return 0;
  return value > 0 ? 1 : -1;
}

class Follower {
 public:
  Follower(const Evaluator& evaluator, const State& state, double duration, double length)
      : evaluator_(evaluator), state_(state), duration_(duration), length_(length) {}

  std::optional<double> first_break(const Condition& condition, Frame& frame) {
    if (state_.has_rates()) {
      find_crossings(condition, frame);
      for_each_part(condition, [this](const Condition& part, bool) {
        follows_rules_ |= part.kind == Condition::Kind::kAtom && evaluator_.domain().predicates[part.predicate].derived;
      });
      if (follows_rules_) find_crossings_of_rules();
    }
    std::ranges::sort(crossings_);
    double before = 0;
    for (const double crossing : crossings_) {
      for (const double ahead : {(before + crossing) / 2, crossing})
        if (!holds(condition, frame, ahead)) return ahead;
      before = crossing;
    }
    const double last = (before + length_) / 2;
    return holds(condition, frame, last) ? std::nullopt : std::optional(last);
  }

 private:
  void find_crossings(const Condition& condition, Frame& frame) {
    if (condition.kind == Condition::Kind::kCompare) {
      if (const auto gap = this->gap(condition, frame))
        for (const Polynomial* part : {&gap->above, &gap->below})
          std::ranges::copy(roots(*part, length_), std::back_inserter(crossings_));
      return;
    }
    for (const Condition& operand : condition.operands)
      evaluator_.each_binding(condition.variables, frame, [&] {
        find_crossings(operand, frame);
        return true;
      });
  }

  void find_crossings_of_rules() {
    for (const Derivation& rule : evaluator_.domain().derivations) {
      Frame frame(static_cast<std::size_t>(rule.slots), 0);
      evaluator_.each_binding(rule.parameters, frame, [&] {
        find_crossings(rule.condition, frame);
        return true;
      });
    }
  }

  bool holds(const Condition& condition, Frame& frame, double ahead) const {
    if (!follows_rules_) return holds_in(state_, condition, frame, ahead);
    State then = state_;
    then.advance(ahead);
    evaluator_.derive(then);
    return holds_in(then, condition, frame, ahead);
  }

  /// `facts`: whose facts count; the numbers are those of now, `ahead` later.
  bool holds_in(const State& facts, const Condition& condition, Frame& frame, double ahead) const {
    return evaluator_.judge(condition, frame, facts, [&](const Condition& comparison, const Frame& bound) {
      const auto left = evaluator_.number(comparison.sides[0], bound, state_, duration_);
      const auto right = evaluator_.number(comparison.sides[1], bound, state_, duration_);
      const auto gap = this->gap(comparison, bound);
      if (gap && gap->above.size() == 1 && gap->below.size() == 1)  // nothing in it changes
        return left && right && compare(*left, comparison.comparison, *right);
      if (!gap) return false;
      const int below = sign_at(gap->below, ahead);
      return below != 0 && compare(sign_at(gap->above, ahead) * below, comparison.comparison, 0);
    });
  }

  /// The left side less the right one; none if a value is undefined.
  std::optional<Ratio> gap(const Condition& comparison, const Frame& frame) const {
    const auto left = ratio(comparison.sides[0], frame), right = ratio(comparison.sides[1], frame);
    if (!left || !right) return std::nullopt;
    return sum(*left, *right, -1);
  }

  /// None if a value is undefined.
  std::optional<Ratio> ratio(const Expression& expression, const Frame& frame) const {
    using Kind = Expression::Kind;
    if (expression.kind == Kind::kConstant) return Ratio{{expression.value}};
    if (expression.kind == Kind::kDuration || expression.kind == Kind::kTotalTime) return Ratio{{duration_}};
    if (expression.kind == Kind::kFunction) {
      const Objects objects(expression.terms, frame);
      const auto value = state_.value(expression.function, objects);
      const double rate = state_.rate(expression.function, objects);
      if (!value) return std::nullopt;
      return rate == 0 ? Ratio{{*value}} : Ratio{{*value, rate}};
    }
    std::optional<Ratio> out = ratio(expression.operands[0], frame);
    if (out && expression.kind == Kind::kNegate)
      for (double& coefficient : out->above) coefficient = -coefficient;
    for (std::size_t i = 1; out && i < expression.operands.size(); ++i) {
      const auto next = ratio(expression.operands[i], frame);
      if (!next) return std::nullopt;
      const auto& [above, below] = *next;
      if (expression.kind == Kind::kAdd) out = sum(*out, *next, 1);
      if (expression.kind == Kind::kSubtract) out = sum(*out, *next, -1);
      if (expression.kind == Kind::kMultiply) out = Ratio{product(out->above, above), product(out->below, below)};
      if (expression.kind == Kind::kDivide) out = Ratio{product(out->above, below), product(out->below, above)};
    }
    return out;
  }

  const Evaluator& evaluator_;
  const State& state_;
  double duration_;
  double length_;
  bool follows_rules_ = false;  ///< the condition reads derived facts
  std::vector<double> crossings_;
};

}  // namespace

std::vector<double> roots(Polynomial polynomial, double length) {
  while (!polynomial.empty() && polynomial.back() == 0) polynomial.pop_back();
  std::vector<double> found;
  const auto keep = [&](double root) {
    if (root > 0 && root < length) found.push_back(root);
  };
  if (polynomial.size() == 2) {
    keep(-polynomial[0] / polynomial[1]);
  } else if (polynomial.size() == 3) {
    const double a = polynomial[2], b = polynomial[1], c = polynomial[0];
    double discriminant = b * b - 4 * a * c;
    if (std::abs(discriminant) <= 1e-12 * std::max(b * b, std::abs(4 * a * c))) discriminant = 0;  // it touches 0
    if (discriminant >= 0) {
      const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
      keep(q / a);
      if (q != 0 && discriminant > 0) keep(c / q);
    }
  } else if (polynomial.size() > 3) {
    Polynomial slope(polynomial.size() - 1);
    for (std::size_t i = 1; i < polynomial.size(); ++i) slope[i - 1] = polynomial[i] * static_cast<double>(i);
    std::vector<double> bounds = roots(slope, length);  // between them it rises or falls
    for (const double bound : bounds)
      if (std::abs(at(polynomial, bound)) <= 1e-12) found.push_back(bound);
    bounds.insert(bounds.begin(), 0);
    bounds.push_back(length);
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
      double low = bounds[i], high = bounds[i + 1];
      const bool rises = at(polynomial, low) < 0;
      if (rises == (at(polynomial, high) < 0)) continue;
      for (int step = 0; step < 100 && low < high; ++step) {
        const double middle = (low + high) / 2;
        ((at(polynomial, middle) < 0) == rises ? low : high) = middle;
      }
      keep(low);
    }
  }
  std::ranges::sort(found);
  return found;
}

std::optional<double> first_break(const Evaluator& evaluator, const Condition& condition, Frame& frame,
                                  const State& state, double duration, double length) {
  return Follower(evaluator, state, duration, length).first_break(condition, frame);
}

}  // namespace cxlab::planner
