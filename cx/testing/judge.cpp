#include "cx/testing/judge.h"

#include <algorithm>
#include <cstdlib>
#include <ranges>
#include <set>

#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/explain/why_not.h"
#include "cx/testing/mistakes.h"
#include "cx/yaml/yaml.h"

namespace cxlab::testing {

namespace {

using Kind = Expectation::Kind;

bool contains_value(const yaml::Value& found, const yaml::Value& wanted) {
  if (wanted.is_map()) {
    if (!found.is_map()) return false;
    yaml::Map map = found.as_map();
    for (const auto& [key, value] : wanted.as_map().entries())
      if (const yaml::Value there = map.get(key); !there || !contains_value(there, value)) return false;
    return true;
  }
  if (wanted.is_list()) {
    const auto a = found.is_list() ? found.as_list() : std::vector<yaml::Value>();
    const auto b = wanted.as_list();
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) { return contains_value(x, y); });
  }
  if (found.text() == wanted.text()) return true;
  char *a_end = nullptr, *b_end = nullptr;
  const std::string a = found.text(), b = wanted.text();
  const double x = std::strtod(a.c_str(), &a_end), y = std::strtod(b.c_str(), &b_end);
  return !a.empty() && !b.empty() && !*a_end && !*b_end && x == y;
}

/// How many of the values of `wanted` are in `found`.
int count_same(const yaml::Value& found, const yaml::Value& wanted) {
  if (!wanted.is_map() || !found.is_map()) return contains_value(found, wanted) ? 1 : 0;
  int same = 0;
  yaml::Map map = found.as_map();
  for (const auto& [key, value] : wanted.as_map().entries())
    if (const yaml::Value there = map.get(key)) same += count_same(there, value);
  return same;
}

/// The one with the most values that are wanted; the first of several. There is at least one.
const Heard& nearest(const std::vector<const Heard*>& others, const std::string& wanted) {
  constexpr std::size_t kMost = 1000;  // to compare all would take long
  const Heard* nearest = others.front();
  const auto fields = yaml::Document::parse(wanted, "fields");
  if (wanted.empty() || !fields) return *nearest;
  int most = -1;
  for (std::size_t i = 0; i < std::min(kMost, others.size()); ++i) {
    const auto content = yaml::Document::parse(others[i]->content, "message");
    const int same = content ? count_same(content->root(), fields->root()) : 0;
    if (same > most) nearest = others[i];
    most = std::max(most, same);
  }
  return *nearest;
}

/// That nobody publishes the topic, where this is so, and what is published instead.
std::string unpublished(const std::string& topic, const Play& play) {
  const std::vector<std::string> topics = play.stand_ins().published();
  if (std::ranges::count(topics, topic) + std::ranges::count(topics, '/' + topic) > 0) return {};
  return "; nobody publishes this topic" + (topics.empty() ? "" : ", only " + some_of_and_nearest(topic, topics));
}

std::string span(const Expectation& e) {
  if (e.at) return " at " + seconds(e.until);
  std::string out = e.after > SimTime::zero() ? " after " + seconds(e.after) : "";
  if (e.until != kNever) out += " by " + seconds(e.until);
  return out;
}

bool within(const Expectation& e, SimTime t) { return t >= e.after && t <= e.until; }

/// Whether the fact was there at the time that is expected.
bool within(const Expectation& e, const explain::FactVersion& version) {
  if (e.at) return version.from <= e.until && version.until > e.until;
  return version.from <= e.until && (version.until > e.after || version.from >= e.after);
}

/// The fault, or an empty text.
std::string judge_fact(const Expectation& e, const Play& play) {
  const auto pattern = *explain::Pattern::parse_plain(e.text, play.spec().file, e.line);
  const explain::FactVersion* found = nullptr;
  std::vector<const FactCopy*> others;
  for (const explain::FactVersion& version : play.history().facts()) {
    if (version.fact.template_name != pattern.template_name()) continue;
    if (!within(e, version) || !pattern.matches(version.fact))
      others.push_back(&version.fact);
    else if (!found)
      found = &version;
  }
  const std::string no_template = "there is no template '" + pattern.template_name() + '\'';
  const bool known = play.engine().has("deftemplate", pattern.template_name());
  if (known)
    if (Status s = explain::check_names(pattern, play.engine()); !s) return e.text + ": " + s.error().message;
  if (e.kind == Kind::kNoFact) {
    if (found)
      return "expected no fact " + e.text + span(e) + "; there was " + found->fact.print() + " from " +
             seconds(found->from);
    return known || makes_facts_of_text(play) ? "" : no_template + ", so this says nothing";
  }
  if (found) return {};
  const std::string expected = "expected fact " + e.text + span(e) + "; ";
  if (others.empty()) return expected + (known ? "there was no fact of this template" : no_template);
  const explain::Nearest near = nearest(pattern, others);
  const auto& version = *std::find_if(play.history().facts().begin(), play.history().facts().end(),
                                      [&](const auto& v) { return &v.fact == near.fact; });
  return expected + "nearest: " + near.fact->print() + " at " + seconds(version.from) +
         (version.until == kNever ? "" : " until " + seconds(version.until)) +
         (near.mismatches.empty() ? ", at another time" : ": " + explain::print(near.mismatches));
}

