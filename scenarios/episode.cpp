#include "scenarios/episode.h"

#include <algorithm>

#include "scenarios/begin.h"

namespace cxlab {

namespace {

/// Deactivates the agents. If the run went well until then, errors become warnings, because its game was played.
/// Findings of --strict-cx count as before.
std::vector<std::string> shut_down(std::vector<std::unique_ptr<cx::EnvironmentManager>>& agents, bool strict,
                                   std::optional<Error>& failure, std::vector<std::size_t>& load_errors) {
  std::vector<std::string> warnings;
  const bool went_well = !failure;
  const auto warn = [&](const Error& error) {
    const std::string text = "while the agent shut down: " + error.text();
    if (std::ranges::find(warnings, text) == warnings.end()) warnings.push_back(text);
  };
  for (auto& agent : agents) {
    const std::size_t before = agent->load_errors().size();
    const Status ended = agent->deactivate();
    const std::vector<Error>& all = agent->load_errors();
    // Rules that a signal has stopped have no hashes: that stays an end of its own.
    const bool forgiven = went_well && (ended || ended.error().code != kStoppedCode);
    if (!ended && forgiven) warn(ended.error());
    if (!ended && !forgiven && !failure) failure = ended.error();
    load_errors.push_back(forgiven && !strict ? before : all.size());
    for (std::size_t i = load_errors.back(); i < all.size(); ++i) warn(all[i]);
  }
  return warnings;
}

}  // namespace

Episode::Episode(Scenario scenario, EpisodeOptions options)
    : scenario_(std::move(scenario)), options_(std::move(options)), limits_(options_.spec.limits) {}

Episode::~Episode() = default;

std::vector<cx::Environment*> Episode::environments() const {
  std::vector<cx::Environment*> all;
  for (const auto& agent : agents_)
    for (std::size_t i = 0; i < agent->size(); ++i) all.push_back(&agent->environment(i));
  return all;
}

Status Episode::start() {
  if (const SimTime begin = scenario_.section<Begin>(kBegin).at; begin > SimTime::zero()) bus_->begin_tick(begin);
  const auto starts = [&](std::size_t i) { return scenario_.agents[i].activate || agents_[i]->autostart(); };
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->configure(); !s) return s;
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->activate(); !s) return s;
  if (options_.log && !options_.replay)
    for (const std::string& text : registry_.not_offered())
      options_.log->line({bus_->now(), cx::LogLevel::kWarn, "bus", text, {}});
  if (Status s = write_out(); !s) return s;
  return repeat_acts();
}

Status Episode::tick_at(SimTime next) {
  write_scene(next);
  if (Status s = loop_->tick_at(next); !s) return s;
  if (Status s = write_out(); !s) return s;
  return repeat_acts();
}

Status Episode::join(const Seat& seat) {
  Seat now = seat;
  now.joins_after = this->now();
  if (Status s = seat_agent(now); !s) return s;
  loop_->add(*seats_.back());
  return {};
}

Expected<std::string> Episode::act(cx::Environment& environment, cx::ControlAct::Verb verb, const std::string& text) {
  return environment.act_after_tick(now(), verb, text);
}

Status Episode::repeat_acts() {
  for (; next_seat_ < options_.seats.size(); ++next_seat_) {
    const Seat& seat = options_.seats[next_seat_];
    if (!seat.joins_after) continue;
    if (*seat.joins_after > now()) break;
    if (Status s = join(seat); !s) return s;
  }
  for (; next_act_ < options_.acts.size() && options_.acts[next_act_].act.place.t <= now(); ++next_act_) {
    const PastAct& past = options_.acts[next_act_];
    for (cx::Environment* environment : environments())
      if (environment->unique_name() == past.environment) (void)act(*environment, past.act.verb, past.act.text);
  }
  if (options_.replay)
    for (cx::Environment* environment : environments()) environment->repeat_acts_after_tick(now());
  return {};
}

