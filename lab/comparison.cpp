#include "lab/comparison.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/explain/names.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/layout.h"
#include "cx/inspect/text.h"
#include "cx/journal/journal_reader.h"
#include "lab/moment.h"

namespace cxlab::lab {

namespace {

using inspect::Inspector;
using inspect::Timeline;

/// What says how long something took on this machine, or follows from all the rest.
bool is_incidental(const std::string& key) {
  static constexpr std::string_view kKeys[] = {"wall_time_s",   "physics_wall_s", "real_time_factor",
                                               "peak_rss_mb",   "journal_hash",   "physics_hash",
                                               "stream_hashes", "schema",         "scenario"};
  return std::ranges::find(kKeys, key) != std::end(kKeys);
}

void flatten(const Json& json, const std::string& path, std::map<std::string, std::string>& out,
             std::vector<std::string>& order) {
  if (json.is_structured()) {
    std::size_t i = 0;
    for (const auto& [key, value] : json.items()) {
      if (path.empty() && is_incidental(key)) continue;
      const std::string index = '[' + std::to_string(i++) + ']';
      flatten(value, json.is_array() ? path + index : path.empty() ? key : path + '.' + key, out, order);
    }
    return;
  }
  if (out.emplace(path, json_text(json)).second) order.push_back(path);
}

std::vector<Comparison::Outcome> outcomes_that_differ(const Run& a, const Run& b) {
  std::map<std::string, std::string> of_a, of_b;
  std::vector<std::string> order;
  for (const auto& [run, out] : {std::pair(&a, &of_a), std::pair(&b, &of_b)})
    flatten(parse_json(run->result), {}, *out, order);
  std::vector<Comparison::Outcome> differ;
  for (const std::string& path : order) {
    const auto there = of_a.find(path), here = of_b.find(path);
    Comparison::Outcome outcome{path, there == of_a.end() ? "" : there->second, here == of_b.end() ? "" : here->second};
    const bool known = std::ranges::find(differ, path, &Comparison::Outcome::path) != differ.end();
    if (outcome.a != outcome.b && !known) differ.push_back(std::move(outcome));
  }
  return differ;
}

void compare_constructs(Inspector& a, Inspector& b, std::vector<Comparison::Construct>& out) {
  struct Text {
    std::string place, text;
  };
  const auto texts = [](Inspector& inspector) {
    std::map<std::pair<std::string, std::string>, Text> all;
    for (const ConstructInfo& info : inspector.engine().constructs()) {
      const std::string name = explain::with_module(info.module, info.name);
      const std::string place =
          info.file.empty() ? "?" : inspector.shown_file(info.file) + ':' + std::to_string(info.line);
      all[{info.kind, name}] = {place, info.text};
    }
    return all;
  };
  const auto of_a = texts(a), of_b = texts(b);
  const auto add = [&out](const std::pair<std::string, std::string>& key, const std::string& in_a,
                          const std::string& in_b) {
    const auto same = [&](const Comparison::Construct& c) { return c.kind == key.first && c.name == key.second; };
    if (std::ranges::none_of(out, same)) out.push_back({key.first, key.second, in_a, in_b});
  };
  for (const auto& [key, text] : of_a) {
    const auto other = of_b.find(key);
    if (other == of_b.end() || other->second.text != text.text)
      add(key, text.place, other == of_b.end() ? "" : other->second.place);
  }
  for (const auto& [key, text] : of_b)
    if (!of_a.contains(key)) add(key, "", text.place);
}

/// What the environments of one name have recorded in both runs, compared while both are played.
class Streams {
 public:
  Streams(Moment& a, Moment& b) : a_(a), b_(b) {}

