// Effects and durations of actions.

#include <algorithm>

#include "planner/pddl/resolver.h"

namespace cxlab::planner {
namespace {

std::optional<Effect::Kind> to_numeric_kind(std::string_view word) {
  if (word == "assign") return Effect::Kind::kAssign;
  if (word == "increase") return Effect::Kind::kIncrease;
  if (word == "decrease") return Effect::Kind::kDecrease;
  if (word == "scale-up") return Effect::Kind::kScaleUp;
  if (word == "scale-down") return Effect::Kind::kScaleDown;
  return std::nullopt;
}

bool mentions_elapsed(const Node& node) {
  if (!node.is_list) return node.word == "#t";
  return std::any_of(node.items.begin(), node.items.end(), mentions_elapsed);
}

}  // namespace

bool Resolver::duration(const Node& node, std::vector<DurationConstraint>& out) {
  if (!node.is_list) return fail(node, "found '" + std::string(node.word) + "', expected (= ?duration NUMBER)");
  if (node.items.empty()) return true;
  const std::string_view head = node.head();
  if (head == "and") {
    for (std::size_t i = 1; i < node.items.size(); ++i)
      if (!duration(node.items[i], out)) return false;
    return true;
  }
  if (head == "at" && node.items.size() == 3 && (node.items[1].is_word("start") || node.items[1].is_word("end"))) {
    const std::size_t first = out.size();
    if (!duration(node.items[2], out)) return false;
    for (std::size_t i = first; i < out.size(); ++i) out[i].at_end = node.items[1].is_word("end");
    return true;
  }
  if (node.items.size() != 3 || (head != "=" && head != "<=" && head != ">="))
    return fail(node, "found " + excerpt(node) +
                          ", expected (= ?duration NUMBER), (<= ?duration NUMBER) or (>= ?duration NUMBER)");
  DurationConstraint constraint;
  if (head == "<=") constraint.comparison = Comparison::kLessEqual;
  if (head == ">=") constraint.comparison = Comparison::kGreaterEqual;
  const bool left = node.items[1].is_word("?duration");
  if (!left && !node.items[2].is_word("?duration"))
    return fail(node, "found " + excerpt(node) + ", expected ?duration on one side");
  if (!left && head == "<=") constraint.comparison = Comparison::kGreaterEqual;
  if (!left && head == ">=") constraint.comparison = Comparison::kLessEqual;
  if (!expression(node.items[left ? 2 : 1], Place::kDuration, constraint.bound)) return false;
  out.push_back(std::move(constraint));
  return true;
}

bool Resolver::effects(const Node& node, std::vector<Effect>& out) {
  EffectContext context;
  context.time = Effect::Time::kStart;
  return effect(node, context, out);
}

bool Resolver::timed_effects(const Node& node, std::vector<Effect>& out) {
  EffectContext context;
  context.durative = true;
  return effect(node, context, out);
}

bool Resolver::effect(const Node& node, const EffectContext& context, std::vector<Effect>& out) {
  if (!node.is_list) return fail(node, "found '" + std::string(node.word) + "', expected an effect in parentheses");
  if (node.items.empty()) return true;
  const std::string_view head = node.head();
  if (head == "and") {
    for (std::size_t i = 1; i < node.items.size(); ++i)
      if (!effect(node.items[i], context, out)) return false;
    return true;
  }
  if (head == "forall") {
    if (node.items.size() != 3)
      return fail(node, "found " + excerpt(node) + ", expected (forall (?x - TYPE ...) EFFECT)");
    const std::size_t outer = scope_.size();
    EffectContext inner = context;
    std::vector<Variable> variables;
    if (!declare_variables(node.items[1], variables)) return false;
    inner.variables.insert(inner.variables.end(), variables.begin(), variables.end());
    if (!effect(node.items[2], inner, out)) return false;
    scope_.resize(outer);
    return true;
  }
  if (head == "when") return conditional_effect(node, context, out);
  const std::string_view when =
      node.items.size() == 3 && !node.items[1].is_list ? node.items[1].word : std::string_view{};
  if (context.durative && !context.time) {
    if (head == "at" && (when == "start" || when == "end")) {
      EffectContext inner = context;
      inner.time = when == "start" ? Effect::Time::kStart : Effect::Time::kEnd;
      return effect(node.items[2], inner, out);
    }
    if ((head == "increase" || head == "decrease") && mentions_elapsed(node)) {
      EffectContext inner = context;
      inner.time = Effect::Time::kContinuous;
      return numeric_effect(node, inner, out);
    }
    return fail(node, "found " + excerpt(node) +
                          ", expected (at start ...), (at end ...) or a continuous (increase F (* #t RATE))");
  }
  if (to_numeric_kind(head)) return numeric_effect(node, context, out);
  for (const std::string_view word : {"or", "imply", "exists", "=", "<", "<=", ">", ">="})
    if (head == word && find(domain_.predicate_names, head) < 0)
      return fail(
          node,
          "found " + excerpt(node) +
              ", expected an effect: it cannot leave open what happens, and numbers are set by (assign F NUMBER)");
  return literal_effect(node, context, out);
}

bool Resolver::conditional_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out) {
  if (node.items.size() != 3) return fail(node, "found " + excerpt(node) + ", expected (when CONDITION EFFECT)");
  EffectContext inner = context;
  const std::size_t outer = scope_.size();
  if (context.durative && !context.time) {
    if (!timed_condition(node.items[1], inner.condition)) return false;
  } else {
    Condition parsed;
    if (!condition(node.items[1], parsed)) return false;
    conjoin(context.time == Effect::Time::kEnd ? inner.condition.end : inner.condition.start, std::move(parsed));
  }
  scope_.resize(outer);
  const std::size_t first = out.size();
  if (!effect(node.items[2], inner, out)) return false;
  for (std::size_t i = first; i < out.size(); ++i) {
    const TimedCondition& when = out[i].condition;
    if (out[i].time == Effect::Time::kStart && (!when.over_all.is_true() || !when.end.is_true()))
      return fail(node,
                  "found an effect at start with a condition that is known only later, expected a condition at start");
    if (out[i].time == Effect::Time::kContinuous)
      return fail_unsupported(node, "found a conditional continuous effect: not supported");
  }
  return true;
}

