#include "lab/moment.h"

#include <algorithm>
#include <utility>

#include "lab/confine.h"

namespace cxlab::lab {

Expected<std::unique_ptr<Moment>> Moment::open(const Run& run, const Host& host, Options options) {
  std::unique_ptr<Moment> moment(new Moment(run, host, options));
  auto replay = RulesReplay::load(run, host, moment->replay_options());
  if (!replay) return replay.error();
  moment->replay_ = *std::move(replay);
  moment->listen();
  return moment;
}

Moment::~Moment() = default;

RulesReplay::Options Moment::replay_options() const {
  return {.end = run_.finished ? run_.sim_time : kLongestRun,
          .log = host_.log,
          .control = options_.control,
          .counting = options_.counting,
          .on_environment_end = options_.on_environment_end};
}

void Moment::listen() {
  timelines_ = {};
  if (options_.timelines) episode().journal().observe(timelines_);
}

Status Moment::rewind() {
  started_ = cut_off_ = stopped_ = false;
  if (Status s = replay_.load_again(run_, host_, replay_options()); !s) return s;
  listen();
  return {};
}

void Moment::add_reach(Wall& wall) {
  wall.read.push_back(run_.folder);
  wall.write.push_back(replay_.written());
  wall.links.push_back(replay_.written());
}

Status Moment::seek(std::optional<SimTime> t) {
  if (t)
    if (Status s = run_.reaches(*t, end()); !s) return s;
  if (t && started_ && *t < this->t())
    if (Status s = rewind(); !s) return s;
  cut_off_ = t ? *t > end() : !run_.finished || end() < run_.sim_time;
  const Status played = play(std::min(end(), t.value_or(kNever)));
  if (stopped_) return {};
  if (auto error = run_.untrusted(played)) return *error;
  // The replay fails as the recorded run did.
  const bool then = run_.finished && run_.status == "failed" && !played && played.error().kind != ErrorKind::kNo &&
                    this->t() >= run_.sim_time;
  return then ? Status() : played;
}

bool Moment::log_ends_early() const {
  const Episode& episode = *replay_.episode;
  return !run_.finished || !episode.replay_log_status() || !run_.whole(episode.replay_end());
}

SimTime Moment::end() const {
  const SimTime end = run_.finished ? run_.sim_time : kLongestRun;
  return log_ends_early() ? std::min(end, replay_.episode->replay_end()) : end;
}

Status Moment::play(SimTime end) {
  if (!std::exchange(behind_wall_, true)) {
    Wall recorded;
    add_reach(recorded);
    confine(episode(), host_, recorded);
  }
  if (!std::exchange(started_, true)) {
    if (Status s = episode().start(); !s) return s;
    timelines_.start_is_over();
  }
  if (run_.finished && run_.ticks == 0) return {};
  for (SimTime next; !episode().over() && (next = episode().next_tick()) <= end;) {
    if ((stopped_ = host_.stopped())) return {};
    const Status s = episode().tick_at(next);
    after_tick();
    if (!s) return s;
    host_.show(to_seconds(t()), to_seconds(end));
  }
  return {};
}

SimTime Moment::t() const { return std::max(SimTime::zero(), replay_.episode->now()); }

std::string no_environment(const std::string& name, const std::vector<std::string>& known) {
  return "the run has no environment '" + name + "'; it has " + some_of_and_nearest(name, known);
}

inspect::Inspector inspector_of(cx::Environment& environment, Episode& episode, inspect::Timelines& timelines) {
  return {environment.unique_name(), environment.engine(),
          timelines.of(episode.journal().stream_name(environment.engine().stream())),
          [&environment](const std::string& file) { return environment.files().journal_name(file); }};
}

Expected<std::vector<cx::Environment*>> Moment::environments(const std::string& name) {
  std::vector<cx::Environment*> out;
  std::vector<std::string> known;
  for (cx::Environment* environment : episode().environments()) {
    known.push_back(environment->unique_name());
    if (name.empty() || name == environment->unique_name() || name == environment->name_in_log() ||
        name == environment->name())
      out.push_back(environment);
  }
  if (!out.empty()) return out;
  if (known.empty()) return input_error("the run has no environment at that time", run_.folder.string());
  return input_error(no_environment(name, known), run_.folder.string());
}

Expected<std::vector<inspect::Inspector>> Moment::inspectors(const std::string& name) {
  auto found = environments(name);
  if (!found) return found.error();
  std::vector<inspect::Inspector> out;
  for (cx::Environment* environment : *found) out.push_back(inspector(*environment));
  return out;
}

Expected<TwoMoments> TwoMoments::open(const Run& a, const Run& b, const Host& host) {
  auto first = Moment::open(a, host);
  if (!first) return first.error();
  auto second = Moment::open(b, host);
  if (!second) return second.error();
  Wall both = (*second)->episode().wall();
  (*first)->add_reach(both);
  (*second)->add_reach(both);
  confine((*first)->episode(), host, both);
  (*first)->behind_wall_ = (*second)->behind_wall_ = true;
  return TwoMoments{*std::move(first), *std::move(second)};
}

Status TwoMoments::seek(std::optional<SimTime> t) {
  for (Moment* moment : {a.get(), b.get()})
    if (Status s = moment->seek(t.value_or(end())); !s) return s;
  return {};
}

Expected<TwoMoments::Environments> TwoMoments::environments(const std::string& name) {
  auto of_a = a->inspectors(name), of_b = b->inspectors(name);
  if (!of_a || !of_b) return (of_a ? of_b : of_a).error();
  Environments out;
  for (inspect::Inspector& one : *of_a) {
    const auto other = std::ranges::find(*of_b, one.name(), &inspect::Inspector::name);
    if (other == of_b->end()) {
      out.only_in_a.push_back(one.name());
      continue;
    }
    out.both.emplace_back(std::move(one), std::move(*other));
    of_b->erase(other);
  }
  for (const inspect::Inspector& one : *of_b) out.only_in_b.push_back(one.name());
  if (!out.both.empty()) return out;
  const auto list = [](const std::vector<std::string>& names) { return some_of(names); };
  return input_error("the runs have no environment in common: a has " + list(out.only_in_a) + ", b has " +
                     list(out.only_in_b));
}

}  // namespace cxlab::lab