Expected<StepReport> Episode::step(SimTime until) {
  const std::int64_t before = loop_->ticks();
  for (SimTime next; !over() && (next = next_tick()) <= until;)
    if (Status s = tick_at(next); !s) return s.error();
  return StepReport{now(), loop_->ticks() - before, over()};
}

Scene Episode::scene() const {
  SceneList list;
  list.update(stage_->scenes);
  return list.at(std::max(now(), SimTime::zero()));
}

void Episode::write_scene(SimTime next) {
  if (scene_log_) scene_log_->look(now(), next, stage_->scenes);
}

Status Episode::write_out() {
  // A log that names a tick has all definitions that the tick read.
  if (inputs_->writes_at(now()))
    if (Status s = files_->keep_interfaces(registry_); !s) return s;
  if (Status s = inputs_->ticked(now(), stage_->take_inputs()); !s) return s;
  if (scene_log_ && !scene_log_->status()) return scene_log_->status();
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
  // A node beside the world may say that the run has failed; before the agents go, who would answer it.
  if (const Result so_far = result(); so_far.reason && status != RunStatus::kInterrupted && !failure)
    failure = so_far.reason;
  for (cx::Environment* environment : environments()) environment->move_to_this_thread();
  std::vector<std::size_t> load_errors;  // by agent: how many count
  const std::vector<std::string> at_the_end = shut_down(agents_, options_.spec.strict, failure, load_errors);
  const bool stopped = failure && failure->code == kStoppedCode;  // amid a tick: its inputs are not whole
  if (!stopped) note(write_out());
  for (std::size_t i = 0; i < agents_.size(); ++i) {
    note(agents_[i]->flush_logs());
    if (load_errors[i] > 0) note(agents_[i]->load_errors().front());
  }
  note(files_->keep_interfaces(registry_));
  note(inputs_->close());
  write_scene(kNever);
  if (scene_log_) note(scene_log_->close());
  note(journal_.close());
  Result out = result();
  for (const auto& more : {registry_.not_offered(), at_the_end})
    out.warnings.insert(out.warnings.end(), more.begin(), more.end());
  out.status = failure ? RunStatus::kFailed : status;
  out.reason = failure;
  if (failure && failure->code == kStoppedCode) {
    out.status = RunStatus::kInterrupted;
    out.journal_hash.clear();
    out.stream_hashes.clear();
  }
  return out;
}

Result Episode::reported(std::string only) const {
  Result out = initial_result(scenario_);
  out.only = std::move(only);
  out.sim_time = std::max(now(), SimTime::zero());
  out.ticks = loop_->ticks();
  stage_->report(out);
  for (const auto& report : stage_->reports) report(out);
  return out;
}

std::string Episode::result_at(const std::string& path) const {
  const Result part = reported(section_of_path(path));
  const bool has_section = std::ranges::find(part.sections, part.only, &Result::Section::key) != part.sections.end();
  return (has_section ? part : result()).at(path);
}

Result Episode::result() const {
  Result out = reported();
  out.deterministic = out.deterministic && !options_.spec.sockets && seats_.empty();
  for (const auto& agent : agents_) out.deterministic = out.deterministic && agent->deterministic();
  for (const auto& agent : agents_)
    for (const cx::RuleErrorEntry& entry : agent->rule_errors())
      out.rule_errors.push_back({entry.error.rule, entry.error.file, std::string(to_string(entry.error.side)),
                                 entry.error.message, entry.error.line, entry.error.t / scenario_.tick});
  out.warnings.insert(out.warnings.end(), strange_configs_.begin(), strange_configs_.end());
  for (const auto& agent : agents_)
    for (const Error& warning : agent->warnings()) out.warnings.push_back(warning.text());
  out.journal_hash = journal_.journal_hash();
  for (const Journal::StreamSummary& stream : journal_.streams())
    out.stream_hashes.emplace_back(stream.name, stream.hash);
  return out;
}

}  // namespace cxlab
