// Rules that make each other fire without an end, and rules that only their salience keeps apart. A loop is told only
// where each step is certain: actions outside of `if` and loops, and conditions that the steps leave alone.

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "cx/base/number_text.h"
#include "cx/check/judge.h"
#include "cx/check/patterns.h"

namespace cxlab::check {

namespace {

/// The fact that a firing leaves: a slot is as the condition says, or has a new value.
struct NewFact {
  std::string name;
  std::map<std::string, std::string> constants;  ///< slots that are set to a constant
  std::set<std::string> grows;                   ///< slots whose value differs from all before
  std::set<std::string> unknown;                 ///< slots of which nothing is known
  bool keeps_others = false;                     ///< a modify: the other slots are as they were
  bool fresh = false;                            ///< it is always a new fact, or a changed one
  const Term* trigger = nullptr;                 ///< the condition whose fact it comes from
};

/// Whether an expression gives another value each time, made from that variable: (+ ?n 1).
bool grows_from(const Term& value, const std::string& variable) {
  if (!is_any(value.head(), {"+", "-", "str-cat", "sym-cat"}) || value.items.size() != 3 || variable.empty()) return false;
  const Term &left = value.items[1], &right = value.items[2];
  const Term& other = variable_name(left) == variable ? right : left;
  if (variable_name(left) != variable && variable_name(right) != variable) return false;
  if (value.head() == "-" && variable_name(left) != variable) return false;
  if (other.is_list() || is_variable(other)) return false;
  if (value.head() == "+" || value.head() == "-") {
    const auto number = read_number<double>(other.text);
    return number && *number != 0;
  }
  return other.text != "\"\"";
}

/// A rule whose actions are certain.
struct Certain {
  const Construct* rule = nullptr;
  RuleParts parts;
  std::vector<NewFact> facts;
};

class CertainReader {
 public:
  std::optional<Certain> read(const Construct& rule) {
    Certain certain{&rule, parts_of(rule), {}};
    conditions_.clear();
    for (const RuleParts::Condition& condition : certain.parts.conditions)
      if (!condition.fact.empty()) conditions_[condition.fact] = condition.term;
    std::set<std::string> retracted;
    std::vector<const Term*> asserted_before, asserted;
    for (const Term* action : certain.parts.actions) {
      const std::string_view head = action->head();
      if (head == "retract") {
        for (const Term& fact : action->items) retracted.insert(variable_name(fact));
      } else if (head == "assert") {
        for (std::size_t i = 1; i < action->items.size(); ++i) asserted.push_back(&action->items[i]);
        if (retracted.empty()) asserted_before = asserted;
      } else if (head == "modify" && action->items.size() > 2) {
        const auto condition = conditions_.find(variable_name(action->items[1]));
        if (condition == conditions_.end()) return std::nullopt;
        if (auto fact = modified(*action, *condition->second)) certain.facts.push_back(*std::move(fact));
      } else if (!is_any(head, {"printout", "println", "print"})) {
        return std::nullopt;
      }
    }
    retracted.erase("");
    for (const std::string& name : retracted)
      if (!conditions_.contains(name)) return std::nullopt;
    for (const RuleParts::Condition& condition : certain.parts.conditions) {
      const bool goes = retracted.contains(condition.fact) && !condition.fact.empty();
      for (const Term* fact : asserted) {
        const bool before = std::ranges::count(asserted_before, fact) > 0;
        if (auto made = made_from(*fact, *condition.term, goes && !before)) certain.facts.push_back(*std::move(made));
      }
    }
    // Retracting what others than the trigger stand for ends the loop.
    if (retracted.size() > 1) return std::nullopt;
    if (!retracted.empty())
      std::erase_if(certain.facts, [&](const NewFact& f) { return f.trigger != conditions_.at(*retracted.begin()); });
    return certain;
  }