bool Resolver::rate(const Node& node, Expression& out) {
  if (node.is_word("#t")) {
    out = Expression::constant(1);
    return true;
  }
  using Kind = Expression::Kind;
  const std::string_view head = node.head();
  const std::size_t operands = node.is_list && !node.items.empty() ? node.items.size() - 1 : 0;
  if (head == "*" && operands >= 2) {
    out.kind = Kind::kMultiply;
    bool found = false;
    for (std::size_t i = 1; i <= operands; ++i) {
      const Node& item = node.items[i];
      Expression factor;
      if (mentions_elapsed(item)) {
        if (found)
          return fail_unsupported(
              node, "found " + excerpt(node) + ": only linear change is supported, #t must occur once in a product");
        found = true;
        if (!rate(item, factor)) return false;
      } else if (!expression(item, Place::kEffect, factor)) {
        return false;
      }
      if (!item.is_word("#t")) out.operands.push_back(std::move(factor));
    }
    if (out.operands.size() == 1) {
      Expression only = std::move(out.operands.front());
      out = std::move(only);
    }
    return true;
  }
  if (head == "/" && operands == 2 && mentions_elapsed(node.items[1]) && !mentions_elapsed(node.items[2])) {
    out.kind = Kind::kDivide;
    out.operands.resize(2);
    return rate(node.items[1], out.operands[0]) && expression(node.items[2], Place::kEffect, out.operands[1]);
  }
  if ((head == "+" || head == "-") && operands >= 1) {
    out.kind = head == "+" ? Kind::kAdd : operands == 1 ? Kind::kNegate : Kind::kSubtract;
    if ((head == "+" && operands < 2) || (head == "-" && operands > 2))
      return fail(node, "found " + excerpt(node) + ", expected 2 operands");
    out.operands.resize(operands);
    for (std::size_t i = 0; i < operands; ++i) {
      if (!mentions_elapsed(node.items[i + 1]))
        return fail_unsupported(
            node, "found " + excerpt(node) + ": only linear change is supported, each summand must have its #t");
      if (!rate(node.items[i + 1], out.operands[i])) return false;
    }
    return true;
  }
  return fail_unsupported(node, "found the rate " + excerpt(node) + ": only linear change (* #t RATE) is supported");
}

bool Resolver::numeric_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out) {
  if (node.items.size() != 3)
    return fail(
        node, "found " + excerpt(node) + ", expected (" + std::string(node.head()) + " (FUNCTION ARGUMENT...) VALUE)");
  Effect effect;
  effect.kind = *to_numeric_kind(node.head());
  effect.time = *context.time;
  effect.variables = context.variables;
  effect.condition = context.condition;
  effect.source = source(node);
  if (!function_term(node.items[1], {}, effect.function, effect.terms)) return false;
  const bool right = effect.time == Effect::Time::kContinuous ? rate(node.items[2], effect.value)
                                                              : expression(node.items[2], Place::kEffect, effect.value);
  if (right) out.push_back(std::move(effect));
  return right;
}

bool Resolver::literal_effect(const Node& node, const EffectContext& context, std::vector<Effect>& out) {
  Effect effect;
  const bool negative = node.head() == "not";
  if (negative && node.items.size() != 2)
    return fail(node, "found " + excerpt(node) + ", expected (not (PREDICATE ARGUMENT...))");
  const Node& literal = negative ? node.items[1] : node;
  if (!literal.is_list)
    return fail(literal, "found '" + std::string(literal.word) + "', expected (PREDICATE ARGUMENT...)");
  effect.kind = negative ? Effect::Kind::kDelete : Effect::Kind::kAdd;
  effect.time = *context.time;
  effect.variables = context.variables;
  effect.condition = context.condition;
  effect.source = source(node);
  static constexpr const char* kWords[] = {"and",      "not",      "when",     "forall",    "assign",
                                           "increase", "decrease", "scale-up", "scale-down"};
  if (!atom(literal, negative ? Words{} : Words(kWords), effect.predicate, effect.terms)) return false;
  const Predicate& predicate = domain_.predicates[effect.predicate];
  if (predicate.derived)
    return fail(literal, "found an effect on '" + predicate.name +
                             "', which is derived by a rule; expected a predicate without one" +
                             declared(predicate.source));
  out.push_back(std::move(effect));
  return true;
}

}  // namespace cxlab::planner
