#include "lab/render.h"

#include <algorithm>

#include "cx/base/number_text.h"
#include "cx/base/servant.h"
#include "lab/confine.h"
#include "lab/physics_replay.h"
#include "lab/session.h"
#include "scenarios/view.h"

namespace cxlab::lab {

namespace {

Status check_end(const std::string& option, double at, SimTime end) {
  if (from_seconds(at) <= end) return {};
  return usage_error(option + ": there is no picture at " + seconds_text(at) + ": the run ends at " +
                     seconds_text(to_seconds(end)));
}

Status draw(const RenderOptions& options, Expected<std::unique_ptr<View>> view) {
  if (!view) return view.error();
  auto picture = (*view)->draw(options.camera.empty() ? (*view)->cameras().front() : options.camera);
  if (!picture) return picture.error();
  return sim::write_png(**picture, options.out);
}

/// For a servant, which can write where this process cannot any more.
std::string pixels_of(const sim::Picture& picture) {
  return std::to_string(picture.width) + ' ' + std::to_string(picture.height) + ' ' +
         std::string(picture.rgb.begin(), picture.rgb.end());
}

std::optional<sim::Picture> picture_of(const std::string& pixels) {
  const std::size_t first = pixels.find(' '), second = pixels.find(' ', first + 1);
  if (second == pixels.npos) return std::nullopt;
  const auto width = read_number<int>(std::string_view(pixels).substr(0, first));
  const auto height = read_number<int>(std::string_view(pixels).substr(first + 1, second - first - 1));
  constexpr int kLongest = 1 << 16;
  if (!width || !height || *width < 1 || *height < 1 || *width > kLongest || *height > kLongest) return std::nullopt;
  if (pixels.size() - second - 1 != 3 * static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height))
    return std::nullopt;
  sim::Picture picture;
  picture.width = *width;
  picture.height = *height;
  picture.rgb.assign(pixels.begin() + static_cast<std::ptrdiff_t>(second) + 1, pixels.end());
  return picture;
}

Wall pictures() {
  Wall wall;
  wall.pictures = true;
  return wall;
}

Status draw_with(Servant& painter, const RenderOptions& options, View& view) {
  auto picture = view.draw(options.camera.empty() ? view.cameras().front() : options.camera);
  if (!picture) return picture.error();
  const auto written = painter.ask(pixels_of(**picture));
  if (!written) return written.error();
  return written->text.empty() ? Status() : resource_error(written->text);
}

/// The physics of a run, and up to when it can be shown: at most its end, at most `at` if that is given.
struct Shown {
  PhysicsOfRun physics;
  SimTime end{};
};
Expected<Shown> show(const Run& run, const std::string& option, std::optional<double> at) {
  if (!run.physics_hash && run.finished && run.tier == Tier::kTimed)
    return input_error(
        "the run was played in the timed tier, which has no bodies to look at: play it with --tier physics of cxlab "
        "run",
        run.folder.string());
  if (run.finished && at)
    if (Status s = check_end(option, *at, run.sim_time); !s) return s.error();
  auto physics = PhysicsOfRun::load(run);
  if (!physics) return physics.error();
  const SimTime end = at ? from_seconds(*at) : run.finished ? run.sim_time : physics->log_end();
  if (!physics->log_status() && end > physics->log_end()) return physics->log_status().error();
  return Shown{*std::move(physics), end};
}

/// Plays the episode until a time, until it is over or until the host stops it; `look` after each tick.
template <class Look>
Status play_until(Episode& episode, double end, const Host& host, Look look) {
  if (Status s = episode.start(); !s) return s;
  while (to_seconds(episode.now()) < end && !episode.over() && !host.stopped()) {
    if (Status s = episode.tick(); !s) return s;
    if (Status s = look(); !s) return s;
    host.show(to_seconds(episode.now()), end);
  }
  return {};
}

Status check_span(double from, double to) {
  if (from <= to) return {};
  return usage_error("--from: found " + seconds_text(from) + ", which is after the end of the film at " +
                     seconds_text(to));
}

}  // namespace

Status render_run(const Run& run, const RenderOptions& options) {
  auto shown = show(run, "--at", options.at);
  if (!shown) return shown.error();
  if (Status s = shown->physics.advance_to(shown->end); !s) return s;
  return draw(options, shown->physics.view(options.width, options.height));
}

Status render_scenario(Scenario scenario, const RenderOptions& options, const Host& host) {
  if (!options.at) return usage_error("--at is missing: a scenario is played up to then");
  if (Status s = check_end("--at", *options.at, scenario.duration); !s) return s;
  const std::string file = scenario.file.string();
  auto episode = Episode::load(std::move(scenario), shared_episode_options(host));
  if (!episode) return episode.error();
  auto view = view_of((*episode)->stage(), options.width, options.height);
  if (!view) return input_error(view.error().message, file);
  auto painter = Servant::start([out = options.out](const std::string& pixels, const auto&) {
    const auto picture = picture_of(pixels);
    const Status written = picture ? sim::write_png(*picture, out) : resource_error("found no picture");
    return Servant::Answer{written ? "" : written.error().text()};
  });
  if (!painter) return painter.error();
  confine(**episode, host, pictures());
  if (Status s = play_until(**episode, *options.at, host, [] { return Status(); }); !s) return s;
  if (host.stopped()) return {};
  const Status drawn = draw_with(*painter, options, **view);
  const Result result = (*episode)->close(RunStatus::kStopped);
  return drawn && result.reason ? Status(*result.reason) : drawn;
}

Status film_run(const Run& run, const FilmOptions& options, const Host& host) {
  auto shown = show(run, "--to", options.to);
  if (!shown) return shown.error();
  const double end = to_seconds(shown->end);
  if (Status s = check_span(options.from, end); !s) return s;
  auto view = shown->physics.view(options.video.width, options.video.height);
  if (!view) return view.error();
  auto video = Video::create(options.video, *std::move(view), host, options.from);
  if (!video) return video.error();
  constexpr double kPart = 1;  // s, after which progress is shown and a stop is noticed
  Status played;
  for (double now = 0;; now = std::min({end, (*video)->next(), now + kPart})) {
    played = shown->physics.advance_to(from_seconds(now));
    if (played) played = (*video)->look(now);
    host.show(now, end);
    if (!played || now >= end || host.stopped()) break;
  }
  const Status finished = host.complete([&] { return (*video)->finish(); });
  return played ? finished : played;
}

Status film_scenario(Scenario scenario, const FilmOptions& options, const Host& host) {
  const double end = options.to.value_or(to_seconds(scenario.duration));
  if (Status s = check_end("--to", end, scenario.duration); !s) return s;
  if (Status s = check_span(options.from, end); !s) return s;
  const std::string file = scenario.file.string();
  auto loaded = Episode::load(std::move(scenario), shared_episode_options(host));
  if (!loaded) return loaded.error();
  Episode& episode = **loaded;
  auto view = view_of(episode.stage(), options.video.width, options.video.height);
  if (!view) return input_error(view.error().message, file);
  auto video = Video::create(options.video, *std::move(view), host, options.from);
  if (!video) return video.error();
  confine(episode, host, pictures());
  const Status played = play_until(episode, end, host, [&] { return (*video)->look(to_seconds(episode.now())); });
  const Status finished = host.complete([&] { return (*video)->finish(); });
  if (!played) return played;
  const Result result = episode.close(host.stopped() ? RunStatus::kInterrupted : RunStatus::kStopped);
  return finished && result.reason && !host.stopped() ? Status(*result.reason) : finished;
}

}  // namespace cxlab::lab
