#include "cx/explain/why_not.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cx/explain/json.h"
#include "cx/explain/matcher.h"

namespace cxlab::explain {

namespace {

using Kind = Condition::Kind;

std::string print(const Combination& combination, std::size_t from) {
  std::string out;
  for (std::size_t i = from; i < combination.facts.size(); ++i)
    out += (out.empty() ? "" : " ") + combination.facts[i]->print();
  return out;
}

void put_values(const Bindings& bindings, UnmetCondition& unmet) {
  unmet.values.clear();
  for (const auto& [name, value] : bindings) unmet.values.emplace_back(name, value.print());
}

/// Finds the first condition of a list that nothing gets past, and what is wrong with it.
class Explainer {
 public:
  explicit Explainer(Matcher& matcher) : matcher_(matcher) {}

  /// None if all hold together for one of the combinations that were begun.
  std::optional<UnmetCondition> first_unmet(const std::vector<Alternative>& alternatives,
                                            const std::vector<Combination>& begun) {
    const Alternative* best = nullptr;
    Matcher::Reach furthest;
    for (const Alternative& alternative : alternatives)
      for (const Combination& start : begun) {
        Matcher::Reach reach = matcher_.reach(alternative.conditions, start);
        if (reach.depth == alternative.conditions.size()) return std::nullopt;
        if (best && reach.depth <= furthest.depth) continue;
        best = &alternative;
        furthest = std::move(reach);
      }
    if (!best) return UnmetCondition{};
    UnmetCondition unmet = describe(*best->conditions[furthest.depth], furthest);
    unmet.number = best->numbers[furthest.depth];
    unmet.text = best->conditions[furthest.depth]->text;
    return unmet;
  }

 private:
  UnmetCondition describe(const Condition& condition, const Matcher::Reach& reach) {
    switch (condition.kind) {
      case Kind::kPattern: return describe_pattern(condition.pattern, reach);
      case Kind::kTest: return describe_test(condition.expression, reach);
      case Kind::kNot: return describe_not(condition, reach);
      case Kind::kForall: return describe_forall(condition, reach);
      case Kind::kAnd:
      case Kind::kOr:
      case Kind::kExists: break;
    }
    return first_unmet(alternatives_of(condition.parts), reach.combinations).value_or(UnmetCondition{});
  }

  UnmetCondition describe_pattern(const Pattern& pattern, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const std::vector<const FactCopy*> facts = matcher_.facts().of(pattern);
    unmet.matches_alone = 0;
    for (const FactCopy* fact : facts) {
      Bindings none;
      *unmet.matches_alone += pattern.match(*fact, none, &matcher_.evaluator(), [] { return true; });
    }
    Nearest best;
    const Combination* with = &reach.combinations.front();
    for (const Combination& combination : reach.combinations) {
      Nearest found = nearest(pattern, facts, combination.bindings, &matcher_.evaluator());
      if (best.fact && found.mismatches.size() >= best.mismatches.size()) continue;
      best = std::move(found);
      with = &combination;
    }
    put_values(with->bindings, unmet);
    if (!best.fact) {
      unmet.because = "there is no fact of " + pattern.template_name();
      return unmet;
    }
    unmet.fact = best.fact->print();
    if (*unmet.matches_alone > 0)
      unmet.because = std::to_string(*unmet.matches_alone) +
                      " facts match it alone, none of them together with the conditions before; in the nearest ";
    else
      unmet.because = "in the nearest fact ";
    if (best.mismatches.empty()) {
      unmet.because = "a test of the pattern fails for every fact";
      return unmet;
    }
    unmet.because += best.mismatches.front().print();
    unmet.slot = best.mismatches.front().slot;
    return unmet;
  }

  UnmetCondition describe_test(const Term& expression, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const Combination& combination = reach.combinations.back();
    put_values(combination.bindings, unmet);
    const auto value = matcher_.evaluator().value(expression, combination.bindings);
    unmet.because = reach.count == 1 ? "the test fails for what the conditions before it match"
                                     : "the test fails for each of the " + std::to_string(reach.count) +
                                           " combinations that the conditions before it match";
    if (!value) unmet.because += "; it raises an error: " + value.error().message;
    return unmet;
  }

  UnmetCondition describe_not(const Condition& condition, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const Combination& begun = reach.combinations.back();
    put_values(begun.bindings, unmet);
    unmet.because = "what it forbids holds";
    Matcher::Conditions parts;
    for (const Condition& part : condition.parts) parts.push_back(&part);
    matcher_.satisfy(parts, begun, [&](const Combination& forbidden) {
      const std::size_t facts = forbidden.facts.size() - begun.facts.size();
      if (facts > 0) unmet.fact = print(forbidden, begun.facts.size());
      if (facts > 0) unmet.because = facts == 1 ? "a fact forbids it" : "facts that hold together forbid it";
      return true;
    });
    return unmet;
  }

  UnmetCondition describe_forall(const Condition& condition, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    Matcher::Conditions rest;
    for (const Condition& part : condition.parts) rest.push_back(&part);
    rest.erase(rest.begin());
    const Combination& begun = reach.combinations.back();
    matcher_.satisfy({&condition.parts.front()}, begun, [&](const Combination& each) {
      if (matcher_.satisfiable(rest, each)) return false;
      put_values(each.bindings, unmet);
      unmet.fact = print(each, begun.facts.size());
      const auto missing = first_unmet(alternatives_of({condition.parts.begin() + 1, condition.parts.end()}), {each});
      unmet.because = "not for this fact: " + (missing ? missing->text + ", " + missing->because : std::string());
      return true;
    });
    return unmet;
  }