std::string judge_rule(const Expectation& e, const Play& play) {
  int inside = 0;
  std::string times;
  for (const explain::Firing& firing : play.history().firings()) {
    if (!firing.is_of(e.text)) continue;
    inside += within(e, firing.t);
    if (times.size() < 60) times += (times.empty() ? "" : ", ") + seconds(firing.t);
  }
  if (e.kind == Kind::kNotFires)
    return inside == 0 ? "" : "expected that rule " + e.text + " does not fire" + span(e) + "; it fired at " + times;
  if (inside >= e.count) return {};
  const std::string expected =
      "expected rule " + e.text + " to fire" + (e.count > 1 ? " " + std::to_string(e.count) + " times" : "") + span(e);
  if (!times.empty()) return expected + "; it fired at " + times;
  const ConstructInfo* rule = play.engine().find_construct("defrule", e.text);
  const auto unmet = rule ? explain::unmet_condition(play.engine(), *rule) : std::nullopt;
  return expected + "; it never fired" +
         (unmet ? ": at the end its condition " + std::to_string(unmet->number) + " does not hold: " + unmet->print()
                : "");
}

std::string judge_heard(const Expectation& e, const Play& play, Heard::Kind kind, const std::string& word) {
  int inside = 0;
  std::vector<const Heard*> others;  // from the end
  // From the end: what is expected by a time is mostly the last before it, and to compare all would take long.
  for (const Heard& heard : play.stand_ins().heard() | std::views::reverse) {
    if (heard.kind != kind || heard.name != e.text) continue;
    if (!within(e, heard.t) || !contains(heard.content, e.fields))
      others.push_back(&heard);
    else if (++inside >= e.count)
      return {};
  }
  std::string what =
      "expected " + (e.count > 1 ? std::to_string(e.count) + " times a " : std::string("a ")) + word + " for " + e.text;
  if (!e.fields.empty()) what += " with " + e.fields;
  what += span(e) + "; ";
  if (inside > 0) what += "there " + std::string(inside == 1 ? "was 1; " : "were " + std::to_string(inside) + "; ");
  if (others.empty() && inside > 0) return what + "there was no other";
  if (others.empty()) return what + "there was none" + (kind == Heard::Kind::kTopic ? unpublished(e.text, play) : "");
  const Heard& near = nearest(others, e.fields);
  return what + "nearest: " + near.content + " at " + seconds(near.t);
}

std::string judge(const Expectation& e, const Play& play) {
  switch (e.kind) {
    case Kind::kFact:
    case Kind::kNoFact: return judge_fact(e, play);
    case Kind::kFires:
    case Kind::kNotFires: return judge_rule(e, play);
    case Kind::kGoal: return judge_heard(e, play, Heard::Kind::kGoal, "goal");
    case Kind::kPublished: return judge_heard(e, play, Heard::Kind::kTopic, "message");
  }
  return {};
}

}  // namespace

bool contains(const std::string& found, const std::string& wanted) {
  if (wanted.empty()) return true;
  const auto a = yaml::Document::parse(found, "message"), b = yaml::Document::parse(wanted, "fields");
  return a && b && contains_value(a->root(), b->root());
}

std::vector<std::string> slips_in_names(const Play& play) {
  std::vector<std::string> notes;
  const auto look = [&](bus::NameKind kind, const std::string& name, int line, bool unserved) {
    const std::string meant = play.stand_ins().meant_by(kind, name, unserved);
    if (meant.empty()) return;
    const bool is_topic = kind == bus::NameKind::kTopic;
    const std::string note = play.at(line, name + ": " +
                                               (is_topic ? "the rules do not subscribe to it, but to "
                                                         : "the rules have no client of it, but one of ") +
                                               meant + (unserved ? ", which nobody serves" : ""))
                                 .text();
    if (std::ranges::count(notes, note) == 0) notes.push_back(note);
  };
  const auto kind_of = [](const StandIn& s) { return s.action ? bus::NameKind::kAction : bus::NameKind::kService; };
  for (const StandIn& stand_in : play.spec().stand_ins)
    look(kind_of(stand_in), stand_in.name, stand_in.line, /*unserved=*/true);
  for (const Step& step : play.spec().steps)
    if (step.verb == Step::Verb::kPublish)
      look(bus::NameKind::kTopic, step.text, step.line, /*unserved=*/false);
    else if (step.verb == Step::Verb::kStandIn)
      look(kind_of(step.stand_in), step.stand_in.name, step.line, /*unserved=*/false);
  return notes;
}

std::vector<std::string> judge(const Play& play) {
  std::vector<std::string> failures;
  for (const Expectation& e : play.spec().expect)
    if (const std::string what = judge(e, play); !what.empty()) failures.push_back(play.at(e.line, what).text());
  return failures;
}

}  // namespace cxlab::testing
