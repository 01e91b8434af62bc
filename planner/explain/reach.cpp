#include "planner/explain/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/state/number.h"
#include "planner/state/state.h"

namespace cxlab::planner {

namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr Range kAny{-kEndless, kEndless};

double sum_of(double a, double b) { return std::isfinite(a) && std::isfinite(b) ? sum(a, b) : a + b; }

Range scaled(const Range& range, double by) {
  const auto times = [by](double value) { return std::isfinite(value) ? product(value, by) : value * by; };
  if (by == 0) return {0, 0};
  return by > 0 ? Range{times(range.low), times(range.high)} : Range{times(range.high), times(range.low)};
}

Range product_of(const Range& a, const Range& b) {
  if (b.is_point()) return scaled(a, b.low);
  return a.is_point() ? scaled(b, a.low) : kAny;
}

std::optional<Range> quotient_of(const Range& a, const Range& b) {
  if (!b.is_point()) return kAny;
  if (b.low == 0) return std::nullopt;
  const auto by = [&](double value) { return std::isfinite(value) ? quotient(value, b.low) : value / b.low; };
  return b.low > 0 ? Range{by(a.low), by(a.high)} : Range{by(a.high), by(a.low)};
}

bool compares(double left, Comparison comparison, double right) {
  if (std::isfinite(left) && std::isfinite(right)) return compare(left, comparison, right);
  return comparison == Comparison::kLess ? left < right : left <= right;
}

bool meets(const Range& left, Comparison comparison, const Range& right) {
  switch (comparison) {
    case Comparison::kLess:
    case Comparison::kLessEqual: return compares(left.low, comparison, right.high);
    case Comparison::kGreater: return compares(right.low, Comparison::kLess, left.high);
    case Comparison::kGreaterEqual: return compares(right.low, Comparison::kLessEqual, left.high);
    case Comparison::kEqual: break;
  }
  return compares(left.low, Comparison::kLessEqual, right.high) &&
         compares(right.low, Comparison::kLessEqual, left.high);
}

}  // namespace

PairJudge::PairJudge(const GroundTask& ground, Together together) : together_(std::move(together)) {
  for (std::size_t f = 0; f < ground.facts.size(); ++f) {
    const GroundFact& fact = ground.facts[f];
    if (fact.predicate < 0) continue;
    const int atom = atoms_.insert(fact.predicate, fact.objects);
    if (atom == static_cast<int>(ids_.size())) ids_.emplace_back(-1, -1);
    (fact.is_complement ? ids_[atom].second : ids_[atom].first) = static_cast<int>(f);
  }
}

int PairJudge::id(PredicateId predicate, std::span<const ObjectId> objects, bool value) const {
  const int atom = atoms_.find(predicate, objects);
  if (atom < 0) return -1;
  return value ? ids_[atom].first : ids_[atom].second;
}

bool PairJudge::can_be(PredicateId predicate, std::span<const ObjectId> objects, bool value) const {
  const int fact = id(predicate, objects, value);
  return can_be_both(fact, fact);
}

Reach::Reach(const Task& task, const Reachable& reachable, Budget& budget, const PairJudge* pairs)
    : task_(task),
      reachable_(reachable),
      budget_(budget),
      pairs_(pairs),
      stages_(reachable.bindings.size(), Stage::kNone) {
  for (const Fact& fact : task.problem.init) initial_.insert(fact.predicate, fact.objects);
  for (bool changed = true; changed && !budget.over();) {  // what can begin but never end is in no plan
    spread();
    changed = false;
    for (Stage& stage : stages_)
      if (stage == Stage::kBegun) {
        stage = Stage::kUseless;
        changed = true;
      }
  }
}

void Reach::spread() {
  true_ = {};
  deleted_ = {};
  valued_ = {};
  numbers_.clear();
  by_predicate_.assign(task_.domain.predicates.size(), {});
  for (Stage& stage : stages_)
    if (stage != Stage::kUseless) stage = Stage::kNone;
  for (const Fact& fact : task_.problem.init) add(fact.predicate, fact.objects);
  for (const Assignment& value : task_.problem.values)
    number(value.function, value.objects) = {value.value, true, true, false, false};
  for (const TimedFact& timed : task_.problem.timed_facts)
    timed.value ? void(add(timed.fact.predicate, timed.fact.objects))
                : void(deleted_.insert(timed.fact.predicate, timed.fact.objects));
  for (const TimedAssignment& timed : task_.problem.timed_values)
    move(number(timed.assignment.function, timed.assignment.objects), true, true);
  for (bool changed = true; changed && !budget_.over();) changed = round();
}

