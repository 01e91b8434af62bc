// Rules that make each other fire without an end. A loop is told only where each step is certain: actions outside of
// `if` and loops, and conditions that the steps leave alone.

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "cx/base/number_text.h"
#include "cx/check/effects.h"
#include "cx/check/judge.h"
#include "cx/check/patterns.h"

namespace cxlab::check {

namespace {

constexpr int kMostTries = 300000;  // comparisons of facts with conditions; beyond, nothing is reported

/// The fact that a firing leaves: a slot is as the condition says, or has a new value.
struct NewFact {
  std::string name;
  std::map<std::string, std::string> constants;  ///< slots that are set to a constant
  std::map<std::string, int> grows;              ///< slots whose value differs from all before; 1: larger, -1: smaller
  std::set<std::string> unknown;                 ///< slots of which nothing is known
  bool keeps_others = false;                     ///< a modify: the other slots are as they were
  bool fresh = false;                            ///< it is always a new fact, or a changed one
  std::size_t trigger = 0;                       ///< the condition whose fact it comes from
};

struct Condition {
  const Term* term = nullptr;
  std::optional<PatternSlots> pattern;
};

/// A rule whose actions are certain.
struct Certain {
  const Construct* rule = nullptr;
  std::vector<Condition> conditions;
  std::vector<NewFact> facts;
  std::set<std::string> touched;  ///< templates of all facts that it asserts or changes
};

/// 1: an expression gives a larger value each time, made from that variable, as (+ ?n 1); -1: a smaller one; 2: another
/// one.
int grows_from(const Term& value, const std::string& variable) {
  const std::string_view head = value.head();
  if (!is_any(head, {"+", "-", "str-cat", "sym-cat"}) || value.items.size() != 3 || variable.empty()) return 0;
  const Term &left = value.items[1], &right = value.items[2];
  const Term& other = variable_name(left) == variable ? right : left;
  if (variable_name(left) != variable && (variable_name(right) != variable || head == "-")) return 0;
  if (other.is_list() || is_variable(other)) return 0;
  if (head != "+" && head != "-") return other.text == "\"\"" ? 0 : 2;
  const auto number = read_number<double>(other.text);
  return !number || *number == 0 ? 0 : (*number > 0) == (head == "+") ? 1 : -1;
}

/// Whether what a condition computes depends on its variables alone.
bool is_pure(const Term& term, bool computes) {
  if (term.kind == Token::Kind::kWord && term.text.starts_with("?*")) return false;
  if (!term.is_list()) return true;
  const std::string_view head = term.head();
  if (computes && !is_any(head, {"eq",      "neq",     "=",       "<>",         "<",          ">",
                                 "<=",      ">=",      "and",     "or",         "not",        "+",
                                 "-",       "*",       "/",       "mod",        "member$",    "create$",
                                 "length$", "str-cat", "sym-cat", "sub-string", "str-compare"}))
    return false;
  for (std::size_t i = 0; i < term.items.size(); ++i) {
    const bool predicate = i > 0 && (term.items[i - 1].is(":") || term.items[i - 1].is("="));
    if (!is_pure(term.items[i], computes || predicate || (head == "test" && i > 0))) return false;
  }
  return true;
}

bool names(const Term& term, const std::string& template_name) {
  return without_module(term.head()) == template_name || std::ranges::any_of(term.items, [&](const Term& item) {
           return item.is(template_name) || names(item, template_name);
         });
}

class CertainReader {
 public:
  explicit CertainReader(const RuleBase& base) : effects_(base) {}

