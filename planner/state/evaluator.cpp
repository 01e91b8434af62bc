#include <cmath>

#include "planner/state/state.h"
#include "planner/state/tolerance.h"

namespace cxlab::planner {

bool compare(double left, Comparison comparison, double right) {
  const double scale = std::max({1.0, std::abs(left), std::abs(right)});
  const bool equal = std::abs(left - right) <= kEqualWithin * scale;
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
      case Kind::kAdd: result += *next; break;
      case Kind::kSubtract: result -= *next; break;
      case Kind::kMultiply: result *= *next; break;
      default: result /= *next;
    }
    if (!std::isfinite(result)) return std::nullopt;
  }
  return result;
}

bool Evaluator::holds(const Condition& condition, Frame& frame, const State& state, double duration) const {
  using Kind = Condition::Kind;
  switch (condition.kind) {
    case Kind::kAtom: return state.holds(condition.predicate, Objects(condition.terms, frame));
    case Kind::kSame: {
      const Objects both(condition.terms, frame);
      return both.begin()[0] == both.begin()[1];
    }
    case Kind::kCompare: {
      const auto left = number(condition.sides[0], frame, state, duration);
      const auto right = number(condition.sides[1], frame, state, duration);
      return left && right && compare(*left, condition.comparison, *right);
    }
    case Kind::kNot: return !holds(condition.operands[0], frame, state, duration);
    case Kind::kImply:
      return !holds(condition.operands[0], frame, state, duration) ||
             holds(condition.operands[1], frame, state, duration);
    case Kind::kAnd:
      for (const Condition& operand : condition.operands)
        if (!holds(operand, frame, state, duration)) return false;
      return true;
    case Kind::kOr:
      for (const Condition& operand : condition.operands)
        if (holds(operand, frame, state, duration)) return true;
      return false;
    case Kind::kForall:
      return each_binding(condition.variables, frame,
                          [&] { return holds(condition.operands[0], frame, state, duration); });
    case Kind::kExists:
      return !each_binding(condition.variables, frame,
                           [&] { return !holds(condition.operands[0], frame, state, duration); });
  }
  return false;
}

bool Evaluator::ground(const Effect& effect, const Frame& frame, const State& state, double duration,
                       std::vector<Change>& out) const {
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
    for (bool changed = true; changed;) {
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