bool Reach::add(PredicateId predicate, std::span<const ObjectId> objects) {
  const int before = true_.size(), atom = true_.insert(predicate, objects);
  if (atom < before) return false;
  by_predicate_[predicate].push_back(atom);
  return true;
}

Reach::Number& Reach::number(FunctionId function, std::span<const ObjectId> objects) {
  const int id = valued_.insert(function, objects);
  if (id == static_cast<int>(numbers_.size())) numbers_.emplace_back();
  return numbers_[id];
}

bool Reach::move(Number& number, bool up, bool down) {
  const bool changed = !number.defined || (up && !number.up) || (down && !number.down);
  number.defined = true;
  number.up |= up;
  number.down |= down;
  return changed;
}

bool Reach::round() {
  bool changed = false;
  for (std::size_t b = 0; b < stages_.size() && !budget_.over(); ++b)
    if (stages_[b] != Stage::kUseless) changed |= advance(reachable_.bindings[b], stages_[b]);
  for (const Derivation& rule : task_.domain.derivations) {
    Frame frame(static_cast<std::size_t>(rule.slots), -1);
    for_each_assignment(task_, rule.parameters, frame, budget_, [&] {
      std::vector<ObjectId> objects;
      for (const Variable& parameter : rule.parameters) objects.push_back(frame[parameter.slot]);
      if (true_.find(rule.predicate, objects) < 0 && can_hold(rule.condition, frame, true))
        changed |= add(rule.predicate, objects);
    });
  }
  return changed;
}

/// As far as an action comes by what can be so now, with what it brings about.
bool Reach::advance(const Binding& binding, Stage& stage) {
  const Action& action = task_.domain.actions[binding.action];
  const bool conditional =
      std::ranges::any_of(action.effects, [](const Effect& effect) { return !effect.condition.is_true(); });
  if (stage == Stage::kEnded && !conditional) return false;
  budget_.spend(Work::kGround, 1);
  Frame frame(static_cast<std::size_t>(action.slots), -1);
  std::ranges::copy(binding.arguments, frame.begin());
  bool changed = false;
  if (stage == Stage::kNone) {
    if (!can_hold(action.condition.start, frame, true) || never_together(action.condition.start, frame) ||
        !has_durations(action, false, frame) || !has_values(action, Effect::Time::kStart, frame))
      return false;
    stage = Stage::kBegun;
    changed = true;
    apply(action, Effect::Time::kStart, false, frame);
    apply(action, Effect::Time::kContinuous, false, frame);
  }
  const bool lasts = takes_time(action, frame);
  if (stage == Stage::kBegun &&
      (!lasts ||
       (can_hold(action.condition.over_all, frame, true) && !never_together(action.condition.over_all, frame) &&
        has_values(action, Effect::Time::kContinuous, frame))) &&
      can_hold(action.condition.end, frame, true) && !never_together(action.condition.end, frame) &&
      has_durations(action, true, frame) && has_values(action, Effect::Time::kEnd, frame)) {
    stage = Stage::kEnded;
    changed = true;
    apply(action, Effect::Time::kEnd, false, frame);
  }
  if (!conditional) return changed;
  changed |= apply(action, Effect::Time::kStart, true, frame);
  if (stage == Stage::kEnded) changed |= apply(action, Effect::Time::kEnd, true, frame);
  return changed;
}

bool Reach::has_values(const Action& action, Effect::Time time, const Frame& frame) const {
  return std::ranges::all_of(action.effects, [&](const Effect& effect) {
    if (!effect.is_numeric() || effect.time != time || !effect.condition.is_true() || !effect.variables.empty())
      return true;
    if (!range(effect.value, frame)) return false;
    const int id = valued_.find(effect.function, Objects(effect.terms, frame));
    return effect.kind == Effect::Kind::kAssign || (id >= 0 && numbers_[id].defined);
  });
}

bool Reach::has_durations(const Action& action, bool ends, const Frame& frame) const {
  return std::ranges::all_of(action.duration, [&](const DurationConstraint& duration) {
    return duration.at_end != ends || range(duration.bound, frame).has_value();
  });
}

