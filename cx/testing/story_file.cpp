#include "cx/testing/story_file.h"

#include <algorithm>

#include "cx/yaml/yaml.h"

namespace cxlab::testing {

namespace {

std::string dumped(yaml::Map& map, const char* key) {
  const yaml::Value value = map.get(key);
  return value ? value.dump() : std::string();
}

Outcome read_outcome(yaml::Map& map) {
  std::string word = "succeed";
  map.read_word("outcome", word, {"succeed", "fail", "reject", "never"});
  Outcome outcome;
  outcome.kind = word == "succeed"  ? Outcome::Kind::kSucceed
                 : word == "fail"   ? Outcome::Kind::kFail
                 : word == "reject" ? Outcome::Kind::kReject
                                    : Outcome::Kind::kNever;
  outcome.line = map.value().line();
  map.read_seconds("takes_s", outcome.takes);
  outcome.result = dumped(map, "result");
  if (const yaml::Value code = map.get("error_code")) {
    if (!outcome.result.empty()) code.fail("give it in `result` when there is one");
    outcome.result = "{error_code: " + std::to_string(code.as_integer()) + '}';
  }
  return outcome;
}

StandIn read_stand_in(const yaml::Value& value, bool with_at = false) {
  yaml::Map map = value.as_map();
  StandIn out;
  out.file = value.file();
  out.line = value.line();
  if (with_at) map.get("at");
  const yaml::Value action = map.get(with_at ? "skill" : "action"), service = map.get(with_at ? "serve" : "service");
  if (static_cast<bool>(action) == static_cast<bool>(service))
    map.fail(with_at ? "expected one of skill, serve" : "expected one of action, service");
  out.action = static_cast<bool>(action);
  if (action)
    out.name = action.as_string();
  else if (service)
    out.name = service.as_string();
  if (const yaml::Value type = map.require("type")) out.type = type.as_string();
  out.outcomes.push_back(read_outcome(map));
  if (const yaml::Value then = map.get("then"))
    for (const yaml::Value& item : then.as_list()) {
      yaml::Map next = item.as_map();
      out.outcomes.push_back(read_outcome(next));
      next.finish();
    }
  for (const Outcome& o : out.outcomes)
    if (!out.action && o.kind == Outcome::Kind::kReject) map.fail("a service cannot reject");
  map.finish();
  return out;
}

void read_steps(const yaml::Value& list, std::vector<Step>& steps) {
  for (const yaml::Value& item : list.as_list()) {
    yaml::Map map = item.as_map();
    Step step;
    step.line = item.line();
    map.require("at");
    map.read_seconds("at", step.at);
    if (map.has("skill") || map.has("serve")) {
      step.verb = Step::Verb::kStandIn;
      step.stand_in = read_stand_in(item, true);
      steps.push_back(step);
      continue;
    }
    int verbs = 0;
    if (const yaml::Value v = map.get("assert")) step.verb = Step::Verb::kAssert, step.text = v.as_string(), ++verbs;
    if (const yaml::Value v = map.get("retract")) step.verb = Step::Verb::kRetract, step.text = v.as_string(), ++verbs;
    if (const yaml::Value v = map.get("publish")) {
      step.verb = Step::Verb::kPublish;
      step.text = v.as_string();
      ++verbs;
      if (const yaml::Value type = map.require("type")) step.type = type.as_string();
      step.data = dumped(map, "data");
    }
    map.finish();
    if (verbs != 1) map.fail("expected one of assert, retract, publish, skill, serve");
    steps.push_back(std::move(step));
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.at < b.at; });
}

Expectation read_expectation(const yaml::Value& item) {
  using Kind = Expectation::Kind;
  yaml::Map map = item.as_map();
  Expectation e;
  e.line = item.line();
  int kinds = 0;
  const auto take = [&](const char* key, Kind kind) {
    const yaml::Value v = map.get(key);
    if (v) e.kind = kind, e.text = v.as_string(), ++kinds;
    return static_cast<bool>(v);
  };
  const bool fact = take("fact", Kind::kFact) | take("no_fact", Kind::kNoFact);
  const bool goal = take("goal", Kind::kGoal), published = take("published", Kind::kPublished);
  const bool fires = take("fires", Kind::kFires);
  take("not_fires", Kind::kNotFires);
  if (goal || published) e.fields = dumped(map, "fields");
  if (published)
    if (const yaml::Value type = map.require("type")) e.type = type.as_string();
  if (goal || published || fires) map.read("count", e.count);
  if (e.count < 1) map.fail("count: expected at least 1");
  map.read_seconds("after", e.after).read_seconds("within_s", e.until);
  if (fact && map.has("at")) {
    if (map.has("within_s") || map.has("after")) map.fail("`at` stands alone");
    map.read_seconds("at", e.until);
    e.at = true;
  }
  map.finish();
  if (kinds != 1) map.fail("expected one of fact, no_fact, fires, not_fires, goal, published");
  if (e.until < e.after) map.fail("within_s is before after");
  if (!e.at && e.until == kNever && (e.kind == Kind::kFact || fires || goal || published))
    map.fail("key 'within_s' is missing (or 'at')");
  return e;
}

void read_story(yaml::Map& map, StorySpec& spec) {
  const std::filesystem::path folder = std::filesystem::path(spec.file).parent_path();
  std::string config;
  map.read("config", config);
  if (!config.empty()) spec.config = folder / config;
  if (const yaml::Value rules = map.get("rules"))
    for (const std::string& file : rules.as_strings()) spec.rules.push_back(folder / file);
  if (const yaml::Value packages = map.get("packages")) {
    yaml::Map names = packages.as_map();
    for (const auto& [name, path] : names.entries()) spec.packages[name] = folder / path.as_string();
  }
  map.read("environment", spec.environment).read("seed", spec.seed).read_seconds("end", spec.end);
  if (const yaml::Value given = map.get("given"))
    for (const yaml::Value& fact : given.as_list()) spec.given.push_back({fact.as_string(), fact.line()});
  for (const char* key : {"skills", "serve"})
    if (const yaml::Value list = map.get(key))
      for (const yaml::Value& item : list.as_list()) spec.stand_ins.push_back(read_stand_in(item));
  if (const yaml::Value steps = map.get("steps")) read_steps(steps, spec.steps);
  if (const yaml::Value expect = map.get("expect"))
    for (const yaml::Value& item : expect.as_list()) spec.expect.push_back(read_expectation(item));
}

}  // namespace

Expected<std::vector<StorySpec>> read_stories(const std::filesystem::path& file) {
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
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
  if (Status s = document->status(); !s) return s.error();
  std::vector<StorySpec> stories;
  for (const yaml::Value& item : list.as_list()) {
    yaml::Map map = item.as_map();
    StorySpec spec = common;
    spec.line = item.line();
    if (const yaml::Value name = map.require("story")) spec.name = name.as_string();
    read_story(map, spec);
    map.finish();
    if (spec.config.empty() == spec.rules.empty()) map.fail("expected one of config, rules");
    if (spec.expect.empty()) map.fail("nothing is expected");
    stories.push_back(std::move(spec));
  }
  if (Status s = document->status(); !s) return s.error();
  return stories;
}

}  // namespace cxlab::testing
