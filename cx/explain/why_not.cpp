#include "cx/explain/why_not.h"
#include "cx/base/json.h"

#include <algorithm>

#include "cx/explain/json.h"
#include "cx/explain/matcher.h"

namespace cxlab::explain {

namespace {

using Kind = Condition::Kind;

constexpr std::size_t kMostOthers = 3;  // of an `or` that does not hold

std::string print(const Combination& combination, std::size_t from) {
  std::string out;
  for (std::size_t i = from; i < combination.facts.size(); ++i)
    out += (out.empty() ? "" : " ") + combination.facts[i]->print();
  return out;
}

Values values_of(const Bindings& bindings) {
  Values values;
  for (const auto& [name, value] : bindings) values.emplace_back(name, value.print());
  return values;
}

/// How many facts match a pattern whatever the conditions before it match.
std::size_t matching_alone(const Pattern& pattern, Matcher& matcher) {
  std::size_t count = 0;
  for (const FactCopy* fact : matcher.facts().of(pattern)) {
    Bindings none;
    count += pattern.match(*fact, none, &matcher.evaluator(), [] { return true; });
  }
  return count;
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
    std::vector<std::pair<std::pair<int, std::size_t>, const std::string*>> failed;  // where, and what
    // An alternative gets further if it satisfies more conditions of the rule, then if it satisfies more parts of one.
    const auto place = [](const Alternative& alternative, std::size_t depth) {
      return std::pair(alternative.numbers[depth], depth);
    };
    for (const Alternative& alternative : alternatives)
      for (const Combination& start : begun) {
        Matcher::Reach reach = matcher_.reach(alternative.conditions, start);
        if (reach.depth == alternative.conditions.size()) return std::nullopt;
        failed.emplace_back(place(alternative, reach.depth), &alternative.conditions[reach.depth]->text);
        if (best && place(alternative, reach.depth) <= place(*best, furthest.depth)) continue;
        best = &alternative;
        furthest = std::move(reach);
      }
    if (!best) return UnmetCondition{};
    UnmetCondition unmet = describe(*best->conditions[furthest.depth], furthest);
    unmet.number = best->numbers[furthest.depth];
    unmet.text = best->conditions[furthest.depth]->text;
    std::vector<std::string> others;  // the rest of an `or` of which no part holds: the way may go on there
    for (const auto& [where, text] : failed)
      if (where == place(*best, furthest.depth) && *text != unmet.text &&
          std::ranges::find(others, *text) == others.end())
        others.push_back(*text);
    if (!others.empty())
      unmet.because.insert(0, "nor " +
                                  std::string(others.size() == 1 ? "does its alternative" : "do its alternatives") +
                                  " hold: " + some_of(others, kMostOthers) + "; ");
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
    return first_unmet_inside(condition.parts, reach.combinations).value_or(UnmetCondition{});
  }

  std::optional<UnmetCondition> first_unmet_inside(const std::vector<Condition>& parts,
                                                   std::vector<Combination> begun) {
    for (Combination& combination : begun) combination = inside(std::move(combination));
    return first_unmet(alternatives_of(parts), begun);
  }

  UnmetCondition describe_pattern(const Pattern& pattern, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const std::vector<const FactCopy*> facts = matcher_.facts().of(pattern);
    unmet.matches_alone = matching_alone(pattern, matcher_);
    Nearest best;
    const Combination* with = &reach.combinations.front();
    for (const Combination& combination : reach.combinations) {
      Nearest found = nearest(pattern, facts, combination.bindings, &matcher_.evaluator());
      if (best.fact && found.mismatches.size() >= best.mismatches.size()) continue;
      best = std::move(found);
      with = &combination;
    }
    unmet.values = values_of(with->bindings);
    const std::string noun = pattern.is_object() ? "instance" : "fact";
    if (!best.fact) {
      unmet.none_there = true;
      unmet.because = "there is no " + noun + (pattern.is_object() ? "" : " of " + pattern.template_name());
      return unmet;
    }
    unmet.fact = best.fact->print();
    unmet.fact_number = best.fact->number;
    const std::size_t alone = *unmet.matches_alone;
    if (alone > 0) {
      unmet.because = alone == 1 ? "one " + noun + " matches it alone, but not "
                                 : std::to_string(alone) + ' ' + noun + "s match it alone, none of them ";
      unmet.because += with->bindings.size() > 0 ? "together with the conditions before; " : "with what is asked for; ";
    }
    unmet.because += "in the nearest " + noun + ' ';
    if (best.mismatches.empty()) {
      unmet.because = "no " + noun + " matches it as a whole";
      return unmet;
    }
    unmet.because += explain::print(best.mismatches);
    unmet.slot = best.mismatches.front().slot;
    return unmet;
  }

