#include "scenarios/episode.h"

#include <algorithm>

namespace cxlab {

Episode::Episode(Scenario scenario, EpisodeOptions options)
    : scenario_(std::move(scenario)), options_(std::move(options)), limits_(options_.limits) {}

Episode::~Episode() = default;

Status Episode::start() {
  const auto starts = [&](std::size_t i) { return scenario_.agents[i].activate || agents_[i]->autostart(); };
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->configure(); !s) return s;
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->activate(); !s) return s;
  return write_out();
}

Status Episode::tick() {
  if (Status s = loop_->tick(); !s) return s;
  return write_out();
}

Status Episode::write_out() {
  // A log that names a tick has all definitions that the tick read.
  if (inputs_->writes_at(now()))
    if (Status s = files_->keep_interfaces(registry_); !s) return s;
  if (Status s = inputs_->ticked(now(), stage_->take_inputs()); !s) return s;
  return journal_.status();
}

bool Episode::completed() const { return now() >= scenario_.duration || (stage_->referee && stage_->referee->over()); }

bool Episode::over() const {
  return completed() ||
         std::any_of(agents_.begin(), agents_.end(), [](const auto& agent) { return agent->shutdown_requested(); });
}

Result Episode::close(RunStatus status, std::optional<Error> failure) {
  const auto note = [&](const Status& s) {
    if (!s && !failure) failure = s.error();
  };
  if (scenario_.stop_on_rule_error)
    for (auto& agent : agents_)
      if (agent->gave_up()) note(*agent->gave_up());
  for (auto& agent : agents_) note(agent->deactivate());
  const bool stopped = failure && failure->code == kStoppedCode;  // amid a tick: its inputs are not whole
  if (!stopped) note(write_out());
  for (auto& agent : agents_) {
    note(agent->flush_logs());
    if (!agent->load_errors().empty()) note(agent->load_errors().front());
  }
  note(files_->keep_interfaces(registry_));
  note(inputs_->close());
  note(journal_.close());
  Result out = result();
  out.status = failure ? RunStatus::kFailed : status;
  out.reason = failure;
  if (failure && failure->code == kStoppedCode) {
    out.status = RunStatus::kInterrupted;
    out.journal_hash.clear();
    out.stream_hashes.clear();
  }
  return out;
}

Result Episode::result() const {
  Result out;
  out.scenario = scenario_.name;
  out.seed = scenario_.seed;
  out.tier = scenario_.tier_name();
  out.sim_time = std::max(now(), SimTime::zero());
  out.ticks = loop_->ticks();
  stage_->report(out);
  for (const auto& report : stage_->reports) report(out);
  out.deterministic = out.deterministic && !options_.sockets;
  for (const auto& agent : agents_) out.deterministic = out.deterministic && agent->deterministic();
  for (const auto& agent : agents_)
    for (const cx::RuleErrorEntry& entry : agent->rule_errors())
      out.rule_errors.push_back({entry.error.rule, entry.error.file, std::string(to_string(entry.error.side)),
                                 entry.error.message, entry.error.line, entry.error.t / scenario_.tick});
  for (const auto& agent : agents_)
    for (const Error& warning : agent->warnings()) out.warnings.push_back(warning.text());
  out.journal_hash = journal_.journal_hash();
  for (const Journal::StreamSummary& stream : journal_.streams())
    out.stream_hashes.emplace_back(stream.name, stream.hash);
  return out;
}

}  // namespace cxlab