bool Reach::apply(const Action& action, Effect::Time time, bool conditional, Frame& frame) {
  bool changed = false;
  for (const Effect& effect : action.effects) {
    if (effect.time != time || effect.condition.is_true() == conditional) continue;
    for_each_assignment(task_, effect.variables, frame, budget_, [&] {
      const auto parts = effect.condition.parts();
      if (std::ranges::all_of(parts, [&](const Condition* part) { return can_hold(*part, frame, true); }))
        changed |= apply(effect, frame);
    });
  }
  return changed;
}

bool Reach::apply(const Effect& effect, const Frame& frame) {
  using Kind = Effect::Kind;
  const Objects objects(effect.terms, frame);
  if (effect.kind == Kind::kAdd) return add(effect.predicate, objects);
  if (effect.kind == Kind::kDelete) {
    const int before = deleted_.size();
    return deleted_.insert(effect.predicate, objects) >= before;
  }
  const std::optional<Range> value = range(effect.value, frame);
  if (!value) return false;
  Number& changed = number(effect.function, objects);
  if (effect.kind == Kind::kIncrease || effect.kind == Kind::kDecrease) {
    if (!changed.defined) return false;
    const bool rises = value->high > 0, falls = value->low < 0, adds = effect.kind == Kind::kIncrease;
    return move(changed, adds ? rises : falls, adds ? falls : rises);
  }
  return (effect.kind == Kind::kAssign || changed.defined) && move(changed, true, true);
}

bool Reach::can_be(PredicateId predicate, std::span<const ObjectId> objects, bool value) const {
  if (pairs_ != nullptr && !pairs_->can_be(predicate, objects, value)) return false;
  if (value) return true_.find(predicate, objects) >= 0;
  return task_.domain.predicates[predicate].derived || initial_.find(predicate, objects) < 0 ||
         deleted_.find(predicate, objects) >= 0;
}

bool Reach::any_assignment(std::span<const Variable> variables, Frame& frame,
                           const std::function<bool()>& holds) const {
  if (variables.empty()) return holds();
  for (const ObjectId object : objects_of(task_.domain, task_.problem, variables[0].types)) {
    if (budget_.over()) return true;
    frame[variables[0].slot] = object;
    if (any_assignment(variables.subspan(1), frame, holds)) return true;
  }
  return false;
}

bool Reach::can_hold(const Condition& condition, Frame& frame, bool wanted) const {
  using Kind = Condition::Kind;
  budget_.spend(Work::kGround, 1);
  const auto operand = [&](const Condition& part) { return can_hold(part, frame, wanted); };
  switch (condition.kind) {
    case Kind::kAtom: return can_be(condition.predicate, Objects(condition.terms, frame), wanted);
    case Kind::kSame: return (condition.terms[0].in(frame) == condition.terms[1].in(frame)) == wanted;
    case Kind::kCompare: return can_compare(condition, frame, wanted);
    case Kind::kNot: return can_hold(condition.operands[0], frame, !wanted);
    case Kind::kAnd:
    case Kind::kOr:
      return (condition.kind == Kind::kAnd) == wanted ? std::ranges::all_of(condition.operands, operand)
                                                      : std::ranges::any_of(condition.operands, operand);
    case Kind::kImply: {
      const bool premise = can_hold(condition.operands[0], frame, !wanted);
      const bool then = can_hold(condition.operands[1], frame, wanted);
      return wanted ? premise || then : premise && then;
    }
    case Kind::kForall:
    case Kind::kExists: {
      const bool some = (condition.kind == Kind::kExists) == wanted;
      const bool found = any_assignment(condition.variables, frame,
                                        [&] { return can_hold(condition.operands[0], frame, wanted) == some; });
      return found == some;
    }
  }
  return true;
}

bool Reach::can_compare(const Condition& condition, const Frame& frame, bool wanted) const {
  const std::optional<Range> left = range(condition.sides[0], frame), right = range(condition.sides[1], frame);
  if (!left || !right) return !wanted;
  if (wanted) return meets(*left, condition.comparison, *right);
  switch (condition.comparison) {
    case Comparison::kLess: return meets(*left, Comparison::kGreaterEqual, *right);
    case Comparison::kLessEqual: return meets(*left, Comparison::kGreater, *right);
    case Comparison::kGreaterEqual: return meets(*left, Comparison::kLess, *right);
    case Comparison::kGreater: return meets(*left, Comparison::kLessEqual, *right);
    case Comparison::kEqual: break;
  }
  return !left->is_point() || !right->is_point() || !compare(left->low, Comparison::kEqual, right->low);
}

