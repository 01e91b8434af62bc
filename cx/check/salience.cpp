// Rules that only their salience keeps apart.

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>

#include "cx/base/number_text.h"
#include "cx/check/effects.h"
#include "cx/check/judge.h"
#include "cx/check/patterns.h"

namespace cxlab::check {

namespace {

constexpr int kExtreme = 500;       // a salience that is to beat all others
constexpr int kMostPairs = 300000;  // of rules that are compared; beyond, nothing is reported

struct Ranked {
  struct Condition {
    std::string text;
    std::optional<PatternSlots> pattern;
  };
  /// A fact of a condition that the rule takes away, or changes.
  struct Taken {
    std::size_t condition = 0;
    const Term* action = nullptr;  ///< retract or modify
  };
  const Construct* rule = nullptr;
  std::vector<Condition> conditions;
  std::vector<Taken> taken;
  const Term* declared = nullptr;
  int salience = 0;
};

/// What the values of a condition are called in another that it is compared with.
using Names = std::map<std::string, std::string>;

/// Whether a fact that matches `given` matches `wanted`, whose variables are then called as `names` says.
bool holds_for(const Ranked::Condition& wanted, const Ranked::Condition& given, Names& names) {
  if (!wanted.pattern || !given.pattern) return wanted.text == given.text;
  if (!wanted.pattern->wider_than(*given.pattern)) return false;
  for (const auto& [slot, constraint] : wanted.pattern->slots) {
    if (constraint.variable.empty()) continue;
    const auto other = given.pattern->slots.find(slot);
    const std::string name =
        other == given.pattern->slots.end() ? slot : other->second.variable + ' ' + other->second.text;
    if (names.emplace(constraint.variable, name).first->second.substr(0, name.find(' ')) !=
        name.substr(0, name.find(' ')))
      return false;
  }
  return true;
}

/// Every condition of `low` also holds where those of `high` do.
bool holds_wherever(const Ranked& low, const Ranked& high) {
  Names names;
  return std::ranges::all_of(low.conditions, [&](const Ranked::Condition& condition) {
    const bool always = condition.pattern && condition.pattern->name == "time" &&  // the executive's
                        std::ranges::all_of(condition.pattern->slots,
                                            [](const auto& slot) { return slot.first == "#" || slot.second.any(); });
    return always || std::ranges::any_of(high.conditions, [&](const Ranked::Condition& other) {
             Names then = names;
             if (!holds_for(condition, other, then)) return false;
             names = std::move(then);
             return true;
           });
  });
}

/// `low` does not fire any more for a fact that `high` has taken.
bool ends(const Ranked& low, const Ranked& high, const Ranked::Taken& taken) {
  const auto& given = high.conditions[taken.condition].pattern;
  return std::ranges::any_of(low.conditions, [&](const Ranked::Condition& condition) {
    if (!given || !condition.pattern || !condition.pattern->wider_than(*given)) return false;
    if (taken.action->head() == "retract") return true;
    return std::ranges::any_of(values_of(*taken.action, 2), [&](const auto& value) {
      const auto constraint = condition.pattern->slots.find(value.first);
      const auto& items = value.second;
      return constraint != condition.pattern->slots.end() && items.size() == 1 && !items[0].is_list() &&
             !is_variable(items[0]) && constraint->second.plain && !constraint->second.admits(items[0].print());
    });
  });
}

std::optional<Ranked> ranked(const Construct& rule, const Effects& effects) {
  const RuleParts parts = parts_of(rule);
  Ranked out{&rule, {}, {}, parts.salience, 0};
  if (parts.salience) {
    const auto number = read_number<int>(parts.salience->text);
    if (!number) return std::nullopt;
    out.salience = *number;
  }
  std::map<std::string, std::size_t> facts;
  for (const RuleParts::Condition& condition : parts.conditions) {
    if (!condition.fact.empty()) facts[condition.fact] = out.conditions.size();
    out.conditions.push_back({condition.term->print(), slots_of(*condition.term)});
  }
  const auto take = [&](const Term& fact, const Term* action) {
    if (const auto found = facts.find(variable_name(fact)); found != facts.end())
      out.taken.push_back({found->second, action});
  };
  for (const Term* action : parts.actions) {
    const std::string head(action->head());
    for (std::size_t i = 1; i < action->items.size() && (head == "retract" || (head == "modify" && i == 1)); ++i)
      take(action->items[i], action);
    for (const auto& [parameter, taker] : effects.takes(head))
      if (parameter + 1 < action->items.size()) take(action->items[parameter + 1], taker);
  }
  return out;
}

}  // namespace

void judge_salience(const RuleBase& base, Findings& findings) {
  const Effects effects(base);
  std::vector<Ranked> rules;
  std::map<std::string, std::vector<std::size_t>> readers;  // by template
  for (const Construct& construct : base.constructs()) {
    if (!construct.is_rule() || !construct.place.source->loaded) continue;
    auto rule = ranked(construct, effects);
    if (!rule) continue;
    std::set<std::string> names;
    for (const Ranked::Condition& condition : rule->conditions)
      if (condition.pattern) names.insert(condition.pattern->name);
    for (const std::string& name : names) readers[name].push_back(rules.size());
    rules.push_back(*std::move(rule));
  }
  int pairs = 0;
  std::map<std::size_t, std::set<std::string>> before, behind;  // by the rule that declares: the other ones
  for (std::size_t h = 0; h < rules.size(); ++h)
    for (const Ranked::Taken& taken : rules[h].taken) {
      const Ranked& high = rules[h];
      if (!high.conditions[taken.condition].pattern) continue;
      for (const std::size_t l : readers[high.conditions[taken.condition].pattern->name]) {
        const Ranked& low = rules[l];
        if (low.salience >= high.salience || low.rule->module != high.rule->module || ++pairs > kMostPairs) continue;
        if (!ends(low, high, taken) || !holds_wherever(low, high)) continue;
        (low.salience != 0 ? behind[l] : before[h]).insert('\'' + (low.salience != 0 ? high : low).rule->name + '\'');
      }
    }
  for (const Ranked& rule : rules) {
    const std::size_t number = static_cast<std::size_t>(&rule - rules.data());
    if (std::abs(rule.salience) < kExtreme || before.contains(number) || behind.contains(number)) continue;
    add(findings, {rule.rule->place.source, rule.declared->line}, "salience",
        "salience " + std::to_string(rule.salience) + " puts rule '" + rule.rule->name +
            (rule.salience > 0 ? "' before" : "' behind") +
            " all others, whatever they are for; say in its conditions what it waits for");
  }
  const auto tell = [&](const auto& all, const auto& text) {
    for (const auto& [declares, others] : all) {
      const Ranked& rule = rules[declares];
      const std::string names = (others.size() == 1 ? "rule " : "rules ") + some_of({others.begin(), others.end()}, 3);
      add(findings, {rule.rule->place.source, rule.declared->line}, "salience",
          text('\'' + rule.rule->name + '\'', names));
    }
  };
  constexpr std::string_view kRemedy = "; say in its conditions what tells it apart";
  tell(behind, [&](const std::string& low, const std::string& names) {
    return "rule " + low + " also matches the facts that " + names + " take" + (names.starts_with("rules") ? "" : "s") +
           ": only its salience makes it wait" + std::string(kRemedy);
  });
  tell(before, [&](const std::string& high, const std::string& names) {
    return "rule " + high + " takes facts that " + names + " also match" + (names.starts_with("rules") ? "" : "es") +
           ": only its salience lets it come first; say in the conditions of the other what tells them apart";
  });
}

}  // namespace cxlab::check
