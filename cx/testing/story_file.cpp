#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <span>

#include "cx/base/number_text.h"
#include "cx/testing/story.h"
#include "cx/yaml/seeds.h"
#include "cx/yaml/yaml.h"

namespace cxlab::testing {

namespace {

std::string dumped(yaml::Map& map, const char* key) {
  const yaml::Value value = map.get(key);
  return value ? value.dump() : std::string();
}

/// The one key of several that a map has. `given` counts them.
struct Choice {
  std::string keys;       ///< all of them
  std::string key, text;  ///< the one, and its value
  std::size_t index = 0;
  int given = 0;
};

Choice choose(yaml::Map& map, std::span<const char* const> keys) {
  Choice choice;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    choice.keys += (i == 0 ? "" : ", ") + std::string(keys[i]);
    const yaml::Value value = map.get(keys[i]);
    if (!value) continue;
    ++choice.given;
    choice.index = i;
    choice.key = keys[i];
    choice.text = value.as_string();
  }
  return choice;
}

/// `takes_s: 2`, or `takes_s: [1, 4]` where chance decides.
void read_duration(yaml::Map& map, Outcome& outcome) {
  const yaml::Value value = map.get("takes_s");
  if (!value || !value.is_list()) {
    map.read_seconds("takes_s", outcome.takes);
    return;
  }
  const std::vector<yaml::Value> ends = value.as_list();
  const double low = ends.size() == 2 ? ends[0].as_number() : -1, high = ends.size() == 2 ? ends[1].as_number() : -1;
  if (low < 0 || high < low || high > 1e9) return value.fail("expected seconds from 0 to 1e9: 2, or [1, 4]");
  outcome.takes = from_seconds(low);
  outcome.longest = from_seconds(high);
}

/// `feedback: [{after_s: 1, data: {progress: 0.5}}]`
void read_feedback(const yaml::Value& list, Outcome& outcome) {
  if (outcome.kind == Outcome::Kind::kReject)
    list.fail(found_expected("`feedback` of a goal that is rejected", "it only for goals that run"));
  const SimTime end = outcome.kind == Outcome::Kind::kNever ? kNever : std::max(outcome.takes, outcome.longest);
  for (const yaml::Value& item : list.as_list()) {
    yaml::Map map = item.as_map();
    Feedback one{{}, dumped(map, "data"), item.line()};
    const yaml::Value after = map.require("after_s");
    map.read_seconds("after_s", one.after);
    if (one.after > end)
      after.fail(found_expected(after.text(), "no time after takes_s (" + general_text(to_seconds(end), 12) + ')'));
    outcome.feedback.push_back(std::move(one));
    map.finish();
  }
  std::ranges::stable_sort(outcome.feedback, {}, &Feedback::after);
}

Outcome read_outcome(yaml::Map& map) {
  static const std::vector<std::string> kWords = {"succeed", "fail", "reject", "never"};  // as in Outcome::Kind
  std::string word = kWords.front();
  map.read_word("outcome", word, kWords);
  Outcome outcome;
  outcome.kind = static_cast<Outcome::Kind>(std::ranges::find(kWords, word) - kWords.begin());
  outcome.line = map.value().line();
  read_duration(map, outcome);
  outcome.result = dumped(map, "result");
  if (const yaml::Value code = map.get("error_code")) {
    if (!outcome.result.empty()) code.fail("give it in `result` when there is one");
    outcome.result = "{error_code: " + std::to_string(code.as_integer()) + '}';
  }
  if (const yaml::Value list = map.get("feedback")) read_feedback(list, outcome);
  return outcome;
}

void check_of_service(const yaml::Map& map, const Outcome& outcome) {
  if (outcome.kind == Outcome::Kind::kReject) map.fail("a service cannot reject");
  if (!outcome.feedback.empty()) map.fail("a service gives no feedback");
}

void check_request_id(const yaml::Value& id) {
  if (id.as_integer(1) < 1) id.fail(found_expected(id.text(), "the number of a request, from 1"));
}

/// Reads the goals and requests that are in progress when the story begins, and how they end.
void read_under_way(const yaml::Value& list, StandIn& out) {
  for (const yaml::Value& item : list.as_list()) {
    yaml::Map map = item.as_map();
    UnderWay goal{{}, {}, item.line()};
    if (out.action)
      map.read("handle", goal.handle);
    else
      check_request_id(map.require("id"));
    map.read("id", goal.id);
    out.outcomes.insert(out.outcomes.begin() + static_cast<std::ptrdiff_t>(out.under_way.size()), read_outcome(map));
    out.under_way.push_back(std::move(goal));
    map.finish();
  }
}

StandIn read_stand_in(const yaml::Value& value, bool step = false) {
  yaml::Map map = value.as_map();
  if (step) map.get("at");
  const Choice kind = choose(map, step ? std::array{"skill", "serve"} : std::array{"action", "service"});
  if (kind.given != 1) map.fail("expected one of " + kind.keys);
  StandIn out{kind.index == 0,     kind.text,    map.require("type").as_string(),
              {read_outcome(map)}, value.file(), value.line()};
  if (const yaml::Value then = map.get("then"))
    for (const yaml::Value& item : then.as_list()) {
      yaml::Map next = item.as_map();
      out.outcomes.push_back(read_outcome(next));
      next.finish();
    }
  if (const yaml::Value list = map.get("under_way")) {
    if (step) list.fail(found_expected("`under_way` in a step", "it only in `skills` and `serve`"));
    read_under_way(list, out);
  }
  if (const yaml::Value next = out.action || step ? yaml::Value() : map.get("next_id")) {
    check_request_id(next);
    out.next_id = next.as_integer();
  }
  for (const Outcome& o : out.outcomes)
    if (!out.action) check_of_service(map, o);
  map.finish();
  return out;
}

Fault read_fault(const yaml::Value& item) {
  yaml::Map map = item.as_map();
  Fault fault;
  const Choice kind = choose(map, std::array{"skill", "service"});
  if (kind.given > 1) map.fail("expected one of " + kind.keys + ", or none of them for all skills");
  fault.name = kind.text;
  map.require("outcome");
  fault.outcome = read_outcome(map);
  if (kind.given == 1 && kind.index == 1) check_of_service(map, fault.outcome);
  const yaml::Value probability = map.require("probability");
  if (probability) fault.probability = probability.as_number();
  if (!(fault.probability >= 0 && fault.probability <= 1))
    probability.fail(found_expected(probability.text(), "a probability from 0 to 1"));
  map.read("times", fault.most);
  if (map.has("times") && fault.most < 1) map.fail("times: expected at least 1");
  map.finish();
  return fault;
}

/// `(bell)`, or `{fact: (bell), as: <Fact-1>}` for one to which later facts point.
GivenFact read_given(const yaml::Value& value, const std::vector<GivenFact>& before) {
  if (!value.is_map()) return {value.as_string(), value.line()};
  yaml::Map map = value.as_map();
  GivenFact fact{map.require("fact").as_string(), value.line()};
  const yaml::Value as = map.require("as");
  fact.as = as.as_string();
  if (as && (fact.as.size() < 3 || !fact.as.starts_with('<') || !fact.as.ends_with('>')))
    as.fail(found_text(fact.as, "a word in angle brackets, like <Fact-1>"));
  const auto same = std::ranges::find(before, fact.as, &GivenFact::as);
  if (as && same != before.end())
    as.fail("the fact on line " + std::to_string(same->line) + " has the name '" + fact.as + "', too");
  map.finish();
  return fact;
}

Step read_step(const yaml::Value& item) {
  yaml::Map map = item.as_map();
  Step step;
  step.line = item.line();
  map.require("at");
  map.read_seconds("at", step.at);
  if (map.has("skill") || map.has("serve")) {
    step.verb = Step::Verb::kStandIn;
    step.stand_in = read_stand_in(item, true);
    return step;
  }
  const Choice verb = choose(map, std::array{"assert", "retract", "publish", "skill", "serve"});  // as in Step::Verb
  step.verb = static_cast<Step::Verb>(verb.index);
  step.text = verb.text;
  if (step.verb == Step::Verb::kPublish) {
    step.type = map.require("type").as_string();
    step.data = dumped(map, "data");
  }
  if (map.finish() && verb.given != 1) map.fail("expected one of " + verb.keys);
  return step;
}

Expectation read_expectation(const yaml::Value& item) {
  using Kind = Expectation::Kind;
  yaml::Map map = item.as_map();
  const Choice kind =
      choose(map, std::array{"fact", "no_fact", "fires", "not_fires", "goal", "published"});  // as in Expectation::Kind
  Expectation e;
  e.line = item.line();
  e.kind = static_cast<Kind>(kind.index);
  e.text = kind.text;
  const bool message = e.kind == Kind::kGoal || e.kind == Kind::kPublished;
  if (message) e.fields = dumped(map, "fields");
  if (e.kind == Kind::kPublished) e.type = map.require("type").as_string();
  if (message || e.kind == Kind::kFires) map.read("count", e.count);
  if (e.count < 1) map.fail("count: expected at least 1");
  map.read_seconds("after", e.after).read_seconds("within_s", e.until);
  const bool about_fact = e.kind == Kind::kFact || e.kind == Kind::kNoFact;
  if (map.has("at") && !about_fact && kind.given == 1) {
    map.get("at").fail("it goes with `fact` and `no_fact` only; with `" + kind.key + "` go " +
                       (message                  ? "`count`, `fields`, "
                        : e.kind == Kind::kFires ? "`count`, "
                                                 : "") +
                       "`after` and `within_s`");
    return e;
  }
  if (about_fact && map.has("at")) {
    if (map.has("within_s") || map.has("after")) map.fail("`at` stands alone");
    map.read_seconds("at", e.until);
    e.at = true;
  }
  if (!map.finish()) return e;
  if (kind.given != 1) {
    map.fail("expected one of " + kind.keys);
    return e;
  }
  if (e.until < e.after) map.fail("within_s is before after");
  if (!e.at && !map.has("within_s") && e.kind != Kind::kNoFact && e.kind != Kind::kNotFires)
    map.fail(std::string("key 'within_s' is missing") + (about_fact ? " (or 'at')" : ""));
  return e;
}

/// Takes away what the story has of this key from `common`.
void replace(const yaml::Value& key, StorySpec& spec) {
  const auto forget = [&spec](bool actions) {
    std::erase_if(spec.stand_ins, [actions](const StandIn& s) { return s.action == actions; });
  };
  const std::map<std::string, std::function<void()>> lists{
      {"rules", [&] { spec.rules.clear(); }}, {"params", [&] { spec.params.clear(); }},
      {"given", [&] { spec.given.clear(); }}, {"skills", [&] { forget(true); }},
      {"serve", [&] { forget(false); }},      {"faults", [&] { spec.faults.clear(); }},
      {"steps", [&] { spec.steps.clear(); }}, {"expect", [&] { spec.expect.clear(); }}};
  const std::string word = key.as_string();
  if (const auto list = lists.find(word); list != lists.end()) return list->second();
  std::vector<std::string> words;
  for (const auto& [name, forgets] : lists) words.push_back(name);
  key.fail(found_text(word, "some of: " + some_of_and_nearest(word, words)));
}

void read_story(yaml::Map& map, StorySpec& spec) {
  const std::filesystem::path folder = std::filesystem::path(spec.file).parent_path();
  std::string config;
  map.read("config", config);
  if (!config.empty()) spec.config = folder / config;
  if (const yaml::Value rules = map.get("rules"))
    for (const std::string& file : rules.as_strings()) spec.rules.push_back(folder / file);
  if (const yaml::Value params = map.get("params"))
    for (const auto& [name, param] : params.as_map().entries())
      spec.params.push_back({name, param.dump(), param.origin()});
  if (const yaml::Value packages = map.get("packages")) {
    yaml::Map names = packages.as_map();
    for (const auto& [name, path] : names.entries()) spec.packages[name] = folder / path.as_string();
  }
  std::string golden;
  map.read("golden", golden);
  if (!golden.empty()) spec.golden = (folder / golden).lexically_normal();
  map.read("environment", spec.environment).read_seconds("end", spec.end);
  if (const yaml::Value seed = map.get("seed")) {
    map.read("seed", spec.seed);
    spec.seeds.clear();
    if (map.has("seeds")) seed.fail(found_expected("beside seeds", "one of the two"));
  }
  if (const yaml::Value seeds = map.get("seeds")) {
    spec.seeds = yaml::read_seeds(seeds);
    if (spec.seeds.empty()) seeds.fail("expected at least one seed");
    std::ranges::sort(spec.seeds);
  }
  if (const yaml::Value tick = map.get("tick_s")) {
    map.read_seconds("tick_s", spec.tick);
    if (spec.tick <= SimTime::zero()) tick.fail(found_expected(tick.text(), "seconds above 0"));
  }
  map.read_seconds("begins_s", spec.begins).read("moment", spec.moment).read("leaves_nothing", spec.leaves_nothing);
  if (const yaml::Value given_at = map.get("given_at_s")) {
    map.read_seconds("given_at_s", spec.given_at);
    if (spec.given_at < spec.begins) given_at.fail(found_expected(given_at.text(), "no time before begins_s"));
  }
  if (const yaml::Value calls = map.get("calls"))
    for (const yaml::Value& call : calls.as_list()) spec.calls.push_back({call.as_string(), call.line()});
  if (const yaml::Value given = map.get("given"))
    for (const yaml::Value& fact : given.as_list()) spec.given.push_back(read_given(fact, spec.given));
  for (const char* key : {"skills", "serve"})
    if (const yaml::Value list = map.get(key))
      for (const yaml::Value& item : list.as_list()) spec.stand_ins.push_back(read_stand_in(item));
  if (const yaml::Value faults = map.get("faults"))
    for (const yaml::Value& item : faults.as_list()) spec.faults.push_back(read_fault(item));
  if (const yaml::Value steps = map.get("steps"))
    for (const yaml::Value& item : steps.as_list()) spec.steps.push_back(read_step(item));
  std::ranges::stable_sort(spec.steps, {}, &Step::at);
  if (const yaml::Value expect = map.get("expect"))
    for (const yaml::Value& item : expect.as_list()) spec.expect.push_back(read_expectation(item));
}

/// A fact can point only to one that is given before it.
void check_pointers(const yaml::Map& map, const StorySpec& spec) {
  for (std::size_t i = 0; i < spec.given.size(); ++i)
    for (std::size_t k = i; k < spec.given.size(); ++k)
      if (!spec.given[k].as.empty() && spec.given[i].text.find(spec.given[k].as) != std::string::npos)
        return map.fail(spec.given[i].text + " points to " + spec.given[k].as + ", which is given later (line " +
                        std::to_string(spec.given[k].line) + "): give it before");
}

/// Running goals are sent at the first tick. Facts are given later, when these goals have been answered.
void check_under_way(const yaml::Map& map, StorySpec& spec) {
  spec.given_at = std::max(spec.given_at, spec.begins);
  if (spec.given_at > spec.begins && !spec.moment) map.fail("given_at_s is for stories with `moment: true`");
  for (StandIn& stand_in : spec.stand_ins) {
    if (stand_in.under_way.empty()) continue;
    if (!spec.moment || (stand_in.action && spec.given_at == spec.begins))
      return map.fail(stand_in.name + ": `under_way` needs a story with `moment: true`" +
                      (stand_in.action ? " and a `given_at_s` after `begins_s`" : ""));
    for (std::size_t i = 0; i < stand_in.under_way.size(); ++i)
      stand_in.outcomes[i].delay(spec.given_at - spec.begins);  // they count from `given_at_s` on
  }
}

/// Whether all that is expected is expected until the end, and nothing says when that is.
bool names_no_time(const StorySpec& spec) {
  return spec.end == SimTime::zero() && spec.steps.empty() &&
         std::ranges::all_of(spec.expect,
                             [](const Expectation& e) { return e.until == kNever && e.after == SimTime::zero(); });
}

/// What a story needs and this one does not have; empty: it has all.
std::string lacks(const StorySpec& spec) {
  if (spec.config.empty() == spec.rules.empty()) return "expected one of config, rules, golden";
  if (spec.expect.empty()) return "nothing is expected";
  if (names_no_time(spec))
    return "no time is named, so the story would end at its first tick: give an expectation `within_s`, or the story "
           "`end`";
  return {};
}

/// A run has all of its own.
void check_golden(yaml::Map& map, const StorySpec& spec) {
  if (const yaml::Value end = map.get("end"); end && spec.end <= SimTime::zero())
    end.fail(found_expected(end.text(), "a time after 0"));
  for (const auto& [key, value] : map.entries())
    if (key != "story" && key != "golden" && key != "end")
      return value.fail("a golden run has its own agent, world and seed: only `end` may stand beside `golden`");
}

}  // namespace