  struct Parting {
    std::string environment;
    std::uint64_t in_a = 0, in_b = 0;  ///< the first record that differs, or that only one of them has
    SimTime t{};
  };
  /// Where they part first, as far as both have been played; looks at each record once.
  std::optional<Parting> part() {
    find_pairs();
    std::optional<Parting> first;
    for (Pair& pair : pairs_) {
      const Timeline &a = *pair.a, &b = *pair.b;
      std::uint64_t &n = pair.compared_a, &m = pair.compared_b;
      n = std::max(n, a.begin());
      m = std::max(m, b.begin());
      while (true) {  // what a rerun was to do is no event of the rules: what they make of it is
        while (a.has(n) && a.is_planned(n)) ++n;
        while (b.has(m) && b.is_planned(m)) ++m;
        if (!a.has(n) || !b.has(m) || !a.same(n, b, m)) break;
        ++n, ++m;
      }
      if (!a.has(n) && !b.has(m)) continue;
      const SimTime t = std::min(a.has(n) ? a.time(n) : kNever, b.has(m) ? b.time(m) : kNever);
      if (!first || t < first->t) first = {pair.environment, n, m, t};
    }
    return first;
  }

 private:
  struct Pair {
    std::string environment;
    const Timeline *a = nullptr, *b = nullptr;
    std::uint64_t compared_a = 0, compared_b = 0;  // records before them are the same
  };
  /// Environments come and go while a run is played.
  void find_pairs() {
    const auto of_a = a_.episode().environments(), of_b = b_.episode().environments();
    if (of_a == of_a_ && of_b == of_b_) return;
    of_a_ = of_a;
    of_b_ = of_b;
    for (cx::Environment* one : of_a)
      for (cx::Environment* other : of_b) {
        const Timeline *a = &a_.inspector(*one).timeline(), *b = &b_.inspector(*other).timeline();
        if (one->unique_name() == other->unique_name() && std::ranges::find(pairs_, a, &Pair::a) == pairs_.end())
          pairs_.push_back({one->unique_name(), a, b});
      }
  }