 private:
  static void take(const std::map<std::string, std::span<const Term>>& values, const PatternSlots& pattern, bool same,
                   NewFact& fact) {
    for (const auto& [slot, items] : values) {
      const auto constraint = pattern.slots.find(slot);
      const std::string variable =
          same && constraint != pattern.slots.end() ? constraint->second.variable : std::string();
      if (items.size() != 1) {
        fact.unknown.insert(slot);
      } else if (grows_from(items[0], variable)) {
        fact.grows.insert(slot);
      } else if (!items[0].is_list() && !is_variable(items[0])) {
        fact.constants[slot] = items[0].print();
      } else {
        fact.unknown.insert(slot);
      }
    }
  }

  static std::optional<NewFact> modified(const Term& action, const Term& condition) {
    const auto pattern = slots_of(condition);
    if (!pattern) return std::nullopt;
    NewFact fact{pattern->name, {}, {}, {}, true, false, &condition};
    take(values_of(action, 2), *pattern, true, fact);
    // CLIPS looks again only at conditions that name a slot which has changed.
    for (const std::string& slot : fact.grows) fact.fresh = fact.fresh || pattern->slots.contains(slot);
    for (const auto& [slot, value] : fact.constants)
      if (const auto known = pattern->slots.find(slot); known != pattern->slots.end())
        fact.fresh = fact.fresh || (known->second.plain && !known->second.one_of.empty() && !known->second.admits(value));
    return fact;
  }

  static std::optional<NewFact> made_from(const Term& asserted, const Term& condition, bool goes) {
    const auto pattern = slots_of(condition);
    if (!pattern || asserted.head().empty()) return std::nullopt;
    NewFact fact{std::string(without_module(asserted.head())), {}, {}, {}, false, goes, &condition};
    take(values_of(asserted), *pattern, fact.name == pattern->name, fact);
    std::size_t fields = 0;
    for (std::size_t i = 1; i < asserted.items.size(); ++i) {
      if (asserted.items[i].is_list()) {  // a call among the fields of an ordered fact
        if (!pattern->slots.contains("#") || fact.name != pattern->name) continue;
        const std::string slot = std::to_string(i);
        const auto constraint = pattern->slots.find(slot);
        if (constraint != pattern->slots.end() && grows_from(asserted.items[i], constraint->second.variable))
          fact.grows.insert(slot);
        else
          fact.unknown.insert(slot);
      }
      fields += 1;
    }
    fact.constants["#"] = std::to_string(fields + 1);
    fact.fresh = fact.fresh || !fact.grows.empty();
    return fact;
  }

  std::map<std::string, const Term*> conditions_;
};

class Loops {
 public:
  explicit Loops(const RuleBase& base) : base_(base) {
    CertainReader reader;
    for (const Construct& construct : base.constructs())
      if (construct.is_rule() && construct.place.source->loaded)
        if (auto certain = reader.read(construct)) rules_.push_back(*std::move(certain));
  }

  void judge(Findings& findings) {
    for (const Certain& rule : rules_)
      for (const NewFact& fact : rule.facts)
        if (fact.fresh && fires_again(rule, fact, rule, *fact.trigger) && leaves_alone(rule, *fact.trigger, fact))
          add(findings, rule.rule->place, "loop",
              "rule '" + rule.rule->name + "' makes itself fire again without an end: it changes '" + fact.name +
                  "', and its conditions hold as before; add a condition that ends it");
    for (std::size_t i = 0; i < rules_.size(); ++i)
      for (std::size_t k = i + 1; k < rules_.size(); ++k)
        if (alternate(rules_[i], rules_[k]))
          add(findings, rules_[k].rule->place, "loop",
              "rules '" + rules_[i].rule->name + "' (" + rules_[i].rule->place.text() + ") and '" + rules_[k].rule->name +
                  "' make each other fire without an end; add a condition that ends it");
  }