Expected<std::vector<StorySpec>> read_stories(const std::filesystem::path& file, std::vector<Error>* further) {
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
  const auto wrong = [&] {
    const std::vector<Error>& errors = document->errors();
    if (further) further->assign(errors.begin() + 1, errors.end());
    return errors.front();
  };
  StorySpec common;
  common.file = file.string();
  yaml::Value list = document->root();
  if (list.is_map()) {
    yaml::Map map = list.as_map();
    if (const yaml::Value shared = map.get("common")) {
      yaml::Map inner = shared.as_map();
      read_story(inner, common);
      inner.finish();
    }
    list = map.require("stories");
    map.finish();
  }
  const bool common_is_read = document->errors().empty();
  std::vector<StorySpec> stories;
  if (list.is_list() && list.as_list().empty()) list.fail("expected at least one story");
  for (const yaml::Value& item : list.as_list()) {
    yaml::Map map = item.as_map();
    const std::size_t told = document->errors().size();
    StorySpec spec;
    spec.file = common.file;
    if (!map.has("golden")) spec = common;
    spec.line = item.line();
    const yaml::Value name = map.require("story");
    spec.name = name.as_string();
    if (const auto same = std::ranges::find(stories, spec.name, &StorySpec::name); name && same != stories.end())
      name.fail("the story on line " + std::to_string(same->line) + " has the name '" + spec.name +
                "', too: give each story a name of its own");
    if (const yaml::Value keys = map.get("replaces"))
      for (const yaml::Value& key : keys.is_list() ? keys.as_list() : std::vector{keys}) replace(key, spec);
    read_story(map, spec);
    map.finish();
    check_under_way(map, spec);
    check_pointers(map, spec);
    if (!spec.golden.empty())
      check_golden(map, spec);
    else if (const std::string what = lacks(spec); !what.empty() && common_is_read && document->errors().size() == told)
      map.fail(what);  // if something is written wrongly, that may be what is missing
    stories.push_back(std::move(spec));
  }
  if (!document->errors().empty()) return wrong();
  return stories;
}

}  // namespace cxlab::testing
