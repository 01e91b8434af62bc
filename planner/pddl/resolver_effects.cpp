// Effects and durations of actions.

#include <algorithm>
#include <tuple>

#include "planner/pddl/resolver.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

bool mentions_elapsed(const Node& node) {
  if (!node.is_list) return node.word == "#t";
  return std::ranges::any_of(node.items, mentions_elapsed);
}

}  // namespace

std::vector<DurationConstraint> Resolver::duration(const Node& node) {
  if (!node.is_list) fail(node, found_text(node.word, "(= ?duration NUMBER)"));
  std::vector<DurationConstraint> out;
  if (node.items.empty()) return out;
  const std::string_view head = node.head();
  if (head == "and") {
    for (const Node& part : node.rest()) std::ranges::move(duration(part), std::back_inserter(out));
    return out;
  }
  if (head == "at" && node.items.size() == 3 && (node.items[1].is_word("start") || node.items[1].is_word("end"))) {
    out = duration(node.items[2]);
    for (DurationConstraint& constraint : out) constraint.at_end = node.items[1].is_word("end");
    return out;
  }
  auto comparison = kind_of<Comparison>(kComparisonWords, head);
  if (node.items.size() != 3 || !comparison || head == "<" || head == ">")
    fail(node, found_expected(message(node), "(= ?duration NUMBER), (<= ?duration NUMBER) or (>= ?duration NUMBER)"));
  const bool left = node.items[1].is_word("?duration");
  if (!left && !node.items[2].is_word("?duration")) fail(node, found_expected(message(node), "?duration on one side"));
  if (!left && head == "<=") comparison = Comparison::kGreaterEqual;
  if (!left && head == ">=") comparison = Comparison::kLessEqual;
  out.push_back({*comparison, expression(node.items[left ? 2 : 1], Place::kDuration)});
  return out;
}

std::vector<Effect> Resolver::effects(const Node& node) {
  std::vector<Effect> out;
  effect(node, {}, !in_durative_, out);
  return out;
}

void Resolver::effect(const Node& node, Effect pattern, bool timed, std::vector<Effect>& out) {
  if (!node.is_list) fail(node, found_text(node.word, "an effect in parentheses"));
  if (node.items.empty()) return;
  const std::string_view head = node.head();
  if (head == "and") {
    for (const Node& part : node.rest()) effect(part, pattern, timed, out);
    return;
  }
  if (head == "forall") {
    if (node.items.size() != 3) fail(node, found_expected(message(node), "(forall (?x - TYPE ...) EFFECT)"));
    const std::size_t outer = scope_.size();
    std::ranges::move(variables(node.items[1]), std::back_inserter(pattern.variables));
    effect(node.items[2], std::move(pattern), timed, out);
    scope_.resize(outer);
    return;
  }
  if (head == "when") return conditional_effect(node, std::move(pattern), timed, out);
  if (!timed) {
    const std::string_view when = node.items.size() == 3 ? node.items[1].word : std::string_view();
    if (head == "at" && (when == "start" || when == "end")) {
      pattern.time = when == "start" ? Effect::Time::kStart : Effect::Time::kEnd;
      return effect(node.items[2], std::move(pattern), true, out);
    }
    if ((head != "increase" && head != "decrease") || !mentions_elapsed(node))
      fail(node,
           found_expected(message(node), "(at start ...), (at end ...) or a continuous (increase F (* #t RATE))"));
    pattern.time = Effect::Time::kContinuous;
  }
  if (kind_of<Effect::Kind>(kEffectWords, head)) {
    out.push_back(numeric_effect(node, std::move(pattern)));
    return;
  }
  for (const std::string_view word : {"or", "imply", "exists", "=", "<", "<=", ">", ">="})
    if (head == word && find(domain_.predicate_names, head) < 0)
      fail(node,
           found_expected(message(node),
                          "an effect: it cannot leave open what happens, and numbers are set by (assign F NUMBER)"));
  out.push_back(literal_effect(node, std::move(pattern)));
}