  Matcher& matcher_;
};

bool has_objects(const std::vector<Condition>& conditions) {
  return std::any_of(conditions.begin(), conditions.end(), [](const Condition& condition) {
    return condition.kind == Kind::kPattern ? condition.pattern.is_object() : has_objects(condition.parts);
  });
}

/// What the counts of CLIPS say, where the conditions cannot be looked at one by one.
std::optional<UnmetCondition> from_counts(const RuleEngine& engine, const ConstructInfo& rule, std::string because) {
  const auto matches = engine.matches(rule.module + "::" + rule.name);
  if (!matches || matches->empty()) return std::nullopt;
  UnmetCondition unmet;
  for (const RuleMatches& alternative : *matches) {
    const auto& patterns = alternative.patterns;
    const auto first = std::find_if(patterns.begin(), patterns.end(), [](const auto& p) { return p.partial == 0; });
    if (first == patterns.end()) return std::nullopt;
    if (first->condition <= unmet.number) continue;
    unmet.number = first->condition;
    unmet.matches_alone = static_cast<std::size_t>(first->matches);
  }
  unmet.because = std::move(because);
  return unmet;
}

}  // namespace

std::string UnmetCondition::print() const {
  return (text.empty() ? "" : text + ": ") + because + (fact ? ": " + *fact : "");
}

std::string_view to_string(Verdict verdict) {
  static constexpr std::string_view kWords[] = {"waiting", "fired", "taken", "condition"};
  return kWords[static_cast<std::size_t>(verdict)];
}

std::optional<UnmetCondition> unmet_condition(RuleEngine& engine, const ConstructInfo& rule) {
  const auto conditions = conditions_of(rule.text, rule.file, rule.line);
  if (!conditions) return from_counts(engine, rule, conditions.error().message);
  if (has_objects(*conditions)) return from_counts(engine, rule, "no instance or fact is left for it");
  const Facts facts(engine);
  Evaluator evaluator(engine, rule.module);
  Matcher matcher(facts, evaluator);
  auto unmet = Explainer(matcher).first_unmet(alternatives_of(*conditions), {Combination{}});
  if (matcher.exhausted()) return from_counts(engine, rule, "there are too many combinations to look at each");
  return unmet;
}

Expected<WhyNot> why_not(RuleEngine& engine, const std::string& rule, const History& history) {
  const ConstructInfo* found = engine.find_construct("defrule", rule);
  const std::size_t colons = rule.find("::");
  if (!found || (colons != rule.npos && found->module != rule.substr(0, colons)))
    return input_error("there is no rule '" + rule + "'");
  const ConstructInfo info = *found;
  WhyNot answer;
  answer.rule = info.name;
  answer.module = info.module;
  answer.file = info.file;
  answer.line = info.line;
  for (const Firing& firing : history.firings()) {
    if (firing.rule != info.name) continue;
    ++answer.fired;
    answer.last_fired = firing.t;
  }
  for (const FactCopy& fact : history.last_facts()) answer.last_facts.push_back(fact.print());

  const std::vector<ActivationInfo> agenda = engine.agenda();
  const auto own = std::find_if(agenda.begin(), agenda.end(), [&](const ActivationInfo& a) {
    return a.rule == info.name && a.module == info.module;
  });
  if (own != agenda.end()) {
    constexpr std::ptrdiff_t kShown = 5;
    answer.verdict = Verdict::kWaiting;
    answer.salience = own->salience;
    answer.above = static_cast<std::size_t>(own - agenda.begin());
    for (auto it = agenda.begin(); it != own && it - agenda.begin() < kShown; ++it)
      answer.first_above.emplace_back(it->rule, it->salience);
    return answer;
  }
  answer.unmet = unmet_condition(engine, info);
  answer.verdict = answer.unmet ? Verdict::kCondition : answer.fired > 0 ? Verdict::kFired : Verdict::kTaken;
  return answer;
}

nlohmann::ordered_json to_json(const WhyNot& answer) {
  using Json = nlohmann::ordered_json;
  Json out{{"rule", answer.rule}, {"file", answer.file}, {"line", answer.line}, {"fired", answer.fired}};
  if (answer.fired > 0) {
    out["last_fired_s"] = to_seconds(answer.last_fired);
    out["last_facts"] = answer.last_facts;
  }
  out["verdict"] = to_string(answer.verdict);
  if (answer.verdict == Verdict::kWaiting) {
    Json& agenda = out["agenda"] = {{"above", answer.above}, {"first_above", Json::array()}};
    for (const auto& [rule, salience] : answer.first_above)
      agenda["first_above"].push_back({{"rule", rule}, {"salience", salience}});
    agenda["salience"] = answer.salience;
  }
  if (!answer.unmet) return out;
  const UnmetCondition& unmet = *answer.unmet;
  Json& json = out["first_unmet"] = {{"condition", unmet.number}};
  if (unmet.matches_alone) json["matches_alone"] = *unmet.matches_alone;
  if (!unmet.text.empty()) json["pattern"] = unmet.text;
  json["because"] = unmet.because;
  if (unmet.fact) json["fact"] = *unmet.fact;
  if (!unmet.slot.empty()) json["slot"] = unmet.slot;
  if (!unmet.values.empty()) {
    Json& values = json["values"] = Json::object();
    for (const auto& [name, value] : unmet.values) values[name] = value;
  }
  return out;
}

}  // namespace cxlab::explain
