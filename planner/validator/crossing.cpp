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

class Sampler {
 public:
  Sampler(const Evaluator& evaluator, const State& state, double duration, double length)
      : evaluator_(evaluator), state_(state), duration_(duration), length_(length) {}

  void visit(const Condition& condition, Frame& frame) {
    if (condition.kind == Condition::Kind::kCompare) {
      const auto left = ratio(condition.sides[0], frame), right = ratio(condition.sides[1], frame);
      if (!left || !right) return;
      const Ratio gap = sum(*left, *right, -1);
      for (const Polynomial* part : {&gap.above, &gap.below})
        std::ranges::copy(roots(*part, length_), std::back_inserter(crossings_));
      return;
    }
    for (const Condition& operand : condition.operands)
      evaluator_.each_binding(condition.variables, frame, [&] {
        visit(operand, frame);
        return true;
      });
  }

  std::vector<double> points() {
    std::ranges::sort(crossings_);
    std::vector<double> points;
    double before = 0;
    for (const double crossing : crossings_) {
      points.insert(points.end(), {(before + crossing) / 2, crossing});
      before = crossing;
    }
    points.push_back((before + length_) / 2);
    return points;
  }

 private:
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

std::vector<double> sample_points(const Evaluator& evaluator, const Condition& condition, Frame& frame,
                                  const State& state, double duration, double length) {
  Sampler sampler(evaluator, state, duration, length);
  if (state.has_rates()) sampler.visit(condition, frame);
  return sampler.points();
}

}  // namespace cxlab::planner
