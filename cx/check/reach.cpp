// Rules that can never fire.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "cx/base/number_text.h"
#include "cx/check/judge.h"
#include "cx/check/patterns.h"

namespace cxlab::check {

namespace {

// --- Conditions that exclude each other

/// What the conditions of a rule demand of a variable.
struct Demand {
  double low = -HUGE_VAL, high = HUGE_VAL;
  bool low_open = false, high_open = false;
  std::optional<std::set<std::string>> one_of;
  std::set<std::string> none_of;

  void compare(std::string op, double number) {
    if ((op == ">" || op == ">=") && (number > low || (number == low && op == ">"))) low = number, low_open = op == ">";
    if ((op == "<" || op == "<=") && (number < high || (number == high && op == "<")))
      high = number, high_open = op == "<";
    if (op == "=") {
      compare(">=", number);
      compare("<=", number);
    }
  }
  void be_one_of(const std::set<std::string>& values) {
    if (!one_of) one_of = values;
    std::erase_if(*one_of, [&](const std::string& value) { return !values.contains(value); });
  }
  bool possible() const {
    if (low > high || (low == high && (low_open || high_open))) return false;
    return !one_of || std::ranges::any_of(*one_of, [&](const std::string& value) { return !none_of.contains(value); });
  }
};

class Contradiction {
 public:
  /// Why no facts satisfy the conditions together; nullptr: they may.
  const Term* find(const RuleBase& base, const RuleParts& parts) {
    for (const RuleParts::Condition& condition : parts.conditions) {
      const Term& term = *condition.term;
      if (term.head() == "test" && term.items.size() == 2) read(term.items[1]);
      if (const auto pattern = slots_of(term)) {
        for (const auto& [name, slot] : pattern->slots) {
          if (slot.impossible) return say(term, "slot '" + name + "' cannot be " + slot.text);
          if (!slot.variable.empty() && slot.plain) {
            if (!slot.one_of.empty()) demands_[slot.variable].be_one_of(slot.one_of);
            demands_[slot.variable].none_of.insert(slot.none_of.begin(), slot.none_of.end());
          }
        }
        read_predicates(term);
      }
      if (impossible_) return say(term, why);
      for (const auto& [name, demand] : demands_)
        if (!demand.possible()) return say(term, "no ?" + name + " fulfils all that is demanded of it");
    }
    for (const RuleParts::Condition& one : parts.conditions)
      for (const RuleParts::Condition& other : parts.conditions) {
        if (other.term->head() != "not" || other.term->items.size() != 2) continue;
        const Term& inner = other.term->items[1];
        const bool all = inner.items.size() == 1 && base.is_file_template(std::string(inner.head())) &&
                         !base.templates().at(std::string(inner.head())).slots.empty();
        if (inner.print() == one.term->print() || (all && inner.head() == one.term->head()) ||
            holds_for_all(inner, *one.term, parts))
          return say(*other.term, other.term->print() + " excludes " + one.term->print());
      }
    return nullptr;
  }
  std::string why;

 private:
  const Term* say(const Term& term, std::string what) {
    why = std::move(what);
    return &term;
  }

  /// Whatever matches `given` matches the pattern `inner` of a `not`: its variables stand for any value, or for the
  /// same one.
  static bool holds_for_all(const Term& inner, const Term& given, const RuleParts& parts) {
    const auto wanted = slots_of(inner), known = slots_of(given);
    if (!wanted || !known || !wanted->wider_than(*known)) return false;
    return std::ranges::all_of(wanted->slots, [&](const auto& item) {
      const std::string& variable = item.second.variable;
      const auto same = known->slots.find(item.first);
      if (variable.empty() || (same != known->slots.end() && same->second.variable == variable)) return true;
      std::size_t count = count_of(inner, variable);
      for (const RuleParts::Condition& condition : parts.conditions)
        if (condition.term->head() != "not") count += count_of(*condition.term, variable);
      return count == 1;
    });
  }

  /// `?x&:(> ?x 3)` without alternatives beside it.
  void read_predicates(const Term& pattern) {
    for (const Term& slot : pattern.items) {
      const std::vector<Term>& items = slot.is_list() ? slot.items : pattern.items;
      if (std::ranges::any_of(items, [](const Term& t) { return t.is("|") || t.is("~"); })) continue;
      for (std::size_t i = 1; i < items.size(); ++i)
        if (items[i - 1].is(":")) read(items[i]);
      if (!slot.is_list()) return;
    }
  }

  void read(const Term& test) {
    if (test.is("FALSE")) {
      impossible_ = true;
      why = "its test is FALSE";
    }
    const std::string op(test.head());
    if (op == "and")
      for (std::size_t i = 1; i < test.items.size(); ++i) read(test.items[i]);
    if (test.items.size() != 3) return;
    const Term &left = test.items[1], &right = test.items[2];
    const std::string name = variable_name(left), other = variable_name(right);
    if (!name.empty() && name == other && left.text == right.text &&
        (op == "<" || op == ">" || op == "neq" || op == "<>")) {
      impossible_ = true;
      why = test.print() + " never holds";
    }
    if (!name.empty() && left.text.find(':') == std::string::npos) {
      if (const auto number = read_number<double>(right.text)) demands_[name].compare(op, *number);
      if (is_symbol(right) && op == "eq") demands_[name].be_one_of({right.text});
      if (is_symbol(right) && op == "neq") demands_[name].none_of.insert(right.text);
    } else if (!other.empty() && right.text.find(':') == std::string::npos) {
      static const std::map<std::string, std::string> kTurned{
          {"<", ">"}, {">", "<"}, {"<=", ">="}, {">=", "<="}, {"=", "="}};
      const auto turned = kTurned.find(op);
      if (const auto number = read_number<double>(left.text); number && turned != kTurned.end())
        demands_[other].compare(turned->second, *number);
    }
  }

