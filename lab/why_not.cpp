#include "lab/why_not.h"
#include "cx/base/json.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cx/engine/form_reader.h"
#include "cx/explain/json.h"
#include "lab/answers.h"
#include "lab/moment.h"

namespace cxlab::lab {

struct RuleWitness::State final : JournalListener {
  State(Episode& of, const std::string& name)
      : episode(of), rule(without_module(name)), histories({.past_facts = false, .rule = rule}) {
    episode.journal().observe(*this);
  }
  ~State() override { episode.journal().ignore(*this); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  bool wants(std::string_view stream, RecordKind kind) const override { return histories.wants(stream, kind); }
  void heard(const JournalRecord& record) override {
    if (record.kind == RecordKind::kFire) {
      const StreamId stream = episode.journal().open_stream(record.stream);  // finds it
      for (const cx::Environment* environment : episode.environments())
        if (environment->engine().stream() == stream)
          watch(record.stream)
              .look(environment->engine(), record.t, explain::module_of(record), std::string(record.data.text("rule")));
    }
    histories.heard(record);
  }
  std::string stream_of(const cx::Environment& environment) const {
    return episode.journal().stream_name(environment.engine().stream());
  }
  explain::AgendaWatch& watch(const std::string& stream) {
    return watches.try_emplace(stream, explain::AgendaWatch(rule)).first->second;
  }

  Episode& episode;
  std::string rule;
  explain::Histories histories;
  std::map<std::string, explain::AgendaWatch> watches;
};

RuleWitness::RuleWitness(Episode& episode, const std::string& rule) : state_(std::make_unique<State>(episode, rule)) {}
RuleWitness::~RuleWitness() = default;

void RuleWitness::tick_is_over() {
  for (const cx::Environment* environment : state_->episode.environments())
    state_->watch(state_->stream_of(*environment)).look(environment->engine(), state_->episode.now());
}

bool RuleWitness::follows(const std::string& rule) const { return without_module(rule) == state_->rule; }

Expected<explain::WhyNot> RuleWitness::why_not(cx::Environment& environment, const ConstructInfo& rule,
                                               const explain::Wanted& wanted) const {
  const std::string stream = state_->stream_of(environment);
  auto found = explain::why_not(environment.engine(), rule, state_->histories.of(stream), wanted);
  if (!found) return found;
  // Only activations since the last firing count.
  const explain::LostActivation* last = state_->watch(stream).last(found->module);
  if (last && (found->fired == 0 || last->t >= found->last_fired)) found->lost = *last;
  found->file = environment.files().journal_name(found->file);
  return found;
}

namespace {

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
  RuleWitness witness(episode, question.rule);
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
    bool first = true;
    for (const ConstructInfo& rule : engine.find_constructs("defrule", question.rule)) {
      if (!engine.has("defrule", rule.module + "::" + rule.name)) continue;  // rules removed it
      if (std::exchange(first, false)) (*moment)->inspector(*environment).assert_time();
      auto found = witness.why_not(*environment, rule, question.wanted);
      if (!found) {
        refused = found.error();
        continue;
      }
      std::optional<inspect::Makers> makers;
      if (found->unmet) makers = inspect::makers_of((*moment)->inspector(*environment), *found->unmet);
      answer.environments.push_back({environment->unique_name(), *std::move(found), std::move(makers)});
    }
  }
  if (answer.environments.empty()) return refused ? *refused : unknown_rule(run, episode, question.rule);
  return answer;
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