  UnmetCondition describe_test(const Term& expression, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const Combination& combination = reach.combinations.back();
    unmet.values = values_of(combination.bindings);
    const auto value = matcher_.evaluator().value(expression, combination.bindings);
    for (const std::string& name : globals_of(expression))
      if (const auto global = matcher_.evaluator().global(name)) unmet.values.emplace_back(name, global->print());
    unmet.because = reach.count == 1 ? "the test fails for what the conditions before it match"
                                     : "the test fails for each of the " + std::to_string(reach.count) +
                                           " combinations that the conditions before it match";
    if (!value) unmet.because += "; it raises an error: " + value.error().message;
    return unmet;
  }

  UnmetCondition describe_not(const Condition& condition, const Matcher::Reach& reach) {
    // A not of a not is an exists.
    if (condition.parts.size() == 1 && condition.parts.front().kind == Kind::kNot)
      return first_unmet_inside(condition.parts.front().parts, reach.combinations).value_or(UnmetCondition{});
    UnmetCondition unmet;
    const Combination begun = inside(reach.combinations.back());
    unmet.values = values_of(begun.bindings);
    unmet.because = "what it forbids holds";
    matcher_.satisfy(with_facts(condition.parts), begun, [&](const Combination& forbidden) {
      const std::size_t facts = forbidden.facts.size() - begun.facts.size();
      if (facts > 0) unmet.fact = print(forbidden, begun.facts.size());
      if (facts == 1) unmet.fact_number = forbidden.facts.back()->number;
      if (facts > 0) unmet.because = facts == 1 ? "a fact forbids it" : "facts that hold together forbid it";
      return true;
    });
    return unmet;
  }

  UnmetCondition describe_forall(const Condition& condition, const Matcher::Reach& reach) {
    UnmetCondition unmet;
    const std::vector<Condition> rest(condition.parts.begin() + 1, condition.parts.end());
    const Combination begun = inside(reach.combinations.back());
    matcher_.satisfy({&condition.parts.front()}, begun, [&](const Combination& each) {
      const auto missing = first_unmet(alternatives_of(rest), {each});
      if (!missing) return false;
      unmet.values = values_of(each.bindings);
      if (each.facts.size() > begun.facts.size()) unmet.fact = print(each, begun.facts.size());
      unmet.because = "each match of " + condition.parts.front().text + " needs " + missing->text +
                      ", and this one lacks it: " + missing->because;
      return true;
    });
    return unmet;
  }

  /// The conditions that hold when these do, with those of each `exists` among them: to have its facts, too.
  static Matcher::Conditions with_facts(const std::vector<Condition>& conditions) {
    Matcher::Conditions out;
    for (const Condition& condition : conditions) {
      if (condition.kind != Kind::kExists) {
        out.push_back(&condition);
        continue;
      }
      const Matcher::Conditions parts = with_facts(condition.parts);
      out.insert(out.end(), parts.begin(), parts.end());
    }
    return out;
  }

  Matcher& matcher_;
};

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
  static constexpr std::string_view kWords[] = {"waiting", "focus", "fired", "taken", "condition"};
  return kWords[static_cast<std::size_t>(verdict)];
}

