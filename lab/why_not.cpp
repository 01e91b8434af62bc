#include "lab/why_not.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cx/explain/json.h"

namespace cxlab::lab {

namespace {

std::vector<cx::Environment*> environments_of(Episode& episode) {
  std::vector<cx::Environment*> out;
  for (auto& agent : episode.agents())
    for (std::size_t i = 0; i < agent->size(); ++i) out.push_back(&agent->environment(i));
  return out;
}

Error unknown_rule(Episode& episode, const std::string& rule) {
  std::vector<std::string> names;
  for (const cx::Environment* environment : environments_of(episode))
    for (const ConstructInfo& info : environment->engine().constructs())
      if (info.kind == "defrule") names.push_back(info.name);
  return input_error("no environment has a rule '" + rule + "'" + did_you_mean(rule, names));
}

/// The executive takes its time fact back after each run: here is what the next run would find.
void assert_time(cx::Environment& environment) {
  RuleEngine& engine = environment.engine();
  if (!engine.find_construct("defrule", "time-retract") || !engine.facts("time").empty()) return;
  const Value time = Value::number(to_seconds(environment.now()));
  if (engine.assert_ordered("time", {&time, 1})) engine.refresh_all_agendas();
}

}  // namespace

Expected<WhyNotAnswer> why_not(const RecordedRun& run, const std::string& rule, std::optional<SimTime> at,
                               const Host& host) {
  const SimTime longest = run.finished ? run.sim_time : kLongestRun;
  auto replay = RulesReplay::load(run, longest, JournalLevel::kNone, host, host.log);
  if (!replay) return replay.error();
  Episode& episode = *replay->episode;
  SimTime end = std::min(longest, at.value_or(kNever));
  if (!run.finished) end = std::min(end, episode.replay_end());
  explain::Histories histories({.past_facts = false, .rule = rule.substr(rule.rfind(':') + 1)});
  episode.journal().set_listener(&histories);
  Status played = episode.start();
  while (played && !episode.over() && !host.stopped() && episode.next_tick() <= end) played = episode.tick();
  WhyNotAnswer answer;
  answer.at = std::max(SimTime::zero(), episode.now());
  answer.stopped = host.stopped();
  if (answer.stopped) return answer;
  // A run that failed fails here again, where it did.
  if (!played && run.status != "failed") return played.error();
  for (cx::Environment* environment : environments_of(episode)) {
    RuleEngine& engine = environment->engine();
    if (!engine.find_construct("defrule", rule)) continue;
    const explain::History& history = histories.of(episode.journal().stream_name(engine.stream()));
    assert_time(*environment);
    auto found = explain::why_not(engine, rule, history);
    if (!found) return found.error();
    found->file = environment->files().journal_name(found->file);
    answer.environments.push_back({environment->name(), *std::move(found)});
  }
  episode.journal().set_listener(nullptr);
  if (answer.environments.empty()) return unknown_rule(episode, rule);
  return answer;
}

nlohmann::ordered_json to_json(const WhyNotAnswer& answer) {
  using Json = nlohmann::ordered_json;
  Json explanations = Json::array();
  for (const auto& [environment, found] : answer.environments) {
    Json json{{"environment", environment}};
    json.update(explain::to_json(found));
    explanations.push_back(std::move(json));
  }
  return {{"at_s", to_seconds(answer.at)}, {"explanations", std::move(explanations)}};
}

}  // namespace cxlab::lab
