#include "cx/testing/story.h"

#include <algorithm>

#include "cx/testing/judge.h"
#include "cx/testing/mistakes.h"
#include "cx/testing/play.h"

namespace cxlab::testing {

namespace {

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
    result.sim_time_s = to_seconds(std::max(SimTime::zero(), loop.now() - std::max(spec.begins, spec.given_at)));
  }
  if (failure) result.failures.push_back(failure->text());
  for (std::string& what : judge(play)) result.failures.push_back(std::move(what));
  for (std::string& note : slips_in_names(play)) result.notes.push_back(std::move(note));
  if (Status s = play.end(); !s && !failure) result.failures.push_back(s.error().text());
  for (const std::string& open : play.left_open())
    if (spec.leaves_nothing)
      result.failures.push_back(play.at(spec.line, "left open at the end: " + open).text());
    else
      result.notes.push_back(open);
  result.notes.insert(result.notes.end(), play.unread().begin(), play.unread().end());
  return {};
}

void add(const std::vector<Error>& mistakes, StoryResult& result) {
  for (const Error& mistake : mistakes)
    if (result.bad)
      result.failures.push_back(mistake.text());
    else
      result.bad = mistake;
}

/// The agent is there, or what is wrong is in the result.
bool load(Play& play, const StorySetup& setup, StoryResult& result) {
  if (Status s = play.prepare(); !s) {
    result.bad = s.error();
    return false;
  }
  if (setup.confine) setup.confine(play.wall());
  const Status begun = play.begin();
  if (begun) return true;
  if (begun.error().kind == ErrorKind::kInput)
    result.bad = begun.error();
  else
    result.failures.push_back(begun.error().text());
  add(play.mistakes_in_messages(), result);
  return false;
}

/// The story of an agent that is loaded.
void play_out(Play& play, const StorySetup& setup, StoryResult& result) {
  Mistakes mistakes = mistakes_of(play, setup.patterns_known);
  result.notes = std::move(mistakes.notes);
  add(mistakes.errors, result);
  if (result.bad) return;
  if (Status played = run(play, result); !played) result.bad = played.error();
}

StoryResult told(Play& play, StoryResult result) {
  play.leave();
  result.coverage = play.coverage();
  result.printed = play.printed();
  result.files = play.files();
  return result;
}

}  // namespace

StoryResult run_story(const StorySpec& spec, const StorySetup& setup) {
  StoryResult result;
  Play play(spec, setup, /*each_tick=*/false);
  if (load(play, setup, result)) play_out(play, setup, result);
  return told(play, std::move(result));
}

StorySpec agent_of(StorySpec spec) {
  spec.seeds.clear();
  spec.given.clear();
  spec.calls.clear();
  spec.stand_ins.clear();
  spec.faults.clear();
  spec.steps.clear();
  spec.expect.clear();
  spec.given_at = spec.begins;
  spec.end = SimTime::zero();
  spec.moment = spec.leaves_nothing = false;
  return spec;
}

bool same_agent(const StorySpec& one, const StorySpec& other) {
  const auto same_params = [](const cx::GivenParameter& a, const cx::GivenParameter& b) {
    return a.name == b.name && a.value == b.value;
  };
  return one.config == other.config && one.rules == other.rules && one.packages == other.packages &&
         one.environment == other.environment && one.seed == other.seed && one.tick == other.tick &&
         one.begins == other.begins && std::ranges::equal(one.params, other.params, same_params);
}

struct Stage::State {
  State(const StorySpec& of, const StorySetup& setup_of_all)
      : spec(agent_of(of)), setup(setup_of_all), loaded(load(play, setup, result)) {}

  StorySpec spec;
  StorySetup setup;
  StoryResult result;
  Play play{spec, setup, /*each_tick=*/false};
  bool loaded;
};

Stage::Stage(const StorySpec& of, const StorySetup& setup) : state_(std::make_unique<State>(of, setup)) {}
Stage::~Stage() = default;

StoryResult Stage::play(const StorySpec& story) {
  State& s = *state_;
  s.spec = story;
  if (s.loaded) {
    s.play.go_on_as(s.spec);
    play_out(s.play, s.setup, s.result);
  }
  return told(s.play, std::move(s.result));
}

}  // namespace cxlab::testing
