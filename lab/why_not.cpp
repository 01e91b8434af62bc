#include "lab/why_not.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "cx/engine/form_reader.h"
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
      if (info.kind == "defrule")
        names.push_back(without_module(rule) == rule ? info.name : info.module + "::" + info.name);
  return input_error("no environment has a rule '" + rule + "'" + did_you_mean(rule, names));
}

/// The executive takes its time fact back after each run: here is what the next run would find.
void assert_time(cx::Environment& environment, const explain::History& history) {
  RuleEngine& engine = environment.engine();
  if (!engine.find_construct("defrule", "time-retract") || !history.ever("time") || !engine.facts("time").empty())
    return;
  const Value time = Value::number(to_seconds(environment.now()));
  if (engine.assert_ordered("time", {&time, 1})) engine.refresh_all_agendas();
}

/// Whether the recorded run failed just so.
bool failed_then(const RecordedRun& run, const Error& error, SimTime now) {
  return run.finished && run.status == "failed" && error.kind != ErrorKind::kNo && now >= run.sim_time;
}

}  // namespace

Expected<WhyNotAnswer> why_not(const RecordedRun& run, const WhyNotQuestion& question, const Host& host) {
  const SimTime longest = run.finished ? run.sim_time : kLongestRun;
  auto replay = RulesReplay::load(run, longest, JournalLevel::kNone, host, host.log);
  if (!replay) return replay.error();
  Episode& episode = *replay->episode;
  WhyNotAnswer answer;
  SimTime end = std::min(longest, question.at.value_or(kNever));
  if (!run.finished) {
    answer.cut_off = question.at && *question.at > episode.replay_end();
    end = std::min(end, episode.replay_end());
  }
  explain::Histories histories({.past_facts = false, .rule = std::string(without_module(question.rule))});
  episode.journal().set_listener(&histories);
  Status played = episode.start();
  while (played && !episode.over() && !host.stopped() && episode.next_tick() <= end) played = episode.tick();
  answer.at = std::max(SimTime::zero(), episode.now());
  answer.stopped = host.stopped();
  if (answer.stopped) return answer;
  if (!played && !failed_then(run, played.error(), answer.at)) return played.error();
  std::optional<Error> refused;  // what is wanted of a rule that has no such variable
  for (cx::Environment* environment : environments_of(episode)) {
    RuleEngine& engine = environment->engine();
    const explain::History& history = histories.of(episode.journal().stream_name(engine.stream()));
    bool first = true;
    for (const ConstructInfo& rule : engine.find_constructs("defrule", question.rule)) {
      if (!engine.has("defrule", rule.module + "::" + rule.name)) continue;  // rules removed it
      if (std::exchange(first, false)) assert_time(*environment, history);
      auto found = explain::why_not(engine, rule, history, question.wanted);
      if (!found) {
        refused = found.error();
        continue;
      }
      found->file = environment->files().journal_name(found->file);
      answer.environments.push_back({environment->name(), *std::move(found)});
    }
  }
  episode.journal().set_listener(nullptr);
  if (answer.environments.empty()) return refused ? *refused : unknown_rule(episode, question.rule);
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
  Json json{{"at_s", to_seconds(answer.at)}};
  if (answer.cut_off) json["cut_off"] = true;
  json["explanations"] = std::move(explanations);
  return json;
}

}  // namespace cxlab::lab