  Moment &a_, &b_;
  std::vector<cx::Environment*> of_a_, of_b_;
  std::vector<Pair> pairs_;
};

Comparison::Side side_of(const Inspector& inspector, std::uint64_t n) {
  Comparison::Side side;
  if (!inspector.timeline().has(n)) return side;
  side.because = inspector.why(n);
  side.what = inspect::line_of(side.because->steps.front());
  return side;
}

/// The data of the records around the first letter in which they differ, where the events are called the same: what
/// came from outside, say.
void remark_on_data(const Timeline& a, const Timeline& b, const Streams::Parting& parted, Comparison::First& first) {
  if (!a.has(parted.in_a) || !b.has(parted.in_b) || first.a.what != first.b.what) return;
  const std::string of_a = to_json(a.read(parted.in_a).data), of_b = to_json(b.read(parted.in_b).data);
  constexpr std::size_t kBefore = 60, kShown = 160;
  const auto at = static_cast<std::size_t>(std::ranges::mismatch(of_a, of_b).in1 - of_a.begin());
  const std::size_t from = at > kBefore ? at - kBefore : 0;
  const auto part = [&](const std::string& text) {
    return (from > 0 ? "..." : "") + text.substr(from, kShown) + (from + kShown < text.size() ? "..." : "");
  };
  first.a.remark = part(of_a);
  first.b.remark = part(of_b);
}

/// The rule that fires at record `n`; empty: it is no firing.
std::string rule_at(const Timeline& timeline, std::uint64_t n) {
  return timeline.has(n) && timeline.kind(n) == RecordKind::kFire ? timeline.name(n) : std::string();
}

/// The rule that made the fact of record `n`; empty: it is no assertion, or no rule made it.
std::string maker_at(const Timeline& timeline, std::uint64_t n) {
  if (!timeline.has(n) || (timeline.kind(n) != RecordKind::kAssert && timeline.kind(n) != RecordKind::kDecision))
    return {};
  for (const Timeline::Cause& cause : timeline.causes(n))
    if (!cause.stream) return rule_at(timeline, cause.n);
  return {};
}

/// A rule makes a fact in one run. In the other run it does something more, and then makes another fact of that
/// template. These two facts are what differs, and not the first thing more.
void pair_facts(const Timeline& a, const Timeline& b, Streams::Parting& parted) {
  const auto partner = [](const Timeline& one, std::uint64_t n, const Timeline& other, std::uint64_t& m) {
    const std::string rule = maker_at(one, n);
    if (rule.empty() || !other.has(m) || (maker_at(other, m) == rule && other.name(m) == one.name(n))) return false;
    for (std::uint64_t k = m + 1; other.has(k) && other.time(k) == one.time(n); ++k)
      if (other.name(k) == one.name(n) && maker_at(other, k) == rule) {
        if (!one.same(n, other, k)) m = k;
        return m == k;
      }
    return false;
  };
  if (!partner(a, parted.in_a, b, parted.in_b)) partner(b, parted.in_b, a, parted.in_a);
}

/// What the rule lacks for the values with which it fired in the other run; as many of the first of them as its
/// conditions bind here.
std::optional<explain::UnmetCondition> lacks_for(RuleEngine& engine, const ConstructInfo& rule,
                                                 explain::Values values) {
  while (true) {
    auto lacks = explain::unmet_condition(engine, rule, explain::Wanted(values.begin(), values.end()));
    if (lacks || values.empty()) return lacks;
    values.pop_back();
  }
}

/// Says why `rule`, which fired in the other run at `t` with these values, has not fired in this one, which has been
/// played up to then; nothing if it has.
void remark_on_rule(const Inspector& inspector, const std::string& rule, const Comparison::Side& fired, SimTime t,
                    Comparison::Side& side) {
  RuleEngine& engine = inspector.engine();
  const ConstructInfo* info = engine.find_construct("defrule", rule);
  if (!info || !engine.has("defrule", rule)) {
    side.remark = "there is no rule " + rule;
    return;
  }
  if (const auto last = inspector.last_firing(rule); last && inspector.timeline().time(*last) == t) return;
  if (!engine.acting_call(*info).empty()) return;
  inspector.assert_time();
  if (!(side.lacks = lacks_for(engine, *info, fired.because->steps.front().values))) return;
  side.rule = rule;
  side.remark = "rule " + rule + " did not fire: condition " + std::to_string(side.lacks->number) +
                " does not hold: " + side.lacks->print();
}

}  // namespace

Expected<Comparison> compare(const Run& a, const Run& b, const Host& host) {
  Comparison out;
  out.outcomes = outcomes_that_differ(a, b);
  Host silent = host;
  silent.progress = nullptr;
  auto two = TwoMoments::open(a, b, silent);
  if (!two) return two.error();
  const SimTime end = two->end();
  Streams streams(*two->a, *two->b);
  std::optional<Streams::Parting> parting;
  for (SimTime t = SimTime(-1); t <= end && !parting; t = std::min(two->a->next_tick(), two->b->next_tick())) {
    if (Status s = two->seek(t); !s) return s.error();
    if ((out.stopped = two->stopped())) return out;
    host.show(to_seconds(two->a->t()), to_seconds(end));
    parting = streams.part();
  }
  out.compared = two->t();
  auto environments = two->environments();
  if (!environments) return environments.error();
  out.only_in_a = std::move(environments->only_in_a);
  out.only_in_b = std::move(environments->only_in_b);
  for (auto& [in_a, in_b] : environments->both) {
    compare_constructs(in_a, in_b, out.constructs);
    if (!parting || parting->environment != in_a.name()) continue;
    pair_facts(in_a.timeline(), in_b.timeline(), *parting);
    out.first = {in_a.name(), parting->t, side_of(in_a, parting->in_a), side_of(in_b, parting->in_b)};
    remark_on_data(in_a.timeline(), in_b.timeline(), *parting, *out.first);
    const std::string rule_of_a = rule_at(in_a.timeline(), parting->in_a);
    const std::string rule_of_b = rule_at(in_b.timeline(), parting->in_b);
    if (rule_of_a == rule_of_b) continue;
    auto& [environment, t, side_a, side_b] = *out.first;
    if (!rule_of_b.empty()) remark_on_rule(in_a, rule_of_b, side_b, t, side_a);
    if (!rule_of_a.empty()) remark_on_rule(in_b, rule_of_a, side_a, t, side_b);
  }
  return out;
}

namespace {

std::string laid_out(const std::string& text, const std::string& indent = {}) {
  return inspect::laid_out(text, indent, indent + "  ");
}

/// What one run did, and why not what the other did.
std::string text_of_event(const char* name, const Comparison::Side& side) {
  std::string out = laid_out(std::string(name) + ": " + (side.what.empty() ? "nothing more" : side.what));
  if (side.lacks)
    out += inspect::text_of(
        *side.lacks,
        "rule " + side.rule + " did not fire: condition " + std::to_string(side.lacks->number) + " does not hold",
        "   ");
  else if (!side.remark.empty())
    out += laid_out(side.remark, "   ");
  return out;
}

std::string text_of_causes(const char* name, const Comparison::Side& side) {
  if (!side.because || side.because->steps.size() < 2) return {};
  return std::string("what led to it in ") + name + ":\n" + inspect::text_of(inspect::tree_of(*side.because, false));
}

std::string text_of_construct(const Comparison::Construct& c) {
  const bool in_one = c.a.empty() || c.b.empty();
  return laid_out(c.kind + ' ' + c.name +
                  (in_one ? " is only in " + (c.a.empty() ? "b: " + c.b : "a: " + c.a)
                          : " is written differently: " + c.a + " (a), " + c.b + " (b)"));
}

constexpr std::size_t kPath = 44, kValue = 16;  // columns

std::string outcome_row(std::string path, const std::string& a, const std::string& b) {
  path.resize(std::max(path.size(), kPath), ' ');
  const auto cell = [](const std::string& text) {
    return ' ' + std::string(kValue - std::min(kValue, text.size()), ' ') + text;
  };
  return path + cell(a) + cell(b) + '\n';
}

std::string text_of_outcomes(const std::vector<Comparison::Outcome>& outcomes) {
  constexpr std::size_t kShown = 30;
  std::string out = outcome_row("result", "a", "b");
  for (std::size_t i = 0; i < outcomes.size() && i < kShown; ++i) {
    const Comparison::Outcome& o = outcomes[i];
    const std::string a = o.a.empty() ? "-" : o.a, b = o.b.empty() ? "-" : o.b;
    if (o.path.size() <= kPath && a.size() <= kValue && b.size() <= kValue)
      out += outcome_row(o.path, a, b);
    else
      out += o.path + '\n' + laid_out("a: " + a, "  ") + laid_out("b: " + b, "  ");
  }
  if (outcomes.size() > kShown) out += "and " + std::to_string(outcomes.size() - kShown) + " more (--json has all)\n";
  return out;
}

}  // namespace

std::string text_of(const Comparison& found) {
  std::string out;
  for (const std::string& name : found.only_in_a) out += "environment " + name + " is only in a\n";
  for (const std::string& name : found.only_in_b) out += "environment " + name + " is only in b\n";
  for (const Comparison::Construct& c : found.constructs) out += text_of_construct(c);
  if (!found.first)
    out += "all that rules did up to " + inspect::seconds_text(found.compared) + " is the same\n";
  else
    out += "the same before " + inspect::seconds_text(found.first->t) + "; what differs first, in " +
           found.first->environment + ":\n" + text_of_event("a", found.first->a) + text_of_event("b", found.first->b) +
           text_of_causes("a", found.first->a) + text_of_causes("b", found.first->b);
  return found.outcomes.empty() ? out : out + text_of_outcomes(found.outcomes);
}

}  // namespace cxlab::lab
