#include "cx/testing/story.h"

#include "cx/testing/judge.h"
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
    result.sim_time_s = to_seconds(loop.now());
  }
  if (failure) result.failures.push_back(failure->text());
  for (std::string& what : judge(play)) result.failures.push_back(std::move(what));
  if (Status s = play.end(); !s && !failure) result.failures.push_back(s.error().text());
  result.notes = play.left_open();
  result.coverage = play.coverage();
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