  std::optional<Certain> read(const Construct& rule) {
    Certain certain{&rule, {}, {}, {}};
    const RuleParts parts = parts_of(rule);
    conditions_.clear();
    for (std::size_t i = 0; i < parts.conditions.size(); ++i) {
      certain.conditions.push_back({parts.conditions[i].term, slots_of(*parts.conditions[i].term)});
      if (!parts.conditions[i].fact.empty()) conditions_[parts.conditions[i].fact] = i;
    }
    std::set<std::string> retracted, elsewhere;  // `elsewhere`: templates of what happens only perhaps
    std::vector<const Term*> before, after;      // facts that are asserted before and after the first retract
    for (const Term* action : parts.actions) {
      const std::string_view head = action->head();
      if (head == "retract" || head == "assert" || head == "modify") {
        for (const Term& item : action->items)
          for (const Term& part : item.items) effects_.add(part, elsewhere);
      } else {
        effects_.add(*action, elsewhere);
      }
      if (head == "retract") {
        for (std::size_t i = 1; i < action->items.size(); ++i) retracted.insert(variable_name(action->items[i]));
      } else if (head == "assert") {
        for (std::size_t i = 1; i < action->items.size(); ++i)
          (retracted.empty() ? before : after).push_back(&action->items[i]);
      } else if (head == "modify" && action->items.size() > 2) {
        const auto condition = conditions_.find(variable_name(action->items[1]));
        if (condition == conditions_.end()) return std::nullopt;
        if (auto fact = modified(*action, certain, condition->second)) certain.facts.push_back(*std::move(fact));
      }
    }
    for (const std::string& name : elsewhere)
      if (name.empty() ||
          std::ranges::any_of(certain.conditions, [&](const Condition& c) { return names(*c.term, name); }))
        return std::nullopt;
    // Retracting what others than the trigger stand for ends the loop.
    if (retracted.size() > 1 || (!retracted.empty() && !conditions_.contains(*retracted.begin()))) return std::nullopt;
    for (std::size_t i = 0; i < certain.conditions.size(); ++i) {
      const bool goes = !retracted.empty() && conditions_.at(*retracted.begin()) == i;
      if (!retracted.empty() && !goes) continue;
      for (const Term* fact : before) make(*fact, certain, i, false);
      for (const Term* fact : after) make(*fact, certain, i, goes);
    }
    if (!retracted.empty())
      std::erase_if(certain.facts, [&](const NewFact& f) { return f.trigger != conditions_.at(*retracted.begin()); });
    for (const std::vector<const Term*>& asserted : {before, after})
      for (const Term* fact : asserted) certain.touched.insert(std::string(without_module(fact->head())));
    for (const NewFact& fact : certain.facts) certain.touched.insert(fact.name);
    return certain;
  }

 private:
  static void take(const std::map<std::string, std::span<const Term>>& values, const PatternSlots& pattern,
                   NewFact& fact) {
    for (const auto& [slot, items] : values) {
      const auto constraint = pattern.slots.find(slot);
      const std::string variable = constraint != pattern.slots.end() ? constraint->second.variable : std::string();
      const int growth = items.size() == 1 ? grows_from(items[0], variable) : 0;
      if (growth != 0)
        fact.grows[slot] = growth;
      else if (items.size() == 1 && !items[0].is_list() && !is_variable(items[0]))
        fact.constants[slot] = items[0].print();
      else
        fact.unknown.insert(slot);
    }
  }

  static std::optional<NewFact> modified(const Term& action, const Certain& rule, std::size_t condition) {
    const auto& pattern = rule.conditions[condition].pattern;
    if (!pattern) return std::nullopt;
    NewFact fact{pattern->name, {}, {}, {}, true, false, condition};
    take(values_of(action, 2), *pattern, fact);
    // CLIPS looks again only at conditions that name a slot which has changed.
    for (const auto& [slot, growth] : fact.grows) fact.fresh = fact.fresh || pattern->slots.contains(slot);
    for (const auto& [slot, value] : fact.constants)
      if (const auto known = pattern->slots.find(slot); known != pattern->slots.end())
        fact.fresh =
            fact.fresh || (known->second.plain && !known->second.one_of.empty() && !known->second.admits(value));
    return fact;
  }

