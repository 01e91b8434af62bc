#include <cmath>

#include "planner/state/number.h"
#include "planner/state/state.h"

namespace cxlab::planner {

bool compare(double left, Comparison comparison, double right) {
  const bool equal = is_same(left, right);
  switch (comparison) {
    case Comparison::kLess: return !equal && left < right;
    case Comparison::kLessEqual: return equal || left < right;
    case Comparison::kEqual: return equal;
    case Comparison::kGreaterEqual: return equal || left > right;
    case Comparison::kGreater: return !equal && left > right;
  }
  return false;
}

const std::vector<ObjectId>& Evaluator::candidates(const Variable& variable) const {
  const auto known = by_types_.find(variable.types);
  if (known != by_types_.end()) return known->second;
  return by_types_.emplace(variable.types, objects_of(domain_, problem_, variable.types)).first->second;
}

std::optional<double> Evaluator::number(const Expression& expression, const Frame& frame, const State& state,
                                        double duration) const {
  using Kind = Expression::Kind;
  switch (expression.kind) {
    case Kind::kConstant: return expression.value;
    case Kind::kFunction: {
      const auto value = state.value(expression.function, Objects(expression.terms, frame));
      return value && std::isfinite(*value) ? value : std::nullopt;
    }
    case Kind::kDuration:
    case Kind::kTotalTime: return duration;
    default: break;
  }
  const auto first = number(expression.operands[0], frame, state, duration);
  if (!first) return std::nullopt;
  if (expression.kind == Kind::kNegate) return -*first;
  double result = *first;
  for (std::size_t i = 1; i < expression.operands.size(); ++i) {
    const auto next = number(expression.operands[i], frame, state, duration);
    if (!next) return std::nullopt;
    switch (expression.kind) {
      case Kind::kAdd: result = sum(result, *next); break;
      case Kind::kSubtract: result = difference(result, *next); break;
      case Kind::kMultiply: result = product(result, *next); break;
      default: result = quotient(result, *next);
    }
    if (!std::isfinite(result)) return std::nullopt;
  }
  return result;
}

bool Evaluator::holds(const Condition& condition, Frame& frame, const State& state, double duration) const {
  return judge(condition, frame, state, [&](const Condition& comparison, const Frame& bound) {
    const auto left = number(comparison.sides[0], bound, state, duration);
    const auto right = number(comparison.sides[1], bound, state, duration);
    return left && right && compare(*left, comparison.comparison, *right);
  });
}

bool Evaluator::ground(const Effect& effect, const Frame& frame, const State& state, double duration,
                       std::vector<Change>& out) const {
  constexpr std::int64_t kOfAChange = 20;  // it stays in memory
  if (!effect.variables.empty() && !spend(kOfAChange)) return false;
  const Objects objects(effect.terms, frame);
  Change change{effect.kind,
                effect.is_numeric() ? effect.function : effect.predicate,
                {objects.begin(), objects.end()},
                0,
                &effect};
  if (effect.is_numeric()) {
    const auto value = number(effect.value, frame, state, duration);
    if (!value) return false;
    change.value = *value;
  }
  out.push_back(std::move(change));
  return true;
}

void Evaluator::derive(State& state) const {
  if (domain_.derivations.empty()) return;
  state.clear_derived();
  int highest = 0;
  for (const Predicate& predicate : domain_.predicates)
    if (predicate.derived) highest = std::max(highest, predicate.stratum);
  for (int stratum = 0; stratum <= highest; ++stratum) {
    for (bool changed = true; changed && !is_over();) {
      changed = false;
      for (const Derivation& rule : domain_.derivations) {
        if (domain_.predicates[rule.predicate].stratum != stratum) continue;
        Frame frame(static_cast<std::size_t>(rule.slots), 0);
        each_binding(rule.parameters, frame, [&] {
          const std::span<const ObjectId> head(frame.data(), rule.parameters.size());
          if (!state.holds(rule.predicate, head) && holds(rule.condition, frame, state)) {
            state.set(rule.predicate, head, true);
            changed = true;
          }
          return true;
        });
      }
    }
  }
}

}  // namespace cxlab::planner