namespace {

/// What the facts make of a left-hand side.
struct Look {
  std::optional<UnmetCondition> unmet;
  std::size_t alternatives = 1;
  std::vector<FactCopy> facts;
  struct Satisfying {
    Values values;
    std::vector<std::string> facts;
    std::vector<std::int64_t> indices, numbers;  // of the facts; instances have none
  };
  std::vector<Satisfying> combinations;  // at most Matcher::kKept for each alternative
  std::size_t count = 0;
};

Look::Satisfying satisfying(const Combination& combination) {
  Look::Satisfying out;
  out.values = values_of(combination.bindings);
  for (const FactCopy* fact : combination.facts) {
    out.facts.push_back(fact->print());
    if (!fact->classes.empty()) continue;
    out.indices.push_back(fact->index);
    out.numbers.push_back(static_cast<std::int64_t>(fact->number));
  }
  return out;
}

/// Leaves the alternatives that bind all that is wanted.
Status keep_those_that_bind(const Wanted& wanted, const ConstructInfo& rule, std::vector<Alternative>& alternatives) {
  std::vector<std::string> all;
  for (const auto& [name, text] : wanted) {
    for (const Alternative& alternative : alternatives)
      for (const Condition* condition : alternative.conditions)
        if (condition->fact_variable == name && condition->kind == Kind::kPattern && !condition->pattern.is_object() &&
            !text.starts_with("f-")) {
          std::string values;
          for (const std::string& bound : condition->pattern.binds()) values += (values.empty() ? "?" : ", ?") + bound;
          return input_error("?" + name + " of rule '" + rule.name + "' is a fact, as in " + name + "=f-1" +
                             (values.empty() ? std::string("; its pattern binds none")
                                             : "; ask for a value that its pattern binds: " + values));
        }
    std::erase_if(alternatives, [&, &name = name](const Alternative& alternative) {
      const std::vector<std::string> bound = alternative.binds();
      all.insert(all.end(), bound.begin(), bound.end());
      return std::find(bound.begin(), bound.end(), name) == bound.end();
    });
    if (alternatives.empty())
      return input_error("no pattern of rule '" + rule.name + "' outside of not, exists and forall binds ?" + name +
                         did_you_mean(name, all));
  }
  return {};
}

Expected<Look> look(RuleEngine& engine, const ConstructInfo& rule, const Wanted& wanted) {
  Look out;
  const auto conditions = conditions_of(rule.text, rule.file, rule.line);
  if (!conditions) {
    out.unmet = from_counts(engine, rule, conditions.error().message);
    return out;
  }
  std::vector<Alternative> alternatives = alternatives_of(*conditions);
  if (Status s = keep_those_that_bind(wanted, rule, alternatives); !s) return s.error();
  out.alternatives = alternatives.size();
  const Facts facts(engine, rule.module);
  Evaluator evaluator(engine, rule.module);
  Matcher matcher(facts, evaluator);
  const Combination begun{Bindings(&wanted)};
  for (const Alternative& alternative : alternatives) {
    const Matcher::Reach reach = matcher.reach(alternative.conditions, begun);
    if (reach.depth < alternative.conditions.size()) continue;
    out.count += reach.count;
    for (const Combination& combination : reach.combinations) out.combinations.push_back(satisfying(combination));
  }
  if (out.count == 0) out.unmet = Explainer(matcher).first_unmet(alternatives, {begun});
  if (matcher.exhausted()) out.unmet = from_counts(engine, rule, "there are too many combinations to look at each");
  if (out.unmet) out.unmet->module = rule.module;
  return out;
}

/// Puts the activations of modules above the rule's into the answer, and those of its own module before `own`.
void put_agenda(const RuleEngine& engine, const std::vector<ActivationInfo>& agenda, const ActivationInfo& own,
                WhyNot& answer) {
  constexpr std::size_t kShown = 5;
  answer.salience = own.salience;
  answer.focus = engine.focus();
  if (answer.focus.empty()) answer.focus = {"MAIN"};
  const auto focus = std::find(answer.focus.begin(), answer.focus.end(), own.module);
  answer.verdict = focus == answer.focus.end() ? Verdict::kFocus : Verdict::kWaiting;
  const auto add = [&](const ActivationInfo& activation) {
    if (++answer.above > kShown) return;
    const std::string module = activation.module == "MAIN" ? "" : activation.module + "::";
    answer.first_above.emplace_back(module + activation.rule, activation.salience);
  };
  for (auto module = answer.focus.begin(); module != focus; ++module)
    for (const ActivationInfo& activation : agenda)
      if (activation.module == *module) add(activation);
  if (focus == answer.focus.end()) return;
  for (const ActivationInfo& activation : agenda) {
    if (&activation == &own) break;
    if (activation.module == own.module) add(activation);
  }
}

void put_combination(const Look::Satisfying& combination, WhyNot& answer) {
  answer.facts = combination.facts;
  answer.values = combination.values;
}

/// Whether the rule has fired for a combination that holds; the last such.
bool put_fired(const Look& found, const ConstructInfo& rule, const History& history, WhyNot& answer) {
  const Firing* last = nullptr;
  for (const Look::Satisfying& combination : found.combinations) {
    const Firing* fired = history.fired_for(rule.module, combination.numbers);
    if (!fired || (last && fired->n <= last->n)) continue;
    last = fired;
    put_combination(combination, answer);
  }
  if (last) answer.fired_for_it = last->t;
  return last != nullptr;
}

}  // namespace

std::optional<UnmetCondition> unmet_condition(RuleEngine& engine, ConstructInfo rule, const Wanted& wanted) {
  const Expected<Look> found = look(engine, rule, wanted);
  return found ? found->unmet : std::nullopt;
}

