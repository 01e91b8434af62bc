#include "cx/explain/coverage.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <tuple>

#include "cx/base/number_text.h"
#include "cx/explain/matcher.h"
#include "cx/explain/names.h"

namespace cxlab::explain {

namespace {

using Kind = Condition::Kind;

// --- What CLIPS makes of conditions

/// A join, or a test that belongs to the join before it and takes so many places there.
struct Element {
  bool test = false;
  std::size_t places = 1;
};

/// The ways through conditions that are one within another: whether each consists of tests alone.
std::vector<bool> tests_alone(const Condition& condition) {
  switch (condition.kind) {
    case Kind::kTest: return {true};
    case Kind::kOr: {
      std::vector<bool> all;
      for (const Condition& part : condition.parts) {
        const std::vector<bool> ways = tests_alone(part);
        all.insert(all.end(), ways.begin(), ways.end());
      }
      return all;
    }
    case Kind::kAnd: {
      std::vector<bool> all{true};
      for (const Condition& part : condition.parts) {
        std::vector<bool> grown;
        for (const bool before : all)
          for (const bool more : tests_alone(part)) grown.push_back(before && more);
        all = std::move(grown);
      }
      return all;
    }
    case Kind::kNot: {
      bool all = true;
      for (const Condition& part : condition.parts)
        for (const bool way : tests_alone(part)) all = all && way;
      return {all};
    }
    default: return {false};
  }
}

/// What a condition at the top of a way becomes: the negation of an `or` is one of each of its parts.
std::vector<Element> elements_of(const Condition& condition) {
  std::vector<Element> elements;
  switch (condition.kind) {
    case Kind::kTest: {
      const Term& test = condition.expression;
      return {{true, test.head() == "and" && test.items.size() > 1 ? test.items.size() - 1 : 1}};
    }
    case Kind::kNot:
      for (const Condition& part : condition.parts)
        for (const bool test : tests_alone(part)) elements.push_back({test});
      return elements;
    case Kind::kForall:
      if (!condition.parts.empty())
        for (std::size_t i = 0; i < tests_alone(condition.parts.front()).size(); ++i) elements.emplace_back();
      return elements;
    default: return {Element{}};
  }
}

/// What a join stands for: the elements of conditions, by their places on the way.
struct Member {
  std::size_t condition = 0;
  Element element;
};
using Members = std::vector<Member>;

/// The members of each join; nothing if the joins do not fit the conditions.
std::optional<std::vector<Members>> members_of(const Alternative& way, const std::vector<JoinCounts>& joins) {
  std::vector<Members> members;
  if (!joins.empty() && joins.front().initial) members.emplace_back();
  for (std::size_t i = 0; i < way.conditions.size(); ++i)
    for (const Element& element : elements_of(*way.conditions[i])) {
      if (!element.test) {
        if (members.size() == joins.size() || joins[members.size()].initial) return std::nullopt;
        members.emplace_back();
      }
      if (members.empty()) return std::nullopt;
      members.back().push_back({i, element});
    }
  if (members.size() != joins.size()) return std::nullopt;
  for (std::size_t i = 0; i < joins.size(); ++i) {
    std::size_t places = 0;
    for (const Member& member : members[i]) places += member.element.test ? member.element.places : 0;
    if (places > joins[i].reached.size()) return std::nullopt;
  }
  return members;
}

/// What got past each condition of a way.
std::vector<std::int64_t> passed_on(const Alternative& way, const std::vector<JoinCounts>& joins,
                                    const std::vector<Members>& members) {
  std::vector<std::int64_t> passed(way.conditions.size());
  for (std::size_t i = 0; i < joins.size(); ++i) {
    // What got past a condition has reached the test after it.
    std::size_t place = joins[i].reached.size();
    std::int64_t past = joins[i].passed;
    for (auto member = members[i].rbegin(); member != members[i].rend(); ++member) {
      passed[member->condition] = past;
      if (member->element.test) past = joins[i].reached[place -= member->element.places];
    }
  }
  return passed;
}

void add_leaves(const std::vector<Condition>& conditions, int number, std::vector<const Condition*>& leaves,
                std::vector<Coverage::Condition>& out) {
  for (const Condition& condition : conditions) {
    const int of_rule = number > 0 ? number : static_cast<int>(&condition - conditions.data()) + 1;
    if (condition.kind == Kind::kAnd || condition.kind == Kind::kOr) {
      add_leaves(condition.parts, of_rule, leaves, out);
      continue;
    }
    leaves.push_back(&condition);
    out.push_back({of_rule, condition.line, condition.begin, condition.end, condition.text});
  }
}

void add_conditions(const RuleCounts& counts, Coverage::Rule& rule) {
  const auto conditions = conditions_of(counts.info.text, counts.info.file, counts.info.line);
  if (!conditions) return;
  std::vector<const Condition*> leaves;
  add_leaves(*conditions, 0, leaves, rule.conditions);
  const std::vector<Alternative> ways = alternatives_of(*conditions);
  if (ways.size() != counts.disjuncts.size()) return;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto members = members_of(ways[i], counts.disjuncts[i]);
    if (!members) {
      rule.ways.clear();
      return;
    }
    Coverage::Way way;
    way.passed = passed_on(ways[i], counts.disjuncts[i], *members);
    for (const Condition* condition : ways[i].conditions)
      way.conditions.push_back(static_cast<std::size_t>(std::ranges::find(leaves, condition) - leaves.begin()));
    rule.ways.push_back(std::move(way));
  }
}

// --- Sums

template <class Entry>
auto key_of(const Entry& entry) {
  return std::tie(entry.file, entry.line, entry.name, entry.text);
}

/// The entry of that place in a sorted list, which is added where there is none.
template <class Entry>
Entry* same_in(std::vector<Entry>& list, const Entry& entry) {
  const auto at = std::ranges::lower_bound(list, key_of(entry), {}, [](const Entry& one) { return key_of(one); });
  if (at != list.end() && key_of(*at) == key_of(entry)) return &*at;
  list.insert(at, entry);
  return nullptr;
}

void add_rule(std::vector<Coverage::Rule>& rules, const Coverage::Rule& rule) {
  Coverage::Rule* same = same_in(rules, rule);
  if (same == nullptr) return;
  same->activated += rule.activated;
  same->fired += rule.fired;
  if (same->ways.empty())
    same->ways = rule.ways;
  else
    for (std::size_t i = 0; i < std::min(same->ways.size(), rule.ways.size()); ++i)
      for (std::size_t k = 0; k < same->ways[i].passed.size(); ++k) same->ways[i].passed[k] += rule.ways[i].passed[k];
}

void add_function(std::vector<Coverage::Function>& functions, const Coverage::Function& function) {
  if (Coverage::Function* same = same_in(functions, function)) same->calls += function.calls;
}

std::string share_text(const char* what, const Coverage::Share& share, const char* covered) {
  const auto percent = share.percent();
  return std::string(what) + ": " + std::to_string(share.covered) + " of " + std::to_string(share.all) + ' ' + covered +
         " (" + (percent ? fixed_text(*percent, 1) + " %" : "-") + ')';
}

}  // namespace