/// The facts that a condition cannot hold without.
void Reach::collect(const Condition& condition, Frame& frame, bool wanted, std::vector<GroundLiteral>& out) const {
  using Kind = Condition::Kind;
  const bool all = condition.kind == Kind::kAnd || condition.kind == Kind::kForall;
  if (condition.kind == Kind::kNot) {
    collect(condition.operands[0], frame, !wanted, out);
  } else if (condition.kind == Kind::kAtom) {
    const Objects objects(condition.terms, frame);
    out.push_back({condition.predicate, {objects.begin(), objects.end()}, wanted});
  } else if (condition.kind == Kind::kImply && !wanted) {
    collect(condition.operands[0], frame, true, out);
    collect(condition.operands[1], frame, false, out);
  } else if (condition.kind == Kind::kSame || condition.kind == Kind::kCompare || condition.kind == Kind::kImply ||
             all != wanted) {
    return;
  } else if (condition.kind == Kind::kAnd || condition.kind == Kind::kOr) {
    for (const Condition& operand : condition.operands) collect(operand, frame, wanted, out);
  } else {
    any_assignment(condition.variables, frame, [&] {
      collect(condition.operands[0], frame, wanted, out);
      return false;
    });
  }
}

std::optional<std::pair<GroundLiteral, GroundLiteral>> Reach::never_together(const Condition& condition,
                                                                             Frame& frame) const {
  if (pairs_ == nullptr) return std::nullopt;
  std::vector<GroundLiteral> facts;
  collect(condition, frame, true, facts);
  std::erase_if(facts, [this](const GroundLiteral& f) { return pairs_->id(f.predicate, f.objects, f.value) < 0; });
  const auto id = [this](const GroundLiteral& f) { return pairs_->id(f.predicate, f.objects, f.value); };
  budget_.spend(Work::kGround, std::ssize(facts) * std::ssize(facts) / 2);
  for (std::size_t i = 0; i < facts.size() && !budget_.over(); ++i)
    for (std::size_t j = i + 1; j < facts.size(); ++j)
      if (!pairs_->can_be_both(id(facts[i]), id(facts[j]))) return std::pair(facts[i], facts[j]);
  return std::nullopt;
}

std::optional<Range> Reach::range(const Expression& expression, const Frame& frame) const {
  using Kind = Expression::Kind;
  if (expression.kind == Kind::kConstant) return Range{expression.value, expression.value};
  if (expression.kind == Kind::kDuration || expression.kind == Kind::kTotalTime) return kAny;
  if (expression.kind == Kind::kFunction) {
    const int id = valued_.find(expression.function, Objects(expression.terms, frame));
    if (id < 0 || !numbers_[id].defined) return std::nullopt;
    const Number& found = numbers_[id];
    if (!found.initial) return kAny;
    return Range{found.down ? -kEndless : found.value, found.up ? kEndless : found.value};
  }
  std::optional<Range> result;
  for (const Expression& operand : expression.operands) {
    const std::optional<Range> next = range(operand, frame);
    if (!next) return std::nullopt;
    if (!result) {
      result = expression.kind == Kind::kNegate ? scaled(*next, -1) : *next;
      continue;
    }
    switch (expression.kind) {
      case Kind::kAdd: result = Range{sum_of(result->low, next->low), sum_of(result->high, next->high)}; break;
      case Kind::kSubtract: result = Range{sum_of(result->low, -next->high), sum_of(result->high, -next->low)}; break;
      case Kind::kMultiply: result = product_of(*result, *next); break;
      default: result = quotient_of(*result, *next); break;
    }
    if (!result) return std::nullopt;
  }
  return result;
}

bool Reach::takes_time(const Action& action, const Frame& frame) const {
  if (!action.durative) return true;
  return std::ranges::any_of(action.duration, [&](const DurationConstraint& duration) {
    const std::optional<Range> bound = range(duration.bound, frame);
    return duration.comparison != Comparison::kLessEqual && bound && bound->low > 0;
  });
}

std::optional<double> Reach::initial_value(FunctionId function, std::span<const ObjectId> objects) const {
  const int id = valued_.find(function, objects);
  return id >= 0 && numbers_[id].initial ? std::optional(numbers_[id].value) : std::nullopt;
}

}  // namespace cxlab::planner