  static void make(const Term& asserted, Certain& rule, std::size_t condition, bool goes) {
    const auto& pattern = rule.conditions[condition].pattern;
    if (!pattern || asserted.head().empty()) return;
    NewFact fact{std::string(without_module(asserted.head())), {}, {}, {}, false, goes, condition};
    take(values_of(asserted), *pattern, fact);
    for (std::size_t i = 1; i < asserted.items.size(); ++i) {
      if (!asserted.items[i].is_list() || !pattern->slots.contains("#")) continue;
      const std::string slot = std::to_string(i);  // a call among the fields of an ordered fact
      const auto constraint = pattern->slots.find(slot);
      const int growth =
          constraint == pattern->slots.end() ? 0 : grows_from(asserted.items[i], constraint->second.variable);
      if (growth != 0)
        fact.grows[slot] = growth;
      else
        fact.unknown.insert(slot);
    }
    fact.constants["#"] = std::to_string(asserted.items.size());
    fact.fresh = fact.fresh || !fact.grows.empty();
    rule.facts.push_back(std::move(fact));
  }

  Effects effects_;
  std::map<std::string, std::size_t> conditions_;  // by variable of the fact
};

class Loops {
 public:
  explicit Loops(const RuleBase& base) {
    CertainReader reader(base);
    for (const Construct& construct : base.constructs())
      if (construct.is_rule() && construct.place.source->loaded)
        if (auto certain = reader.read(construct)) rules_.push_back(*std::move(certain));
    for (const Certain& rule : rules_)
      for (const NewFact& fact : rule.facts)
        if (fact.fresh) {
          by_trigger_[rule.conditions[fact.trigger].pattern->name].push_back(steps_.size());
          steps_.push_back({&rule, &fact});
        }
  }

  void judge(Findings& findings) {
    std::set<const Certain*> told;
    for (std::size_t i = 0; i < steps_.size() && spent_ < kMostTries; ++i) {
      if (told.contains(steps_[i].rule)) continue;
      const std::vector<std::size_t> round = round_from(i);
      if (round.empty()) continue;
      std::set<std::pair<std::size_t, const Certain*>> rules;
      for (const std::size_t k : round) {
        rules.insert({static_cast<std::size_t>(steps_[k].rule - rules_.data()), steps_[k].rule});
        told.insert(steps_[k].rule);
      }
      tell(rules, *steps_[i].fact, findings);
    }
  }

 private:
  /// A firing, and the fact that it leaves.
  struct Step {
    const Certain* rule = nullptr;
    const NewFact* fact = nullptr;
    const Condition& trigger() const { return rule->conditions[fact->trigger]; }
  };

  static void tell(const std::set<std::pair<std::size_t, const Certain*>>& rules, const NewFact& fact,
                   Findings& findings) {
    const Construct& last = *rules.rbegin()->second->rule;
    if (rules.size() == 1)
      return add(findings, last.place, "loop",
                 "rule '" + last.name + "' makes itself fire again without an end: it changes '" + fact.name +
                     "', and its conditions hold as before; add a condition that ends it");
    std::string others;
    for (const auto& [number, rule] : rules)
      if (rule->rule != &last)
        others += (others.empty() ? "'" : ", '") + rule->rule->name + "' (" + rule->rule->place.text() + ')';
    add(findings, last.place, "loop",
        "rules " + others + " and '" + last.name +
            "' make each other fire without an end; add a condition that ends it");
  }

  /// The shortest way from a step back to it, by steps each of which makes the next one happen.
  std::vector<std::size_t> round_from(std::size_t start) {
    std::map<std::size_t, std::size_t> from;
    std::vector<std::size_t> row{start};
    for (std::size_t next = 0; next < row.size() && spent_ < kMostTries; ++next) {
      const std::size_t at = row[next];
      const auto found = by_trigger_.find(steps_[at].fact->name);
      if (found == by_trigger_.end()) continue;
      for (const std::size_t k : found->second) {
        if ((k != start && from.contains(k)) || !leads_to(steps_[at], steps_[k])) continue;
        if (k != start) {
          from[k] = at;
          row.push_back(k);
          continue;
        }
        std::vector<std::size_t> round{at};
        while (round.back() != start) round.push_back(from.at(round.back()));
        if (is_undisturbed(round) && grows_all_round(round)) return round;
      }
    }
    return {};
  }

  bool leads_to(const Step& step, const Step& next) {
    ++spent_;
    return others(step) == others(next) && fires_again(step, *next.rule, next.trigger());
  }