 private:
  /// Whether `fact`, which a firing of `by` leaves, satisfies that condition of `rule`.
  bool fires_again(const Certain& by, const NewFact& fact, const Certain& rule, const Term& condition) const {
    const auto pattern = slots_of(condition), before = slots_of(*fact.trigger);
    if (!pattern || !before || pattern->name != fact.name) return false;
    if (pattern->slots.contains("#") && !fact.keeps_others &&
        fact.constants.at("#") != *pattern->slots.at("#").one_of.begin())
      return false;
    for (const auto& [slot, constraint] : pattern->slots) {
      if (slot == "#") continue;
      const auto constant = fact.constants.find(slot);
      if (constant != fact.constants.end()) {
        if (!constraint.admits(constant->second) || is_used_elsewhere(rule, condition, constraint.variable)) return false;
      } else if (fact.grows.contains(slot)) {
        if (!constraint.any() || is_used_elsewhere(rule, condition, constraint.variable)) return false;
      } else if (fact.unknown.contains(slot)) {
        if (!constraint.any() || is_used_elsewhere(rule, condition, constraint.variable)) return false;
      } else if (fact.keeps_others) {
        const auto known = before->slots.find(slot);
        if (by.rule != rule.rule && !(known != before->slots.end() ? constraint.wider_than(known->second) : constraint.any()))
          return false;
      } else if (!constraint.any()) {
        return false;
      }
    }
    return true;
  }

  /// Whether a variable of the condition is in another one, or more than once in this one.
  static bool is_used_elsewhere(const Certain& rule, const Term& condition, const std::string& variable) {
    if (variable.empty()) return false;
    for (const RuleParts::Condition& other : rule.parts.conditions)
      if (other.term != &condition && variables_in(*other.term).contains(variable)) return true;
    int count = 0;
    const auto occurrences = [&](const auto& self, const Term& term) -> void {
      count += variable_name(term) == variable;
      for (const Term& item : term.items) self(self, item);
    };
    occurrences(occurrences, condition);
    return count > 1;
  }

  static bool names(const Term& term, const std::string& template_name) {
    if (without_module(term.head()) == template_name) return true;
    return std::ranges::any_of(term.items, [&](const Term& item) { return item.is(template_name) || names(item, template_name); });
  }

  /// The other conditions of a rule do not look at what its firing changes, nor at anything that a call gives.
  bool leaves_alone(const Certain& rule, const Term& trigger, const NewFact& fact) const {
    for (const RuleParts::Condition& condition : rule.parts.conditions) {
      if (condition.term == &trigger) continue;
      if (names(*condition.term, fact.name)) return false;
      for (const Term* action : rule.parts.actions)
        if (action->head() == "assert")
          for (std::size_t i = 1; i < action->items.size(); ++i)
            if (names(*condition.term, std::string(without_module(action->items[i].head())))) return false;
      for (const NewFact& other : rule.facts)
        if (names(*condition.term, other.name)) return false;
      if (calls(*condition.term)) return false;
    }
    return true;
  }
  static bool calls(const Term& condition) {
    return condition.head() == "test" || !slots_of(condition);  // not, or, exists: may depend on anything
  }

  /// Conditions beside the trigger, with variables by one name.
  static std::set<std::string> others(const Certain& rule, const Term& trigger) {
    std::set<std::string> out;
    for (const RuleParts::Condition& condition : rule.parts.conditions)
      if (condition.term != &trigger) out.insert(condition.term->print());
    return out;
  }

  bool alternate(const Certain& one, const Certain& other) const {
    for (const NewFact& there : one.facts)
      for (const NewFact& back : other.facts) {
        if (!there.fresh || !back.fresh) continue;
        if (!fires_again(one, there, other, *back.trigger) || !fires_again(other, back, one, *there.trigger)) continue;
        if (others(one, *there.trigger) != others(other, *back.trigger)) continue;
        const auto undisturbed = [&](const NewFact& fact) {
          return leaves_alone(one, *there.trigger, fact) && leaves_alone(other, *back.trigger, fact);
        };
        if (undisturbed(there) && undisturbed(back)) return true;
      }
    return false;
  }

