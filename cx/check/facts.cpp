// Facts, slots and symbols that nothing gives or takes.

#include <algorithm>
#include <map>
#include <set>

#include "cx/base/slip.h"
#include "cx/check/judge.h"

namespace cxlab::check {

namespace {

struct Known {
  std::set<std::string> asserted, read;
  std::map<std::string, const Touch*> first_assert, first_read;  // in files that are judged
};

Known known_of(const RuleBase& base) {
  Known known;
  for (const Touch& touch : base.touches()) {
    const bool reads = touch.how == How::kRead || touch.how == How::kReadNot;
    if (touch.how == How::kAssert) known.asserted.insert(touch.template_name);
    if (reads) known.read.insert(touch.template_name);
    if (!touch.by->judged()) continue;
    if (touch.how == How::kAssert) known.first_assert.emplace(touch.template_name, &touch);
    if (reads) known.first_read.emplace(touch.template_name, &touch);
  }
  return known;
}

bool is_outside(const RuleBase& base, const std::string& name) {
  return base.outside().templates.contains(name) || base.outside().facts.contains(name) || base.is_mentioned(name) ||
         name == "initial-fact";
}

std::string in_quotes(const std::string& word) { return word.starts_with('"') ? word : '\'' + word + '\''; }

/// Where a construct has a symbol.
int line_of(const Term& term, const std::string& symbol) {
  if (term.is(symbol)) return term.line;
  for (const Term& item : term.items)
    if (const int line = line_of(item, symbol); line > 0) return line;
  return 0;
}

void judge_templates(const RuleBase& base, const Known& known, Findings& findings) {
  std::set<std::string> names = known.asserted;
  names.insert(known.read.begin(), known.read.end());
  for (const auto& [name, defined] : base.templates()) names.insert(name);
  const bool doubts_little = base.outside().open;
  std::map<std::string, int> count;
  for (const Touch& touch : base.touches()) ++count[touch.template_name];
  for (const std::string& name : names) {
    if (is_outside(base, name)) continue;
    const bool asserted = known.asserted.contains(name), read = known.read.contains(name);
    if (asserted && read) continue;
    const auto defined = base.templates().find(name);
    const bool by_template = defined != base.templates().end();
    const auto reader = known.first_read.find(name), writer = known.first_assert.find(name);
    const std::set<std::string>& others = asserted ? known.read : known.asserted;
    std::vector<std::string> candidates(others.begin(), others.end());
    if (!asserted) candidates.insert(candidates.end(), base.outside().facts.begin(), base.outside().facts.end());
    const std::string meant_name = meant(name, candidates);
    const std::string hint = meant_name.empty() ? "" : ", did you mean '" + meant_name + "'?";
    if (doubts_little && meant_name.empty()) continue;
    // One name is only read, the other only asserted: the rarer one is misspelt.
    if (!meant_name.empty()) {
      const bool other_misses = !is_outside(base, meant_name) &&
                                (asserted ? !known.asserted.contains(meant_name) : !known.read.contains(meant_name));
      const int own = count[name], other = count[meant_name];
      if (other_misses && (own > other || (own == other && !asserted))) continue;
    }
    if (!asserted && !read) {
      add(findings, defined->second.defined->place, "unused-template",
          "nothing asserts or reads facts of template '" + name + "'; use it or remove it");
    } else if (!asserted && !base.asserts_unknown()) {
      if (reader == known.first_read.end()) continue;
      const std::string at = reader->second->place.text();
      if (by_template && hint.empty())
        add(findings, defined->second.defined->place, "never-asserted",
            "nothing asserts facts of template '" + name + "', which '" + reader->second->by->name + "' reads at " +
                at + "; assert them or remove what reads them");
      else
        add(findings, reader->second->place, "never-asserted",
            "nothing asserts the facts '" + name + "' that '" + reader->second->by->name + "' reads" +
                (hint.empty() ? "; assert them or remove what reads them" : hint));
    } else if (asserted) {
      if (writer == known.first_assert.end()) continue;
      if (by_template && hint.empty())
        add(findings, defined->second.defined->place, "never-read",
            "no rule reads facts of template '" + name + "', which '" + writer->second->by->name + "' asserts at " +
                writer->second->place.text() + "; read them or do not assert them");
      else
        add(findings, writer->second->place, "never-read",
            "no rule reads the facts '" + name + "' that '" + writer->second->by->name + "' asserts" +
                (hint.empty() ? "; read them or do not assert them" : hint));
    }
  }
}

/// `unknown-slot` reports it.
bool is_of_unknown_slot(const RuleBase& base, const Test& test) {
  if (!test.value.starts_with("s:")) return false;
  const std::size_t dot = test.value.rfind('.');
  return base.lacks_slot(test.value.substr(2, dot - 2), test.value.substr(dot + 1));
}

void judge_symbols(const RuleBase& base, Findings& findings) {
  std::map<std::string, std::set<const Construct*>> testers;
  std::map<std::string, std::set<std::string>> tested;  // by value
  for (const Test& test : base.tests()) {
    testers[test.symbol].insert(test.by);
    tested[base.origin_of(test.value)].insert(test.symbol);
  }
  for (const Test& test : base.tests()) {
    if (!test.place.source->judged || is_of_unknown_slot(base, test)) continue;
    const Values& values = base.possible(test.value);
    if (values.symbols.contains(test.symbol)) continue;
    if (values.symbols.empty() && !values.open) continue;  // nothing asserts its facts, which `never-asserted` reports
    const bool text = test.symbol.starts_with('"');
    const bool uncertain = values.open || (text && values.open_text) || base.outside().open || base.asserts_unknown();
    std::vector<std::string> known;
    for (const auto& [symbol, by] : values.symbols)
      if (symbol.starts_with('"') == text) known.push_back(symbol);
    std::string near = meant(test.symbol, known);
    if (uncertain) {
      // A misspelt word rarely appears twice.
      if (text || base.is_mentioned(test.symbol) || base.has_in_text(test.symbol) || testers[test.symbol].size() > 1 ||
          base.outside().words.contains(test.symbol))
        continue;
      // For values from outside, the known words are those that several rules expect and those of files beside the
      // rules.
      known.clear();
      for (const std::string& symbol : tested[base.origin_of(test.value)])
        if (testers[symbol].size() > 1 || base.is_mentioned(symbol)) known.push_back(symbol);
      constexpr std::size_t kTelling = 6;
      for (const std::string& word : base.outside().words)
        if (word.size() >= kTelling && is_slip(test.symbol, word)) known.push_back(word);
      if (near.empty()) near = meant(test.symbol, known);
      if (near.empty() || (!values.symbols.contains(near) && !is_slip(test.symbol, near)) ||
          near.starts_with(test.symbol + '-') || test.symbol.starts_with(near + '-'))
        continue;
    }
    std::string message = test.what + " is never " + test.symbol;
    if (!near.empty())
      message += ", did you mean " + in_quotes(near) + "?";
    else
      message += "; expected " + (known.empty() ? "no symbol" : "one of: " + some_of(known, 6));
    add(findings, test.place, "unknown-symbol", message);
  }
}

/// The symbols of a slot, and those that its template allows.
void judge_allowed(const RuleBase& base, const std::string& name, const std::string& slot_name, const Slot& slot,
                   const Place& place, Findings& findings) {
  const std::string key = "s:" + name + '.' + slot_name, what = "slot '" + slot_name + "' of '" + name + '\'';
  const Values& values = base.possible(key);
  std::vector<std::string> allowed;
  for (const auto& [symbol, line] : slot.allowed) allowed.push_back(symbol);
  for (const auto& [symbol, by] : values.symbols) {
    const std::string near = meant(symbol, allowed);
    const auto is_meant = [&](const Test& test) { return test.symbol == symbol; };  // somewhere
    if (near.empty() || std::ranges::count(allowed, symbol) > 0 || std::ranges::any_of(base.tests(), is_meant))
      continue;
    for (const Construct* giver : by)
      if (giver)
        add(findings, {giver->place.source, line_of(giver->tree, symbol)}, "unknown-symbol",
            what + " gets " + symbol + ", which its template does not allow, did you mean '" + near + "'?");
  }
  if (values.open) return;
  for (const auto& [symbol, line] : slot.allowed) {
    const bool is_tested =
        std::ranges::any_of(base.tests(), [&](const Test& test) { return test.value == key && test.symbol == symbol; });
    if (!values.symbols.contains(symbol) && !is_tested)
      add(findings, {place.source, line}, "never-set", what + " is never " + symbol + "; set it or do not allow it");
  }
}

void judge_slots(const RuleBase& base, const Known& known, Findings& findings) {
  for (const auto& [name, defined] : base.templates()) {
    if (is_outside(base, name) || !known.asserted.contains(name) || base.asserts_unknown() || base.outside().open)
      continue;
    if (!defined.defined->judged()) continue;
    for (const auto& [slot_name, slot] : defined.slots) {
      const Place place{defined.defined->place.source, slot.line};
      const bool is_set = base.is_set(name, slot_name), is_read = base.is_read(name, slot_name);
      if (!is_set && !is_read) {
        add(findings, place, "never-set",
            "nothing sets or reads slot '" + slot_name + "' of '" + name + "'; remove it");
        continue;
      }
      if (!is_set && !slot.has_default) {
        add(findings, place, "never-set",
            "rules read slot '" + slot_name + "' of '" + name +
                "', which nothing sets and which has no default; set it or remove it");
        continue;
      }
      if (!slot.allowed.empty()) judge_allowed(base, name, slot_name, slot, place, findings);
    }
  }
}

}  // namespace

void judge_facts(const RuleBase& base, Findings& findings) {
  const Known known = known_of(base);
  judge_templates(base, known, findings);
  judge_symbols(base, findings);
  judge_slots(base, known, findings);
}

}  // namespace cxlab::check