const char* Coverage::Rule::state() const {
  return fired > 0 ? "fired" : activated > 0 ? "activated but never fired" : "never matched";
}

std::int64_t Coverage::Rule::passed(std::size_t condition) const {
  std::int64_t sum = 0;
  std::set<std::vector<std::size_t>> seen;  // ways part only where they differ
  for (const Way& way : ways) {
    const auto at = std::ranges::find(way.conditions, condition);
    if (at == way.conditions.end() || !seen.emplace(way.conditions.begin(), at + 1).second) continue;
    sum += way.passed[static_cast<std::size_t>(at - way.conditions.begin())];
  }
  return sum;
}

std::size_t Coverage::Rule::failed_at() const {
  std::size_t at = conditions.size();
  if (fired > 0 || activated > 0) return at;
  std::pair<int, std::size_t> furthest{};
  for (const Way& way : ways) {
    const auto depth = static_cast<std::size_t>(std::ranges::find(way.passed, 0) - way.passed.begin());
    if (depth == way.passed.size()) continue;
    const std::pair reached{conditions[way.conditions[depth]].number, depth};
    if (at < conditions.size() && reached <= furthest) continue;
    furthest = reached;
    at = way.conditions[depth];
  }
  return at;
}

void Coverage::add(const Coverage& other) {
  for (const Rule& rule : other.rules) add_rule(rules, rule);
  for (const Function& function : other.functions) add_function(functions, function);
}

Coverage::Share Coverage::fired() const {
  return {static_cast<std::size_t>(std::ranges::count_if(rules, [](const Rule& rule) { return rule.fired > 0; })),
          rules.size()};
}