  /// Whether the fact that the step leaves satisfies that condition of `rule`.
  static bool fires_again(const Step& step, const Certain& rule, const Condition& condition) {
    const NewFact& fact = *step.fact;
    const auto &pattern = condition.pattern, &before = step.trigger().pattern;
    if (!pattern || !before || pattern->name != fact.name) return false;
    if (pattern->slots.contains("#") && !fact.keeps_others &&
        fact.constants.at("#") != *pattern->slots.at("#").one_of.begin())
      return false;
    for (const auto& [slot, constraint] : pattern->slots) {
      if (slot == "#") continue;
      const auto constant = fact.constants.find(slot);
      const auto growth = fact.grows.find(slot);
      bool open = constraint.any();
      std::size_t uses = 1;
      if (constant != fact.constants.end()) {
        open = constraint.admits(constant->second);
      } else if (growth != fact.grows.end() && constraint.unbounded != 0) {
        open = constraint.unbounded == growth->second;
        uses = 2;  // in its own predicate
      } else if (growth == fact.grows.end() && !fact.unknown.contains(slot) && fact.keeps_others) {
        const auto known = before->slots.find(slot);
        if (step.rule == &rule) continue;
        if (!(known != before->slots.end() ? constraint.wider_than(known->second) : constraint.any())) return false;
        continue;
      }
      if (!open || is_used_elsewhere(rule, condition, constraint.variable, uses)) return false;
    }
    return true;
  }

  /// Whether a variable of the condition is in another one, or more often than that in this one.
  static bool is_used_elsewhere(const Certain& rule, const Condition& condition, const std::string& variable,
                                std::size_t uses) {
    if (variable.empty()) return false;
    return std::ranges::any_of(rule.conditions, [&](const Condition& other) {
      return count_of(*other.term, variable) > (&other == &condition ? uses : 0);
    });
  }

  /// Stands for the conditions beside the trigger.
  std::size_t others(const Step& step) {
    const auto [known, fresh] = others_.try_emplace({step.rule, step.fact->trigger});
    if (!fresh) return known->second;
    std::set<std::string> texts;
    for (const Condition& condition : step.rule->conditions)
      if (&condition != &step.trigger()) texts.insert(condition.term->print());
    return known->second = numbers_.try_emplace(texts, numbers_.size()).first->second;
  }

  /// The other conditions look neither at what the steps change, nor at anything but facts.
  bool is_undisturbed(const std::vector<std::size_t>& round) const {
    std::set<std::string> touched;
    for (const std::size_t i : round) touched.insert(steps_[i].rule->touched.begin(), steps_[i].rule->touched.end());
    return std::ranges::all_of(round, [&](std::size_t i) {
      const Step& step = steps_[i];
      return std::ranges::all_of(step.rule->conditions, [&](const Condition& condition) {
        if (!is_pure(*condition.term, false)) return false;
        return &condition == &step.trigger() ||
               std::ranges::none_of(touched, [&](const std::string& name) { return names(*condition.term, name); });
      });
    });
  }

  /// A slot that one step makes grow, no other step sets back: a value that is small again could end the round.
  bool grows_all_round(const std::vector<std::size_t>& round) const {
    const auto goes_on = [&](const std::string& slot, int growth) {
      return std::ranges::all_of(round, [&](std::size_t i) {
        const NewFact& fact = *steps_[i].fact;
        const auto grown = fact.grows.find(slot);
        if (grown != fact.grows.end()) return grown->second == growth;
        return fact.keeps_others && !fact.constants.contains(slot) && !fact.unknown.contains(slot);
      });
    };
    return std::ranges::all_of(round, [&](std::size_t i) {
      return std::ranges::all_of(steps_[i].fact->grows,
                                 [&](const auto& grown) { return goes_on(grown.first, grown.second); });
    });
  }

  std::vector<Certain> rules_;
  std::vector<Step> steps_;
  std::map<std::string, std::vector<std::size_t>> by_trigger_;  // by template
  std::map<std::pair<const Certain*, std::size_t>, std::size_t> others_;
  std::map<std::set<std::string>, std::size_t> numbers_;
  int spent_ = 0;
};

}  // namespace

void judge_loops(const RuleBase& base, Findings& findings) { Loops(base).judge(findings); }

}  // namespace cxlab::check
