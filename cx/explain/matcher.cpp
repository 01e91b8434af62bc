#include "cx/explain/matcher.h"

#include <algorithm>

namespace cxlab::explain {

using Kind = Condition::Kind;

Facts::Facts(const RuleEngine& engine, std::string module)
    : engine_(engine), module_(std::move(module)), facts_(engine.facts()), instances_(engine.instances(module_)) {}

const std::vector<const FactCopy*>& Facts::of(const Pattern& pattern) const {
  const auto [known, fresh] = by_template_.try_emplace(pattern.template_name());
  std::vector<const FactCopy*>& found = known->second;
  if (!fresh) return found;
  if (pattern.is_object()) {
    for (const FactCopy& instance : instances_) found.push_back(&instance);
    return found;
  }
  const std::string module = engine_.template_module(module_, pattern.template_name());
  for (const FactCopy& fact : facts_)
    if (fact.template_name == pattern.template_name() && fact.module == module) found.push_back(&fact);
  return found;
}

namespace {

Matcher::Conditions pointers(const std::vector<Condition>& conditions) {
  Matcher::Conditions out;
  for (const Condition& condition : conditions) out.push_back(&condition);
  return out;
}

}  // namespace

Combination inside(Combination combination) {
  combination.bindings.want_nothing();
  return combination;
}

bool Matcher::satisfy_one(const Condition& condition, Combination& now, const std::function<bool()>& then) {
  switch (condition.kind) {
    case Kind::kPattern:
      for (const FactCopy* fact : facts_.of(condition.pattern)) {
        if (++tried_ > kMostTried) return false;
        const std::size_t bound = now.bindings.size();
        const bool done = condition.pattern.match(*fact, now.bindings, &evaluator_, [&] {
          const std::size_t inner = now.bindings.size();
          if (!condition.fact_variable.empty()) {
            const bool instance = !fact->classes.empty();
            if (!now.bindings.bind(condition.fact_variable, instance ? *fact->slot("name") : Value::fact(fact->index)))
              return false;
          }
          now.facts.push_back(fact);
          const bool ended = then();
          now.facts.pop_back();
          now.bindings.forget_beyond(inner);
          return ended;
        });
        now.bindings.forget_beyond(bound);
        if (done) return true;
      }
      return false;
    case Kind::kTest: {
      const auto value = evaluator_.value(condition.expression, now.bindings);
      return value && value->is_true() && then();
    }
    case Kind::kAnd: {
      const Conditions parts = pointers(condition.parts);
      return walk(parts, 0, now, [&](const Combination&) { return then(); });
    }
    case Kind::kOr:
      for (const Condition& part : condition.parts)
        if (satisfy_one(part, now, then)) return true;
      return false;
    case Kind::kNot: return !satisfiable(pointers(condition.parts), inside(now)) && then();
    case Kind::kExists: return satisfiable(pointers(condition.parts), inside(now)) && then();
    case Kind::kForall: {
      const Conditions parts = pointers(condition.parts);
      const Conditions rest(parts.begin() + 1, parts.end());
      const bool exception =
          satisfy({parts.front()}, inside(now), [&](const Combination& each) { return !satisfiable(rest, each); });
      return !exception && then();
    }
  }
  return false;
}

bool Matcher::walk(const Conditions& conditions, std::size_t from, Combination& now, const Found& found) {
  if (from == conditions.size()) return found(now);
  return satisfy_one(*conditions[from], now, [&] { return walk(conditions, from + 1, now, found); });
}

bool Matcher::satisfy(const Conditions& conditions, const Combination& begun, const Found& found) {
  Combination now = begun;
  return walk(conditions, 0, now, found);
}

bool Matcher::satisfiable(const Conditions& conditions, const Combination& begun) {
  return satisfy(conditions, begun, [](const Combination&) { return true; });
}

Matcher::Reach Matcher::reach(const Conditions& conditions, const Combination& begun) {
  Reach reach;
  Combination now = begun;
  const std::function<void(std::size_t)> go = [&](std::size_t depth) {
    if (depth > reach.depth) reach = {depth, {}, 0};
    if (depth == reach.depth && ++reach.count <= kKept) reach.combinations.push_back(now);
    if (depth == conditions.size()) return;
    satisfy_one(*conditions[depth], now, [&] {
      go(depth + 1);
      return exhausted();
    });
  };
  go(0);
  return reach;
}

namespace {

void add(std::vector<Alternative>& alternatives, const Condition& condition, int number);

void add_all(std::vector<Alternative>& alternatives, const std::vector<Condition>& conditions, int number) {
  for (const Condition& condition : conditions) add(alternatives, condition, number);
}

void add(std::vector<Alternative>& alternatives, const Condition& condition, int number) {
  if (condition.kind == Kind::kAnd) return add_all(alternatives, condition.parts, number);
  if (condition.kind != Kind::kOr) {
    for (Alternative& alternative : alternatives) {
      alternative.conditions.push_back(&condition);
      alternative.numbers.push_back(number);
    }
    return;
  }
  std::vector<Alternative> grown;
  for (const Alternative& alternative : alternatives)
    for (const Condition& part : condition.parts) {
      std::vector<Alternative> with_part{alternative};
      add(with_part, part, number);
      grown.insert(grown.end(), with_part.begin(), with_part.end());
    }
  alternatives = std::move(grown);
}

}  // namespace

std::vector<std::string> Alternative::binds() const {
  std::vector<std::string> names;
  for (const Condition* condition : conditions) {
    if (condition->kind != Kind::kPattern) continue;
    std::vector<std::string> bound = condition->pattern.binds();
    if (!condition->fact_variable.empty()) bound.push_back(condition->fact_variable);
    for (std::string& name : bound)
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
  }
  return names;
}

std::vector<Alternative> alternatives_of(const std::vector<Condition>& conditions) {
  std::vector<Alternative> alternatives(1);
  for (std::size_t i = 0; i < conditions.size(); ++i) add(alternatives, conditions[i], static_cast<int>(i) + 1);
  return alternatives;
}

}  // namespace cxlab::explain