void Resolver::conditional_effect(const Node& node, Effect pattern, bool timed, std::vector<Effect>& out) {
  if (node.items.size() != 3) fail(node, found_expected(message(node), "(when CONDITION EFFECT)"));
  TimedCondition& condition = pattern.condition;
  if (!timed)
    timed_condition(node.items[1], condition);
  else
    conjoin(pattern.time == Effect::Time::kEnd ? condition.end : condition.start, this->condition(node.items[1]));
  const std::size_t first = out.size();
  effect(node.items[2], pattern, timed, out);
  for (const Effect& effect : out | std::views::drop(first)) {
    const TimedCondition& when = effect.condition;
    if (effect.time == Effect::Time::kStart && (!when.over_all.is_true() || !when.end.is_true()))
      fail(node,
           found_expected("an effect at start with a condition that is known only later", "a condition at start"));
    if (effect.time == Effect::Time::kContinuous)
      fail_unsupported(node, "found a conditional continuous effect: not supported");
  }
}

Expression Resolver::rate(const Node& node) {
  if (node.is_word("#t")) return Expression::constant(1);
  using Kind = Expression::Kind;
  Expression out;
  const std::string_view head = node.head();
  const std::size_t operands = node.rest().size();
  if (head == "*" && operands >= 2) {
    out.kind = Kind::kMultiply;
    bool found = false;
    for (const Node& item : node.rest()) {
      const bool elapsed = mentions_elapsed(item);
      if (elapsed && std::exchange(found, true))
        fail_unsupported(node, "found ", node, ": only linear change is supported, #t must occur once in a product");
      if (!item.is_word("#t")) out.operands.push_back(elapsed ? rate(item) : expression(item, Place::kEffect));
    }
    return out.operands.size() == 1 ? Expression(out.operands.front()) : out;
  }
  if (head == "/" && operands == 2 && mentions_elapsed(node.items[1]) && !mentions_elapsed(node.items[2])) {
    out.kind = Kind::kDivide;
    out.operands = {rate(node.items[1]), expression(node.items[2], Place::kEffect)};
    return out;
  }
  if ((head != "+" && head != "-") || operands == 0)
    fail_unsupported(node, "found the rate ", node, ": only linear change (* #t RATE) is supported");
  out.kind = head == "+" ? Kind::kAdd : operands == 1 ? Kind::kNegate : Kind::kSubtract;
  if (head == "+" ? operands < 2 : operands > 2) fail(node, found_expected(message(node), "2 operands"));
  for (const Node& item : node.rest()) {
    if (!mentions_elapsed(item))
      fail_unsupported(node, "found ", node, ": only linear change is supported, each summand must have its #t");
    out.operands.push_back(rate(item));
  }
  return out;
}

Effect Resolver::numeric_effect(const Node& node, Effect effect) {
  if (node.items.size() != 3)
    fail(node, found_expected(message(node), "("), node.head(), " (FUNCTION ARGUMENT...) VALUE)");
  effect.kind = *kind_of<Effect::Kind>(kEffectWords, node.head());
  effect.source = source(node);
  std::tie(effect.function, effect.terms) = function_term(node.items[1], {});
  effect.value =
      effect.time == Effect::Time::kContinuous ? rate(node.items[2]) : expression(node.items[2], Place::kEffect);
  return effect;
}

Effect Resolver::literal_effect(const Node& node, Effect effect) {
  const bool negative = node.head() == "not";
  if (negative && node.items.size() != 2) fail(node, found_expected(message(node), "(not (PREDICATE ARGUMENT...))"));
  const Node& literal = negative ? node.items[1] : node;
  if (!literal.is_list) fail(literal, found_text(literal.word, "(PREDICATE ARGUMENT...)"));
  effect.kind = negative ? Effect::Kind::kDelete : Effect::Kind::kAdd;
  effect.source = source(node);
  static constexpr std::string_view kWords[] = {"and",      "not",      "when",     "forall",    "assign",
                                                "increase", "decrease", "scale-up", "scale-down"};
  std::tie(effect.predicate, effect.terms) = atom(literal, negative ? Words() : Words(kWords));
  if (const Predicate& predicate = domain_.predicates[effect.predicate]; predicate.derived)
    fail(literal,
         found_expected(message("an effect on '", predicate.name, "', which is derived by a rule"),
                        "a predicate without one"),
         declared(predicate.source));
  return effect;
}

}  // namespace cxlab::planner
