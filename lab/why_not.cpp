#include "lab/why_not.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/json.h"
#include "lab/confine.h"

namespace cxlab::lab {

namespace {

std::vector<cx::Environment*> environments_of(Episode& episode) {
  std::vector<cx::Environment*> out;
  for (auto& agent : episode.agents())
    for (std::size_t i = 0; i < agent->size(); ++i) out.push_back(&agent->environment(i));
  return out;
}

/// Hears of all firings: the facts of the run, and what waits on the agendas.
class Witness final : public JournalListener {
 public:
  Witness(Episode& episode, const std::string& rule)
      : episode_(episode), rule_(without_module(rule)), histories_({.past_facts = false, .rule = rule_}) {
    episode_.journal().set_listener(this);
  }
  ~Witness() override { episode_.journal().set_listener(nullptr); }
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;

  bool wants(std::string_view stream, RecordKind kind) const override { return histories_.wants(stream, kind); }
  void heard(const JournalRecord& record) override {
    if (record.kind == RecordKind::kFire) {
      const StreamId stream = episode_.journal().open_stream(record.stream);  // finds it
      for (const cx::Environment* environment : environments_of(episode_))
        if (environment->engine().stream() == stream)
          watch(record.stream)
              .look(environment->engine(), record.t, explain::module_of(record), std::string(record.data.text("rule")));
    }
    histories_.heard(record);
  }
  void tick_is_over() {
    for (const cx::Environment* environment : environments_of(episode_))
      watch(stream_of(*environment)).look(environment->engine(), episode_.now());
  }
  const explain::History& history(const cx::Environment& environment) { return histories_.of(stream_of(environment)); }
  /// Since its last firing.
  std::optional<explain::LostActivation> lost(const cx::Environment& environment, const explain::WhyNot& answer) {
    const explain::LostActivation* last = watch(stream_of(environment)).last(answer.module);
    if (!last || (answer.fired > 0 && last->t < answer.last_fired)) return std::nullopt;
    return *last;
  }

 private:
  std::string stream_of(const cx::Environment& environment) const {
    return episode_.journal().stream_name(environment.engine().stream());
  }
  explain::AgendaWatch& watch(const std::string& stream) {
    return watches_.try_emplace(stream, explain::AgendaWatch(rule_)).first->second;
  }

  Episode& episode_;
  std::string rule_;
  explain::Histories histories_;
  std::map<std::string, explain::AgendaWatch> watches_;
};

Error unknown_rule(const RecordedRun& run, Episode& episode, const std::string& rule) {
  const std::string module = rule.substr(0, rule.size() - without_module(rule).size());  // "A::"
  const auto environments = environments_of(episode);
  const bool module_is_known =
      module.empty() || module == "MAIN::" || std::ranges::any_of(environments, [&](const cx::Environment* e) {
        return e->engine().has("defmodule", module.substr(0, module.size() - 2));
      });
  if (const auto known = run.not_loaded.find(std::string(without_module(rule)));
      module_is_known && known != run.not_loaded.end())
    return input_error("rule '" + rule + "' was not loaded: " + known->second.message, known->second.file,
                       known->second.line);
  std::vector<std::string> names;
  for (const cx::Environment* environment : environments)
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
  if (run.finished && question.at && *question.at > run.sim_time)
    return usage_error("--at: the run ends at " + general_text(to_seconds(run.sim_time), 9) + " s");
  const SimTime longest = run.finished ? run.sim_time : kLongestRun;
  auto replay = RulesReplay::load(run, longest, JournalLevel::kNone, host, host.log);
  if (!replay) return replay.error();
  Episode& episode = *replay->episode;
  WhyNotAnswer answer;
  SimTime end = std::min(longest, question.at.value_or(kNever));
  if (!run.finished || !episode.replay_log_status() || !run.whole(episode.replay_end())) {
    answer.cut_off = question.at.value_or(run.sim_time) > episode.replay_end();
    end = std::min(end, episode.replay_end());
  }
  Witness witness(episode, question.rule);
  Wall recorded;
  recorded.read = {run.folder};
  confine(episode, host, recorded);
  Status played = episode.start();
  while (played && !episode.over() && !host.stopped() && episode.next_tick() <= end) {
    played = episode.tick();
    witness.tick_is_over();
  }
  answer.at = std::max(SimTime::zero(), episode.now());
  answer.stopped = host.stopped();
  if (answer.stopped) return answer;
  if (auto error = run.untrusted(played)) return *error;
  if (!played && !failed_then(run, played.error(), answer.at)) return played.error();
  std::optional<Error> refused;  // what is wanted of a rule that has no such variable
  for (cx::Environment* environment : environments_of(episode)) {
    RuleEngine& engine = environment->engine();
    const explain::History& history = witness.history(*environment);
    bool first = true;
    for (const ConstructInfo& rule : engine.find_constructs("defrule", question.rule)) {
      if (!engine.has("defrule", rule.module + "::" + rule.name)) continue;  // rules removed it
      if (std::exchange(first, false)) assert_time(*environment, history);
      auto found = explain::why_not(engine, rule, history, question.wanted);
      if (!found) {
        refused = found.error();
        continue;
      }
      found->lost = witness.lost(*environment, *found);
      found->file = environment->files().journal_name(found->file);
      answer.environments.push_back({environment->name(), *std::move(found)});
    }
  }
  if (answer.environments.empty()) return refused ? *refused : unknown_rule(run, episode, question.rule);
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
