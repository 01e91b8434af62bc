#include "cx/testing/story.h"

#include <algorithm>
#include <map>

#include "cx/engine/form_reader.h"
#include "cx/testing/judge.h"
#include "cx/testing/play.h"

namespace cxlab::testing {

namespace {

/// The rules of the user's own files. Those outside of MAIN are named with their modules.
std::vector<RuleCount> rules_of(const RuleEngine& engine) {
  std::vector<RuleCount> rules;
  for (const ConstructInfo& c : engine.constructs())
    if (c.kind == "defrule" && c.line > 0 && std::filesystem::path(c.file).is_absolute())
      rules.push_back({c.file, (c.module == "MAIN" ? "" : c.module + "::") + c.name, c.line});
  return rules;
}

void count(std::vector<RuleCount>& rules, const RuleEngine& engine, const explain::History& history) {
  const auto& firings = history.firings();
  for (RuleCount& rule : rules) {
    const std::string name = without_module(rule.rule) == rule.rule ? "MAIN::" + rule.rule : rule.rule;
    rule.fired = std::count_if(firings.begin(), firings.end(), [&](const auto& f) { return f.is_of(name); });
    const auto activated = engine.activations().find(name);
    rule.activated = activated == engine.activations().end() ? 0 : activated->second;
  }
}

/// Ends the agent, whose rules may fire once more for it, and counts for each environment the rules that it had before.
Status end_and_count(Play& play, std::vector<RuleCount>& counts) {
  cx::EnvironmentManager& manager = play.manager();
  std::map<std::string, std::vector<RuleCount>> rules;
  for (std::size_t i = 0; i < manager.size(); ++i)
    rules[manager.environment(i).name()] = rules_of(manager.environment(i).engine());
  const Status ended = manager.deactivate();
  for (auto& [name, of_environment] : rules) {
    const cx::Environment* environment = manager.find(name);
    if (environment == nullptr) continue;
    count(of_environment, environment->engine(), play.history_of(environment->engine()));
    counts.insert(counts.end(), of_environment.begin(), of_environment.end());
  }
  return ended;
}

/// Plays and judges; an error ends the story before it can be judged.
Status run(Play& play, StoryResult& result) {
  const StorySpec& spec = play.spec();
  const SimTime end = end_of(spec);
  cx::EnvironmentManager& manager = play.manager();
  Loop& loop = play.loop();
  std::optional<Error> failure;
  while (loop.next_tick() <= end && !failure && !(loop.ticks() > 0 && manager.shutdown_requested())) {
    Status s = loop.tick();
    if (!s && s.error().file == spec.file) return s;
    if (!s) failure = s.error();
    result.sim_time_s = to_seconds(loop.now());
  }
  if (failure) result.failures.push_back(failure->text());
  for (std::string& what : judge(play)) result.failures.push_back(std::move(what));
  if (Status s = end_and_count(play, result.rules); !s && !failure) result.failures.push_back(s.error().text());
  result.notes = play.left_open();
  return {};
}

/// The whole story; an error is a mistake of the story itself.
Status play_out(Play& play, const StorySetup& setup, StoryResult& result) {
  if (Status s = play.prepare(); !s) return s;
  if (setup.confine) setup.confine(play.wall());
  if (Status s = play.begin(); !s) {
    if (s.error().kind == ErrorKind::kInput) return s;
    result.failures.push_back(s.error().text());
    return {};
  }
  if (Status s = check_names(play); !s) return s;
  return run(play, result);
}

}  // namespace

StoryResult run_story(const StorySpec& spec, const StorySetup& setup) {
  StoryResult result;
  Play play(spec, setup, /*each_tick=*/false);
  if (Status s = play_out(play, setup, result); !s) result.bad = s.error();
  result.printed = play.printed();
  result.files = play.files();
  return result;
}

}  // namespace cxlab::testing
