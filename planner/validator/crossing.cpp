#include "planner/validator/crossing.h"

#include <algorithm>
#include <cmath>

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

Ratio difference(const Ratio& a, const Ratio& b, double sign) {
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
      Ratio left, right;
      if (!ratio(condition.sides[0], frame, left) || !ratio(condition.sides[1], frame, right)) return;
      const Ratio gap = difference(left, right, -1);
      for (const Polynomial* part : {&gap.above, &gap.below})
        for (const double root : roots(*part, length_)) crossings_.push_back(root);
      return;
    }
    for (const Condition& operand : condition.operands)
      evaluator_.each_binding(condition.variables, frame, [&] {
        visit(operand, frame);
        return true;
      });
  }

  std::vector<double> points() {
    std::sort(crossings_.begin(), crossings_.end());
    std::vector<double> points;
    double before = 0;
    for (const double crossing : crossings_) {
      points.push_back((before + crossing) / 2);
      points.push_back(crossing);
      before = crossing;
    }
    points.push_back((before + length_) / 2);
    return points;
  }

 private:
  /// False if a value is undefined.
  bool ratio(const Expression& expression, const Frame& frame, Ratio& out) const {
    using Kind = Expression::Kind;
    switch (expression.kind) {
      case Kind::kConstant: out.above = {expression.value}; return true;
      case Kind::kDuration:
      case Kind::kTotalTime: out.above = {duration_}; return true;
      case Kind::kFunction: {
        const Objects objects(expression.terms, frame);
        const auto value = state_.value(expression.function, objects);
        const double rate = state_.rate(expression.function, objects);
        if (!value) return false;
        out.above = {*value};
        if (rate != 0) out.above.push_back(rate);
        return true;
      }
      default: break;
    }
    if (!ratio(expression.operands[0], frame, out)) return false;
    if (expression.kind == Kind::kNegate) {
      for (double& coefficient : out.above) coefficient = -coefficient;
      return true;
    }
    for (std::size_t i = 1; i < expression.operands.size(); ++i) {
      Ratio next;
      if (!ratio(expression.operands[i], frame, next)) return false;
      if (expression.kind == Kind::kAdd) out = difference(out, next, 1);
      if (expression.kind == Kind::kSubtract) out = difference(out, next, -1);
      if (expression.kind == Kind::kMultiply) out = {product(out.above, next.above), product(out.below, next.below)};
      if (expression.kind == Kind::kDivide) out = {product(out.above, next.below), product(out.below, next.above)};
    }
    return true;
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
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<double> sample_points(const Evaluator& evaluator, const Condition& condition, Frame& frame,
                                  const State& state, double duration, double length) {
  Sampler sampler(evaluator, state, duration, length);
  if (state.has_rates()) sampler.visit(condition, frame);
  return sampler.points();
}

}  // namespace cxlab::planner
