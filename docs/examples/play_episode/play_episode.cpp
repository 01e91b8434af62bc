// Plays an episode from a program of one's own: load, step, observe, close.
//
//   play_episode SCENARIO.yaml [SECONDS]

#include <scenarios/episode.h>
#include <scenarios/share.h>
#include <scenarios/shipped/catalogue.h>

#include <cstdio>
#include <cstdlib>

namespace {

int fail(const cxlab::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.text().c_str());
  return static_cast<int>(error.kind);
}

/// Every minute of simulated time: how many facts each environment has.
void observe(cxlab::Episode& episode) {
  for (auto& agent : episode.agents())
    for (std::size_t i = 0; i < agent->size(); ++i) {
      const cxlab::cx::Environment& environment = agent->environment(i);
      std::printf("%6.1f s: %s has %zu facts\n", cxlab::to_seconds(episode.now()), environment.name().c_str(),
                  environment.engine().fact_count());
    }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: play_episode SCENARIO.yaml [SECONDS]\n");
    return 2;
  }
  auto scenario = cxlab::Scenario::load(argv[1], cxlab::shipped());
  if (!scenario) return fail(scenario.error());
  const double end = argc > 2 ? std::atof(argv[2]) : cxlab::to_seconds(scenario->duration);

  const cxlab::Share share = cxlab::find_share();
  cxlab::EpisodeOptions options;  // without a run_folder nothing is written
  options.interfaces = share.interfaces;
  options.models = share.models;
  auto loaded = cxlab::Episode::load(*std::move(scenario), std::move(options));
  if (!loaded) return fail(loaded.error());
  cxlab::Episode& episode = **loaded;

  cxlab::Status status = episode.start();
  for (double next = 60; status && !episode.over() && cxlab::to_seconds(episode.now()) < end;) {
    status = episode.tick();
    if (cxlab::to_seconds(episode.now()) < next) continue;
    observe(episode);
    next += 60;
  }

  const cxlab::Result result =
      status ? episode.close(episode.completed() ? cxlab::RunStatus::kCompleted : cxlab::RunStatus::kStopped)
             : episode.close(cxlab::RunStatus::kFailed, status.error());
  std::printf("%s", result.score_board.c_str());
  std::printf("journal %s\n", result.journal_hash.c_str());
  return result.reason ? fail(*result.reason) : 0;
}