Expected<std::vector<ConditionNow>> conditions_now(RuleEngine& engine, ConstructInfo rule) {
  const auto conditions = conditions_of(rule.text, rule.file, rule.line);
  if (!conditions) return conditions.error();
  const Facts facts(engine, rule.module);
  Evaluator evaluator(engine, rule.module);
  Matcher matcher(facts, evaluator);
  const int after_last = static_cast<int>(conditions->size()) + 1;
  int fails = 0;  // the furthest of the first ones that do not hold, of all alternatives
  for (const Alternative& alternative : alternatives_of(*conditions)) {
    const std::size_t depth = matcher.reach(alternative.conditions, {}).depth;
    fails = std::max(fails, depth < alternative.numbers.size() ? alternative.numbers[depth] : after_last);
  }
  const auto line_at = [&](std::size_t character) {
    const auto begin = rule.text.begin();
    return rule.line + static_cast<int>(std::count(begin, begin + static_cast<std::ptrdiff_t>(character), '\n'));
  };
  std::vector<ConditionNow> out;
  for (const Condition& condition : *conditions) {
    ConditionNow now{
        static_cast<int>(out.size()) + 1, condition.text, line_at(condition.begin), line_at(condition.end), {}, {}};
    if (now.number <= fails && !matcher.exhausted()) now.holds = now.number < fails;
    if (condition.kind == Kind::kPattern) now.matches_alone = matching_alone(condition.pattern, matcher);
    out.push_back(std::move(now));
  }
  return out;
}

Expected<WhyNot> why_not(RuleEngine& engine, ConstructInfo rule, const History& history, const Wanted& wanted) {
  WhyNot answer;
  answer.rule = rule.name;
  answer.module = rule.module;
  answer.file = rule.file;
  answer.line = rule.line;
  for (const Firing& firing : history.firings()) {
    if (!firing.is_of(rule.module + "::" + rule.name)) continue;
    ++answer.fired;
    answer.last_fired = firing.t;
  }
  for (const FactCopy& fact : history.last_facts(rule.module)) answer.last_facts.push_back(fact.print());

  Expected<Look> found = look(engine, rule, wanted);
  if (!found) return found.error();
  answer.combinations = found->count;
  answer.alternatives = found->alternatives;
  const std::vector<ActivationInfo> agenda = engine.agenda();
  for (const ActivationInfo& activation : agenda) {
    if (activation.rule != rule.name || activation.module != rule.module) continue;
    std::vector<std::int64_t> indices = activation.facts;
    std::erase(indices, -1);
    const auto combination = std::find_if(found->combinations.begin(), found->combinations.end(),
                                          [&](const Look::Satisfying& c) { return c.indices == indices; });
    if (combination == found->combinations.end() && !wanted.empty()) continue;
    if (combination != found->combinations.end()) put_combination(*combination, answer);
    put_agenda(engine, agenda, activation, answer);
    return answer;
  }
  answer.unmet = std::move(found->unmet);
  if (answer.unmet) {
    answer.verdict = Verdict::kCondition;
  } else if (put_fired(*found, rule, history, answer)) {
    answer.verdict = Verdict::kFired;
  } else {
    answer.verdict = Verdict::kTaken;
    if (!found->combinations.empty()) put_combination(found->combinations.front(), answer);
  }
  return answer;
}

Json to_json(const WhyNot& answer) {
  const auto object = [](const Values& values) {
    Json out = Json::object();
    for (const auto& [name, value] : values) out[name] = value;
    return out;
  };
  Json out{{"rule", answer.rule},
           {"module", answer.module},
           {"file", answer.file},
           {"line", answer.line},
           {"fired", answer.fired}};
  if (answer.fired > 0) {
    out["last_fired_s"] = to_seconds(answer.last_fired);
    out["last_facts"] = answer.last_facts;
  }
  if (answer.lost)
    out["lost"] = {{"t_s", to_seconds(answer.lost->t)}, {"facts", answer.lost->facts}, {"by", answer.lost->by}};
  out["verdict"] = to_string(answer.verdict);
  if (answer.verdict == Verdict::kWaiting || answer.verdict == Verdict::kFocus) {
    Json& agenda = out["agenda"] = {{"above", answer.above}, {"first_above", Json::array()}};
    for (const auto& [rule, salience] : answer.first_above)
      agenda["first_above"].push_back({{"rule", rule}, {"salience", salience}});
    agenda["salience"] = answer.salience;
    agenda["focus"] = answer.focus;
  }
  if (!answer.unmet) {
    Json& holds = out["holds"] = {{"combinations", answer.combinations}, {"facts", answer.facts}};
    if (!answer.values.empty()) holds["values"] = object(answer.values);
    if (answer.fired_for_it) holds["fired_s"] = to_seconds(*answer.fired_for_it);
    return out;
  }
  const UnmetCondition& unmet = *answer.unmet;
  Json& json = out["first_unmet"] = {{"condition", unmet.number}};
  if (answer.alternatives > 1) json["alternatives"] = answer.alternatives;
  if (unmet.matches_alone) json["matches_alone"] = *unmet.matches_alone;
  if (!unmet.text.empty()) json["pattern"] = unmet.text;
  json["because"] = unmet.because;
  if (unmet.fact) json["fact"] = *unmet.fact;
  if (!unmet.slot.empty()) json["slot"] = unmet.slot;
  if (!unmet.values.empty()) json["values"] = object(unmet.values);
  return out;
}

}  // namespace cxlab::explain
