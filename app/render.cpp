// cxlab render: one picture, of a recorded run or of a scenario that is played up to then.

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "lab/physics_replay.h"
#include "lab/recorded_run.h"
#include "lab/view.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::string what, out, camera, size = "960x720";
  std::optional<double> at;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> overrides;
};

struct Size {
  int width = 0, height = 0;
};

Expected<Size> read_size(const std::string& text) {
  Size size;
  char rest = 0;
  constexpr int kLargest = 4096;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 || size.width < 16 ||
      size.height < 16 || size.width > kLargest || size.height > kLargest)
    return Error{
        ErrorKind::kUsage, "--size: found '" + text + "', expected WIDTHxHEIGHT, each from 16 to 4096", {}, 0, {}};
  return size;
}

/// `make` gives the view for a size.
template <class Make>
Status draw(const Options& options, Make make) {
  auto size = read_size(options.size);
  if (!size) return size.error();
  Expected<std::unique_ptr<lab::View>> view = make(size->width, size->height);
  if (!view) return view.error();
  auto picture = (*view)->draw(options.camera.empty() ? (*view)->cameras().front() : options.camera);
  if (!picture) return picture.error();
  return sim::write_png(**picture, options.out);
}

Status render_run(const Options& options) {
  auto run = lab::RecordedRun::open(options.what);
  if (!run) return run.error();
  if (!run->physics_hash && run->finished && run->tier == Tier::kTimed)
    return input_error(
        "the run was played in the timed tier, which has no bodies to look at: play it with --tier physics",
        options.what);
  if (run->finished && options.at && from_seconds(*options.at) > run->sim_time) {
    char end[32];
    std::snprintf(end, sizeof end, "%g s", to_seconds(run->sim_time));
    return input_error(std::string("the run ends at ") + end, options.what);
  }
  auto replay = lab::PhysicsOfRun::load(*run);
  if (!replay) return replay.error();
  const SimTime at = options.at ? from_seconds(*options.at) : run->finished ? run->sim_time : replay->log_end();
  if (!replay->log_status() && at > replay->log_end()) return replay->log_status().error();
  if (Status s = replay->advance_to(at); !s) return s;
  return draw(options, [&](int width, int height) { return replay->view(width, height); });
}

Status render_scenario(const Options& options) {
  if (!options.at) return usage_error("--at is missing: a scenario is played up to then");
  const double at = *options.at;
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back("seed=" + std::to_string(*options.seed));
  auto scenario = Scenario::load(options.what, overrides);
  if (!scenario) return scenario.error();
  const bool canvas =
      std::ranges::any_of(scenario->servers, [](const ServerSpec& server) { return server.node == "turtlesim"; });
  if (scenario->world_kind == Scenario::WorldKind::kNone && !canvas)
    return input_error("the world is empty: there is nothing to look at", options.what);
  if (scenario->world_kind == Scenario::WorldKind::kRcll && scenario->tier == Tier::kTimed && !canvas)
    return input_error("the timed tier has no bodies to look at: --set tier=physics", options.what);
  auto episode = Episode::load(*std::move(scenario), lab::shared_episode_options());
  if (!episode) return episode.error();
  Episode& played = **episode;
  Console console(false);
  const lab::Host host = console.host();
  if (Status s = played.start(); !s) return s;
  while (to_seconds(played.now()) < at && !played.over() && !host.stopped()) {
    if (Status s = played.tick(); !s) return s;
    host.show(to_seconds(played.now()), at);
  }
  console.clear();
  if (signal_that_came()) return {};
  const Status drawn =
      draw(options, [&](int width, int height) { return lab::view_of(played.stage(), width, height); });
  const Result result = played.close(RunStatus::kStopped);
  return drawn && result.reason ? Status(*result.reason) : drawn;
}

int render(const Options& options) {
  if (auto size = read_size(options.size); !size) return fail(size.error());
  const Status drawn = fs::is_directory(options.what) ? render_run(options) : render_scenario(options);
  if (signal_that_came()) return 128 + signal_that_came();
  if (!drawn) return fail(drawn.error());
  std::printf("%s\n", options.out.c_str());
  return 0;
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("render", "Draws the world of a run or of a scenario at a time");
  command->add_option("what", options->what, "Folder of a run, or a scenario, which is played up to then")->required();
  command
      ->add_option("--at", options->at,
                   "When, s of simulated time (of a run: default its end, or how far its log goes)")
      ->check(not_negative());
  command->add_option("--out", options->out, "The picture (PNG)")->required();
  command->add_option("--camera", options->camera,
                      "Of a factory: field (default), top, a robot (robot1) or a machine (C-CS1); of turtles: canvas");
  command->add_option("--size", options->size, "WIDTHxHEIGHT; a canvas of turtles is the largest square in it")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Of a scenario: seed of all chance")->check(seed_number());
  command->add_option("--set", options->overrides, "Of a scenario: changes a value, a.b[0].c=VALUE")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command->footer(
      "Example:\n  cxlab render scenarios/rcll/game.yaml --at 60 --out field.png --camera top\n  cxlab render "
      "scenarios/turtlesim/figures.yaml --at 40 --out figures.png --size 500x500");
  command->callback([options, &action] { action = [options] { return render(*options); }; });
}

}  // namespace cxlab::app