  std::map<std::string, Demand> demands_;
  bool impossible_ = false;
};

// --- Facts that only rules make that need them first

class Reach {
  static constexpr int kMostSteps = 300000;  // from rule to rule; beyond, nothing is reported

 public:
  explicit Reach(const RuleBase& base) : base_(base) {
    for (const Touch& touch : base.touches()) {
      if (touch.how == How::kAssert) makers_[touch.template_name].insert(touch.by);
      if (touch.required && touch.by->is_rule() && touch.by->judged()) needs_[touch.by].push_back(&touch);
    }
    bool more = true;
    while (more) {
      more = false;
      for (const auto& [rule, needs] : needs_)
        if (!reached_.contains(rule) && !lacking(rule)) more = reached_.insert(rule).second;
    }
  }

  void judge(Findings& findings) const {
    for (const auto& [rule, needs] : needs_) {
      if (reached_.contains(rule)) continue;
      std::set<const Construct*> seen;
      if (!waits_for(rule, rule, seen)) continue;
      const Touch& lacks = *lack_of(rule).pattern;
      add(findings, rule->place, "unreachable",
          "rule '" + rule->name + "' never fires: only rules that need it first make " + lacks.term->print() +
              "; assert it elsewhere, as in deffacts");
    }
  }

 private:
  bool works(const Construct* by) const {
    return !by || !by->is_rule() || !by->judged() || reached_.contains(by) || !needs_.contains(by);
  }

  /// The makers of what a pattern needs; none: it can be there, or its lack is another finding.
  std::set<const Construct*> makers_of(const Touch& pattern) const {
    const std::string& name = pattern.template_name;
    if (base_.outside().open || base_.asserts_unknown() || base_.outside().templates.contains(name) ||
        base_.outside().facts.contains(name) || base_.is_mentioned(name))
      return {};
    const auto found = makers_.find(name);
    if (found == makers_.end()) return {};
    if (std::ranges::none_of(found->second, [&](const Construct* by) { return works(by); })) return found->second;
    const auto slots = slots_of(*pattern.term);
    if (!slots) return {};
    for (const auto& [slot, constraint] : slots->slots) {
      if (!constraint.plain || constraint.one_of.empty() || slot == "#") continue;
      const Values values = base_.possible("s:" + name + '.' + slot);
      if (values.open) continue;
      std::set<const Construct*> all;
      for (const std::string& symbol : constraint.one_of)
        if (const auto by = values.symbols.find(symbol); by != values.symbols.end())
          all.insert(by->second.begin(), by->second.end());
      if (!all.empty() && std::ranges::none_of(all, [&](const Construct* by) { return works(by); })) return all;
    }
    return {};
  }

  /// What a rule waits for, when it is known which rules are reached.
  struct Lack {
    const Touch* pattern = nullptr;
    std::set<const Construct*> makers;
  };
  const Lack& lack_of(const Construct* rule) const {
    const auto [known, fresh] = lacks_.try_emplace(rule);
    if (fresh && (known->second.pattern = lacking(rule))) known->second.makers = makers_of(*known->second.pattern);
    return known->second;
  }

  const Touch* lacking(const Construct* rule) const {
    for (const Touch* need : needs_.at(rule))
      if (!makers_of(*need).empty()) return need;
    return nullptr;
  }

  /// Whether what the rule lacks is made, by way of others, only after itself.
  bool waits_for(const Construct* rule, const Construct* wanted, std::set<const Construct*>& seen) const {
    if (!seen.insert(rule).second) return false;
    return std::ranges::any_of(lack_of(rule).makers, [&](const Construct* by) {
      if (++spent_ > kMostSteps) return false;
      return by == wanted || (needs_.contains(by) && !reached_.contains(by) && waits_for(by, wanted, seen));
    });
  }

  const RuleBase& base_;
  std::map<std::string, std::set<const Construct*>> makers_;
  std::map<const Construct*, std::vector<const Touch*>> needs_;
  std::set<const Construct*> reached_;
  mutable std::map<const Construct*, Lack> lacks_;
  mutable int spent_ = 0;
};

void judge_modules(const RuleBase& base, Findings& findings) {
  std::set<std::string> focused{"MAIN"};
  std::map<std::string, const Construct*> first;
  for (const Construct& construct : base.constructs()) {
    if (!construct.is_rule()) continue;
    first.emplace(construct.module, &construct);
    if (construct.tree.print().find("(auto-focus TRUE)") != std::string::npos) focused.insert(construct.module);
  }
  for (const auto& [module, rule] : first)
    if (!focused.contains(module) && !base.is_mentioned(module) && !base.outside().words.contains(module))
      add(findings, rule->place, "unreachable",
          "rule '" + rule->name + "' never fires: nothing gives module '" + module + "' the focus; call (focus " +
              module + ") or declare auto-focus");
}

}  // namespace

void judge_reach(const RuleBase& base, Findings& findings) {
  for (const Construct& construct : base.constructs()) {
    if (!construct.is_rule() || !construct.judged()) continue;
    Contradiction contradiction;
    if (const Term* at = contradiction.find(base, parts_of(construct)))
      add(findings, {construct.place.source, at->line}, "unreachable",
          "rule '" + construct.name + "' never fires: " + contradiction.why + "; correct or remove it");
  }
  Reach(base).judge(findings);
  judge_modules(base, findings);
}

}  // namespace cxlab::check
