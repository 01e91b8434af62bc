#include "lab/comparison.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "cx/base/file.h"
#include "cx/explain/names.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/text.h"
#include "cx/journal/journal_reader.h"
#include "lab/moment.h"

namespace cxlab::lab {

namespace {

using Json = nlohmann::ordered_json;
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
  if (out.emplace(path, json.dump(-1, ' ', false, Json::error_handler_t::replace)).second) order.push_back(path);
}

std::vector<Comparison::Outcome> outcomes_that_differ(const Run& a, const Run& b) {
  std::map<std::string, std::string> of_a, of_b;
  std::vector<std::string> order;
  for (const auto& [run, out] : {std::pair(&a, &of_a), std::pair(&b, &of_b)})
    flatten(Json::parse(run->result), {}, *out, order);
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

/// The environments of `here` that are not among `there`.
std::vector<std::string> names_missing(const std::vector<Inspector>& here, const std::vector<Inspector>& there) {
  std::vector<std::string> out;
  for (const Inspector& one : here)
    if (std::ranges::find(there, one.name(), &Inspector::name) == there.end()) out.push_back(one.name());
  return out;
}

std::string list(const std::vector<std::string>& names) { return some_of(names, names.size()); }

/// The first record in which two environments of one name differ; none if the shorter one is like the other's
/// beginning.
std::optional<std::uint64_t> parting(const Timeline& a, const Timeline& b) {
  const std::uint64_t end = std::min(a.end(), b.end());
  for (std::uint64_t n = std::max(a.begin(), b.begin()); n < end; ++n)
    if (!a.same(n, b)) return n;
  return a.end() == b.end() ? std::nullopt : std::optional(end);
}

Comparison::Side side_of(const Inspector& inspector, std::uint64_t n) {
  Comparison::Side side;
  if (!inspector.timeline().has(n)) return side;
  side.because = inspector.why(n);
  side.what = inspect::line_of(side.because->steps.front());
  return side;
}

/// The data of record `n` around the first letter in which that of the other run differs, where the events are called
/// the same: what came from outside, say.
void remark_on_data(const Timeline& a, const Timeline& b, std::uint64_t n, Comparison::First& first) {
  if (!a.has(n) || !b.has(n) || first.a.what != first.b.what) return;
  const std::string of_a = to_json(a.read(n).data), of_b = to_json(b.read(n).data);
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

/// Why `rule`, which fired in the other run at `t`, has not fired in this one; empty: it has.
Expected<std::string> why_not_here(Moment& moment, const std::string& environment, const std::string& rule, SimTime t) {
  if (Status s = moment.rewind(); !s) return s.error();
  if (Status s = moment.seek(t); !s) return s.error();
  auto inspectors = moment.inspectors(environment);
  if (!inspectors) return std::string();
  RuleEngine& engine = inspectors->front().engine();
  const ConstructInfo* info = engine.find_construct("defrule", rule);
  if (!info || !engine.has("defrule", rule)) return "there is no rule " + rule;
  if (const auto last = inspectors->front().last_firing(rule); last && inspectors->front().timeline().time(*last) == t)
    return std::string();
  if (!engine.acting_call(*info).empty()) return std::string();
  assert_time(*moment.episode().environments().front(), true);
  const auto unmet = explain::unmet_condition(engine, *info);
  return unmet ? "rule " + rule + " did not fire: condition " + std::to_string(unmet->number) +
                     " does not hold: " + unmet->print()
               : std::string();
}

}  // namespace

Expected<Comparison> compare(const Run& a, const Run& b, const Host& host) {
  Comparison out;
  out.outcomes = outcomes_that_differ(a, b);
  auto two = Moment::open_two(a, b, host);
  if (!two) return two.error();
  Moment& in_a = *two->first;
  Moment& in_b = *two->second;
  for (Moment* moment : {&in_a, &in_b}) {
    if (Status s = moment->seek(std::nullopt); !s) return s.error();
    if ((out.stopped = moment->stopped())) return out;
  }
  out.compared = std::min(in_a.t(), in_b.t());
  auto of_a = in_a.inspectors(), of_b = in_b.inspectors();
  if (!of_a || !of_b) return (of_a ? of_b : of_a).error();
  out.only_in_a = names_missing(*of_a, *of_b);
  out.only_in_b = names_missing(*of_b, *of_a);
  if (out.only_in_a.size() == of_a->size())
    return input_error("the runs have no environment in common: " + a.folder.string() + " has " + list(out.only_in_a) +
                       ", " + b.folder.string() + " has " + list(out.only_in_b));
  std::string rule_of_a, rule_of_b;
  for (Inspector& one : *of_a) {
    const auto other = std::ranges::find(*of_b, one.name(), &Inspector::name);
    if (other == of_b->end()) continue;
    compare_constructs(one, *other, out.constructs);
    const auto n = parting(one.timeline(), other->timeline());
    if (!n) continue;
    const auto time = [&](const Timeline& timeline) { return timeline.has(*n) ? timeline.time(*n) : kNever; };
    const SimTime t = std::min(time(one.timeline()), time(other->timeline()));
    // What comes after the end of the shorter run is no difference of the rules.
    if (t > out.compared || (out.first && t >= out.first->t)) continue;
    out.first = {one.name(), t, side_of(one, *n), side_of(*other, *n)};
    remark_on_data(one.timeline(), other->timeline(), *n, *out.first);
    rule_of_a = rule_at(one.timeline(), *n);
    rule_of_b = rule_at(other->timeline(), *n);
  }
  if (!out.first || rule_of_a == rule_of_b) return out;
  const SimTime t = out.first->t;
  if (!rule_of_b.empty()) {
    auto why = why_not_here(in_a, out.first->environment, rule_of_b, t);
    if (!why) return why.error();
    out.first->a.remark = *std::move(why);
  }
  if (!rule_of_a.empty()) {
    auto why = why_not_here(in_b, out.first->environment, rule_of_a, t);
    if (!why) return why.error();
    out.first->b.remark = *std::move(why);
  }
  return out;
}

}  // namespace cxlab::lab