Coverage::Share Coverage::conditions() const {
  Share share;
  for (const Rule& rule : rules) {
    if (!rule.counts_conditions()) continue;
    share.all += rule.conditions.size();
    for (std::size_t i = 0; i < rule.conditions.size(); ++i) share.covered += rule.passed(i) > 0;
  }
  return share;
}

Coverage::Share Coverage::called() const {
  return {static_cast<std::size_t>(std::ranges::count_if(functions, [](const Function& f) { return f.calls > 0; })),
          functions.size()};
}

Coverage coverage_of(const EngineCounts& counts, const std::function<std::string(const std::string&)>& name) {
  const auto is_of_a_file = [](const ConstructInfo& info) {
    return info.line > 0 && std::filesystem::path(info.file).is_absolute();
  };
  Coverage coverage;
  for (const RuleCounts& one : counts.rules) {
    if (!is_of_a_file(one.info)) continue;
    Coverage::Rule rule{name(one.info.file),
                        with_module(one.info.module, one.info.name),
                        one.info.text,
                        one.info.line,
                        one.activated,
                        one.fired,
                        {},
                        {}};
    add_conditions(one, rule);
    add_rule(coverage.rules, rule);
  }
  for (const FunctionCounts& one : counts.functions)
    if (is_of_a_file(one.info))
      add_function(coverage.functions, {name(one.info.file), with_module(one.info.module, one.info.name), one.info.text,
                                        one.info.line, one.calls});
  return coverage;
}

std::vector<std::vector<JoinLabel>> join_labels(const RuleCounts& rule) {
  std::vector<std::vector<JoinLabel>> labels;
  for (const auto& disjunct : rule.disjuncts) labels.emplace_back(disjunct.size());
  const auto conditions = conditions_of(rule.info.text, rule.info.file, rule.info.line);
  if (!conditions) return labels;
  const std::vector<Alternative> ways = alternatives_of(*conditions);
  if (ways.size() != labels.size()) return labels;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const auto members = members_of(ways[i], rule.disjuncts[i]);
    for (std::size_t k = 0; members && k < members->size(); ++k)
      for (const Member& member : (*members)[k]) {
        const Condition& condition = *ways[i].conditions[member.condition];
        JoinLabel& label = labels[i][k];
        if (label.number == 0) label = {ways[i].numbers[member.condition], condition.line, {}};
        if (label.text.ends_with(condition.text)) continue;
        label.text += (label.text.empty() ? "" : " ") + condition.text;
      }
  }
  return labels;
}

std::string text_of(const Coverage& coverage) {
  std::string out;
  const auto place = [](const std::string& file, int line) { return file + ':' + std::to_string(line) + ": "; };
  std::size_t activated = 0;
  for (const Coverage::Rule& rule : coverage.rules) {
    activated += rule.fired == 0 && rule.activated > 0;
    const std::size_t failed = rule.failed_at();
    if (rule.fired == 0) {
      out += place(rule.file, rule.line) + rule.name + ": " + rule.state();
      if (failed < rule.conditions.size()) {
        const Coverage::Condition& condition = rule.conditions[failed];
        out += ": nothing got past condition " + std::to_string(condition.number) + ", " + condition.text;
      }
      out += '\n';
    }
    if (rule.activated == 0 && rule.fired == 0) continue;
    for (std::size_t i = 0; i < rule.conditions.size(); ++i)
      if (rule.counts_conditions() && rule.passed(i) == 0)
        out += place(rule.file, rule.conditions[i].line) + rule.name + ": nothing got past condition " +
               std::to_string(rule.conditions[i].number) + ", " + rule.conditions[i].text + '\n';
  }
  for (const Coverage::Function& function : coverage.functions)
    if (function.calls == 0) out += place(function.file, function.line) + function.name + ": never called\n";
  const Coverage::Share fired = coverage.fired();
  out += "rules: " + std::to_string(fired.covered) + " fired, " + std::to_string(activated) +
         " activated but never fired, " + std::to_string(fired.all - fired.covered - activated) + " never matched\n";
  out += share_text("rules", fired, "fired") + ", " + share_text("conditions", coverage.conditions(), "passed") + ", " +
         share_text("functions", coverage.called(), "called") + '\n';
  return out;
}

}  // namespace cxlab::explain
