#include "lab/render.h"

#include "cx/base/number_text.h"
#include "lab/physics_replay.h"
#include "lab/session.h"
#include "scenarios/view.h"

namespace cxlab::lab {

namespace {

Status draw(const RenderOptions& options, Expected<std::unique_ptr<View>> view) {
  if (!view) return view.error();
  auto picture = (*view)->draw(options.camera.empty() ? (*view)->cameras().front() : options.camera);
  if (!picture) return picture.error();
  return sim::write_png(**picture, options.out);
}

Error after_the_end(double at, SimTime end) {
  return usage_error("--at: there is no picture at " + general_text(at, 9) + " s: the run ends at " +
                     general_text(to_seconds(end), 9) + " s");
}

}  // namespace

Status render_run(const RecordedRun& run, const RenderOptions& options) {
  if (!run.physics_hash && run.finished && run.tier == Tier::kTimed)
    return input_error(
        "the run was played in the timed tier, which has no bodies to look at: play it with --tier physics of cxlab "
        "run",
        run.folder.string());
  if (run.finished && options.at && from_seconds(*options.at) > run.sim_time)
    return after_the_end(*options.at, run.sim_time);
  auto replay = PhysicsOfRun::load(run);
  if (!replay) return replay.error();
  const SimTime at = options.at ? from_seconds(*options.at) : run.finished ? run.sim_time : replay->log_end();
  if (!replay->log_status() && at > replay->log_end()) return replay->log_status().error();
  if (Status s = replay->advance_to(at); !s) return s;
  return draw(options, replay->view(options.width, options.height));
}

Status render_scenario(Scenario scenario, const RenderOptions& options, const Host& host) {
  if (!options.at) return usage_error("--at is missing: a scenario is played up to then");
  const double at = *options.at;
  if (from_seconds(at) > scenario.duration) return after_the_end(at, scenario.duration);
  const std::string file = scenario.file.string();
  auto episode = Episode::load(std::move(scenario), shared_episode_options(host));
  if (!episode) return episode.error();
  Episode& played = **episode;
  auto view = view_of(played.stage(), options.width, options.height);
  if (!view) return input_error(view.error().message, file);
  if (Status s = played.start(); !s) return s;
  while (to_seconds(played.now()) < at && !played.over() && !host.stopped()) {
    if (Status s = played.tick(); !s) return s;
    host.show(to_seconds(played.now()), at);
  }
  if (host.stopped()) return {};
  const Status drawn = draw(options, *std::move(view));
  const Result result = played.close(RunStatus::kStopped);
  return drawn && result.reason ? Status(*result.reason) : drawn;
}

}  // namespace cxlab::lab