  const RuleBase& base_;
  std::vector<Certain> rules_;
};

}  // namespace

void judge_loops(const RuleBase& base, Findings& findings) { Loops(base).judge(findings); }

// --- Salience

namespace {

struct Ranked {
  const Construct* rule = nullptr;
  RuleParts parts;
  int salience = 0;
};

/// What the values of a condition are called in another that it is compared with.
using Names = std::map<std::string, std::string>;

/// Whether a fact that matches `given` matches `wanted`, whose variables are then called as `names` says.
bool holds_for(const Term& wanted, const Term& given, Names& names) {
  const auto some = slots_of(wanted), all = slots_of(given);
  if (!some || !all) return wanted.print() == given.print();
  if (!some->wider_than(*all)) return false;
  for (const auto& [slot, constraint] : some->slots) {
    if (constraint.variable.empty()) continue;
    const auto other = all->slots.find(slot);
    const std::string name = other == all->slots.end() ? slot : other->second.variable + ' ' + other->second.text;
    if (names.emplace(constraint.variable, name).first->second.substr(0, name.find(' ')) != name.substr(0, name.find(' ')))
      return false;
  }
  return true;
}

/// Every condition of `low` also holds where those of `high` do.
bool holds_wherever(const Ranked& low, const Ranked& high) {
  Names names;
  return std::ranges::all_of(low.parts.conditions, [&](const RuleParts::Condition& condition) {
    return std::ranges::any_of(high.parts.conditions, [&](const RuleParts::Condition& other) {
      Names then = names;
      if (!holds_for(*condition.term, *other.term, then)) return false;
      names = std::move(then);
      return true;
    });
  });
}

/// A condition of `low` whose fact `high` takes away or changes, so that `low` no longer fires for it.
bool takes(const Ranked& high, const Ranked& low) {
  for (const Term* action : high.parts.actions) {
    const bool retracts = action->head() == "retract";
    if (!retracts && action->head() != "modify") continue;
    for (std::size_t i = 1; i < action->items.size() && (retracts || i == 1); ++i) {
      const std::string fact = variable_name(action->items[i]);
      for (const RuleParts::Condition& taken : high.parts.conditions) {
        if (fact.empty() || taken.fact != fact) continue;
        const auto given = slots_of(*taken.term);
        for (const RuleParts::Condition& condition : low.parts.conditions) {
          const auto wanted = slots_of(*condition.term);
          if (!given || !wanted || !wanted->wider_than(*given)) continue;
          if (retracts) return true;
          for (const auto& [slot, items] : values_of(*action, 2)) {
            const auto constraint = wanted->slots.find(slot);
            const bool constant = items.size() == 1 && !items[0].is_list() && !is_variable(items[0]);
            if (constraint != wanted->slots.end() && constant && constraint->second.plain &&
                !constraint->second.admits(items[0].print()))
              return true;
          }
        }
      }
    }
  }
  return false;
}

}  // namespace

void judge_salience(const RuleBase& base, Findings& findings) {
  std::vector<Ranked> rules;
  for (const Construct& construct : base.constructs()) {
    if (!construct.is_rule() || !construct.place.source->loaded) continue;
    Ranked ranked{&construct, parts_of(construct), 0};
    if (const Term* salience = ranked.parts.salience) {
      const auto number = read_number<int>(salience->text);
      if (!number) continue;
      ranked.salience = *number;
    }
    rules.push_back(std::move(ranked));
  }
  for (const Ranked& low : rules)
    for (const Ranked& high : rules) {
      if (low.salience >= high.salience || low.rule->module != high.rule->module || low.parts.conditions.empty()) continue;
      if (!holds_wherever(low, high) || !takes(high, low)) continue;
      const Ranked& declares = low.salience != 0 ? low : high;
      add(findings, {declares.rule->place.source, declares.parts.salience->line}, "salience",
          "only salience keeps rule '" + low.rule->name + "' from what rule '" + high.rule->name +
              "' takes: its conditions hold there, too; add what tells them apart to the conditions");
    }
}

}  // namespace cxlab::check
