#include "lab/render.h"

#include <algorithm>

#include "cx/base/number_text.h"
#include "cx/base/servant.h"
#include "lab/confine.h"
#include "lab/frames.h"
#include "lab/happenings.h"
#include "lab/session.h"
#include "lab/shown_run.h"
#include "scenarios/view.h"

namespace cxlab::lab {

namespace {

Status check_end(const std::string& option, double at, SimTime end) {
  if (from_seconds(at) <= end) return {};
  return usage_error(option + ": there is no picture at " + seconds_text(at) + ": the run ends at " +
                     seconds_text(to_seconds(end)));
}

Expected<std::unique_ptr<Frames>> frames_of(const ViewMaker& make, const RenderOptions& options,
                                            const Happenings& events) {
  return Frames::create(make, {.width = options.width,
                               .height = options.height,
                               .cameras = std::max<std::size_t>(options.cameras.size(), 1),
                               .caption = options.caption,
                               .events = &events});
}

Expected<const sim::Picture*> draw(Frames& frames, const RenderOptions& options, SimTime now) {
  return frames.draw(options.cameras.empty() ? std::vector{frames.cameras().front()} : options.cameras, now);
}

/// Views of the world of an episode, or of a recorded run, for as long as that lasts.
ViewMaker shown_views(Episode& episode) {
  return [&episode](int width, int height) -> Expected<std::unique_ptr<View>> {
    auto view = view_of(episode.stage(), width, height);
    if (!view) return input_error(view.error().message, episode.scenario().file.string());
    return view;
  };
}
ViewMaker shown_views(const ShownRun& run) {
  return [&run](int width, int height) { return run.view(width, height); };
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

Status draw_with(Servant& painter, const RenderOptions& options, Frames& frames, SimTime now) {
  auto picture = draw(frames, options, now);
  if (!picture) return picture.error();
  const auto written = painter.ask(pixels_of(**picture));
  if (!written) return written.error();
  return written->text.empty() ? Status() : resource_error(written->text);
}

/// A run, and up to when it can be shown: at most its end, at most `at` if that is given.
struct Shown {
  ShownRun world;
  SimTime end{};
};
Expected<Shown> show(const Run& run, const std::string& option, std::optional<double> at) {
  if (run.finished && at)
    if (Status s = check_end(option, *at, run.sim_time); !s) return s.error();
  auto world = ShownRun::load(run);
  if (!world) return world.error();
  const SimTime end = at ? from_seconds(*at) : run.finished ? run.sim_time : world->log_end();
  if (!world->log_status() && end > world->log_end()) return world->log_status().error();
  return Shown{*std::move(world), end};
}

/// Plays the episode until a time, until it is over or until the host stops it; `look` after each tick, with its time
/// and that of the next.
template <class Look>
Status play_until(Episode& episode, double end, const Host& host, Look look) {
  if (Status s = episode.start(); !s) return s;
  const SimTime last = from_seconds(end);
  while (episode.now() < last && !episode.over() && !host.stopped()) {
    if (Status s = episode.tick(); !s) return s;
    if (Status s = look(episode.now(), episode.over() ? episode.now() : std::min(episode.next_tick(), last)); !s)
      return s;
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
  if (Status s = shown->world.advance_to(shown->end); !s) return s;
  Happenings events(shown->world.scenario());
  events.read(run);
  auto frames = frames_of(shown_views(shown->world), options, events);
  if (!frames) return frames.error();
  const auto picture = draw(**frames, options, shown->end);
  return picture ? sim::write_png(**picture, options.out) : Status(picture.error());
}

Status render_scenario(Scenario scenario, const RenderOptions& options, const Host& host) {
  if (!options.at) return usage_error("--at is missing: cxlab plays a scenario up to that time");
  if (Status s = check_end("--at", *options.at, scenario.duration); !s) return s;
  auto loaded = Episode::load(std::move(scenario), shared_episode_options(host));
  if (!loaded) return loaded.error();
  Episode& episode = **loaded;
  Happenings events(episode.scenario());
  const Listening listening(episode.journal(), events);
  auto frames = frames_of(shown_views(episode), options, events);
  if (!frames) return frames.error();
  auto painter = Servant::start([out = options.out](const std::string& pixels, const auto&) {
    const auto picture = picture_of(pixels);
    const Status written = picture ? sim::write_png(*picture, out) : resource_error("found no picture");
    return Servant::Answer{written ? "" : written.error().text()};
  });
  if (!painter) return painter.error();
  confine(episode, host, pictures());
  if (Status s = play_until(episode, *options.at, host, [](SimTime, SimTime) { return Status(); }); !s) return s;
  if (host.stopped()) return {};
  const Status drawn =
      draw_with(*painter, options, **frames, episode.over() ? episode.now() : from_seconds(*options.at));
  const Result result = episode.close(RunStatus::kStopped);
  return drawn && result.reason ? Status(*result.reason) : drawn;
}

Status film_run(const Run& run, const FilmOptions& options, const Host& host) {
  auto shown = show(run, "--to", options.to);
  if (!shown) return shown.error();
  const double end = to_seconds(shown->end);
  if (Status s = check_span(options.from, end); !s) return s;
  Happenings events(shown->world.scenario());
  events.read(run);
  if (Status s = shown->world.advance_to(SimTime{}); !s) return s;
  auto video = Video::create(options.video, shown_views(shown->world), host, &events, options.from);
  if (!video) return video.error();
  constexpr double kPart = 1;  // s, after which progress is shown and a stop is noticed
  Status played;
  for (double now = 0;; now = std::min({end, (*video)->next(), now + kPart})) {
    const SimTime t = from_seconds(now);
    played = shown->world.advance_to(t);
    if (played) played = (*video)->look(t, t);
    host.show(now, end);
    if (!played || now >= end || host.stopped()) break;
  }
  const Status finished = host.complete([&] { return (*video)->finish(host); });
  return played ? finished : played;
}

Status film_scenario(Scenario scenario, const FilmOptions& options, const Host& host) {
  const double end = options.to.value_or(to_seconds(scenario.duration));
  if (Status s = check_end("--to", end, scenario.duration); !s) return s;
  if (Status s = check_span(options.from, end); !s) return s;
  auto loaded = Episode::load(std::move(scenario), shared_episode_options(host));
  if (!loaded) return loaded.error();
  Episode& episode = **loaded;
  Happenings events(episode.scenario());
  const Listening listening(episode.journal(), events);
  auto video = Video::create(options.video, shown_views(episode), host, &events, options.from);
  if (!video) return video.error();
  confine(episode, host, pictures());
  const Status played =
      play_until(episode, end, host, [&](SimTime now, SimTime next) { return (*video)->look(now, next); });
  const Status finished = host.complete([&] { return (*video)->finish(host); });
  if (!played) return played;
  const Result result = episode.close(host.stopped() ? RunStatus::kInterrupted : RunStatus::kStopped);
  return finished && result.reason && !host.stopped() ? Status(*result.reason) : finished;
}

}  // namespace cxlab::lab
