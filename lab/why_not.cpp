#include "lab/why_not.h"
#include "cx/base/json.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cx/engine/form_reader.h"
#include "cx/explain/json.h"
#include "lab/moment.h"

namespace cxlab::lab {

namespace {

/// Hears of all firings: the facts of the run, and what waits on the agendas.
class Witness final : public JournalListener {
 public:
  Witness(Episode& episode, const std::string& rule)
      : episode_(episode), rule_(without_module(rule)), histories_({.past_facts = false, .rule = rule_}) {
    episode_.journal().observe(*this);
  }
  ~Witness() override { episode_.journal().ignore(*this); }
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;

  bool wants(std::string_view stream, RecordKind kind) const override { return histories_.wants(stream, kind); }
  void heard(const JournalRecord& record) override {
    if (record.kind == RecordKind::kFire) {
      const StreamId stream = episode_.journal().open_stream(record.stream);  // finds it
      for (const cx::Environment* environment : episode_.environments())
        if (environment->engine().stream() == stream)
          watch(record.stream)
              .look(environment->engine(), record.t, explain::module_of(record), std::string(record.data.text("rule")));
    }
    histories_.heard(record);
  }
  void tick_is_over() {
    for (const cx::Environment* environment : episode_.environments())
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

Error unknown_rule(const Run& run, Episode& episode, const std::string& rule) {
  const std::string module = rule.substr(0, rule.size() - without_module(rule).size());  // "A::"
  const auto environments = episode.environments();
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

}  // namespace

Expected<WhyNotAnswer> why_not(const Run& run, const WhyNotQuestion& question, const Host& host) {
  auto moment = Moment::open(run, host);
  if (!moment) return moment.error();
  Episode& episode = (*moment)->episode();
  Witness witness(episode, question.rule);
  (*moment)->after_tick = [&witness] { witness.tick_is_over(); };
  WhyNotAnswer answer;
  if (Status played = (*moment)->seek(question.at); !played) return about_option(played.error(), "--at");
  answer.at = (*moment)->t();
  answer.cut_off = (*moment)->cut_off();
  if ((answer.stopped = (*moment)->stopped())) return answer;
  std::optional<Error> refused;  // what is wanted of a rule that has no such variable
  auto environments = (*moment)->environments(question.environment);
  if (!environments) return environments.error();
  for (cx::Environment* environment : *environments) {
    RuleEngine& engine = environment->engine();
    const explain::History& history = witness.history(*environment);
    bool first = true;
    for (const ConstructInfo& rule : engine.find_constructs("defrule", question.rule)) {
      if (!engine.has("defrule", rule.module + "::" + rule.name)) continue;  // rules removed it
      if (std::exchange(first, false)) (*moment)->inspector(*environment).assert_time();
      auto found = explain::why_not(engine, rule, history, question.wanted);
      if (!found) {
        refused = found.error();
        continue;
      }
      found->lost = witness.lost(*environment, *found);
      found->file = environment->files().journal_name(found->file);
      std::optional<inspect::Makers> makers;
      if (found->unmet) makers = inspect::makers_of((*moment)->inspector(*environment), *found->unmet);
      answer.environments.push_back({environment->unique_name(), *std::move(found), std::move(makers)});
    }
  }
  if (answer.environments.empty()) return refused ? *refused : unknown_rule(run, episode, question.rule);
  return answer;
}

namespace {

Json to_json(const inspect::FactChange& change) {
  return {{"fact", change.after.print()},
          {"what", std::string(to_string(change.kind))},
          {"t_s", to_seconds(change.t)},
          {"by", change.by.text()}};
}

}  // namespace

std::string to_text(const explain::UnmetCondition& lacks) {
  return "condition " + std::to_string(lacks.number) + ": " + lacks.print();
}

Json to_json(const inspect::Makers& makers) {
  Json json{{"pattern", makers.pattern}, {"forbids", makers.forbids}};
  if (makers.changed) json["nearest_changed"] = to_json(*makers.changed);
  if (makers.made) json["last_made"] = to_json(*makers.made);
  if (makers.gone) json["then"] = to_json(*makers.gone);
  auto rules = Json::array();
  for (const auto& maker : makers.makers) {
    rules.push_back({{"rule", maker.rule},
                     {"place", maker.file + ':' + std::to_string(maker.line)},
                     {"how", maker.how},
                     {"fired", maker.fired}});
    if (!maker.through.empty()) rules.back()["through"] = maker.through;
    if (maker.last) rules.back()["last_s"] = to_seconds(*maker.last);
    if (maker.lacks) rules.back()["lacks"] = to_text(*maker.lacks);
  }
  json["rules"] = std::move(rules);
  return json;
}

Json to_json(const WhyNotAnswer& answer) {
  Json explanations = Json::array();
  for (const auto& [environment, found, makers] : answer.environments) {
    Json json{{"environment", environment}};
    json.update(explain::to_json(found));
    if (makers) json["makers"] = to_json(*makers);
    explanations.push_back(std::move(json));
  }
  Json json{{"at_s", to_seconds(answer.at)}};
  if (answer.cut_off) json["cut_off"] = true;
  json["explanations"] = std::move(explanations);
  return json;
}

}  // namespace cxlab::lab
