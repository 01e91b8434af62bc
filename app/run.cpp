// cxlab run: plays one episode.

#include <cctype>
#include <cstdio>
#include <string_view>

#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "app/program.h"
#include "app/suggestions.h"
#include "cx/base/file.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

struct RunOptions : PlayCommand {
  std::string scenario, tier, video_size, cameras, most_of_video;
  bool no_caption = false;
  std::vector<std::string> overrides;
  lab::BagOptions bag;
};

/// Address of the run's page for a browser. The folder, if a full disk kept the page from being written.
std::string address_of(const std::filesystem::path& folder) {
  const auto page = folder / "index.html";
  if (!path_exists(page)) return folder.string();
  std::string address = "file://";
  for (const char c : std::filesystem::absolute(page).lexically_normal().string()) {
    if (std::isalnum(static_cast<unsigned char>(c)) || std::string_view("/-._~").find(c) != std::string_view::npos) {
      address += c;
      continue;
    }
    char escaped[4];
    std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned char>(c));
    address += escaped;
  }
  return address;
}

int run(RunOptions options) {
  lab::VideoOptions& video = options.play.video;
  if (!options.video_size.empty()) read_size(options.video_size, video.width, video.height);
  video.cameras = lab::camera_names(options.cameras);
  video.caption = !options.no_caption;
  video.most_bytes = read_bytes(options.most_of_video);
  std::vector<Override> overrides(options.overrides.begin(), options.overrides.end());
  if (options.seed) overrides.emplace_back("seed=" + std::to_string(*options.seed), "--seed");
  if (!options.tier.empty()) overrides.emplace_back("tier=" + options.tier, "--tier " + options.tier);
  const auto of_bag = lab::overrides_of(options.bag);
  if (!of_bag) return fail(of_bag.error());
  overrides.insert(overrides.end(), of_bag->begin(), of_bag->end());
  const auto file = find_scenario(options.scenario);
  if (!file) return fail(file.error());
  auto scenario = Scenario::load(*file, catalogue(), overrides);
  if (!scenario) return fail(scenario.error());
  const double duration = to_seconds(scenario->duration), until = options.play.spec.until.value_or(0);
  const auto [code, played] = play(options, *std::move(scenario));
  if (played.result.journal_hash.empty()) return code;
  if (options.json) {
    std::fputs(played.result.to_json().c_str(), stdout);
  } else if (played.result.status == RunStatus::kFailed) {
    std::printf("failed after %s of simulated time\n", seconds_text(played.result.sim_time).c_str());
  } else {
    if (played.result.status == RunStatus::kInterrupted)
      std::printf("interrupted after %s of simulated time; up to then:\n",
                  seconds_text(played.result.sim_time).c_str());
    std::fputs(played.result.score_board.c_str(), stdout);
    const std::size_t warnings = played.result.all_warnings().size();
    if (warnings > 0 || !played.result.rule_errors.empty())
      std::printf("warnings: %zu, errors of rules: %zu\n", warnings, played.result.rule_errors.size());
  }
  if (!options.quiet && played.result.status == RunStatus::kCompleted && until > duration &&
      to_seconds(played.result.sim_time) >= duration)
    std::fprintf(stderr, "ended after %s, the scenario's duration_s; for longer: --set duration_s=%g\n",
                 seconds_text(played.result.sim_time).c_str(), until);
  if (!options.json && !played.folder.empty()) std::printf("%s\n", address_of(played.folder).c_str());
  return code;
}

void declare(CLI::App& command, RunOptions& options) {
  suggest(
      command.add_option("scenario", options.scenario,
                         "Scenario: a file (YAML), or the name of one that comes with cxlab (cxlab list scenarios)"),
      scenario_names, true)
      ->required();
  command.add_option("--tier", options.tier, "physics: MuJoCo; timed: durations only")
      ->check(one_of({"physics", "timed"}));
  once_each(command.add_option("--set", options.overrides, "Changes a value: a.b[0].c=VALUE (may be given often)"));
  declare_bag(command, options.bag);
  command.add_option("--snapshot", options.play.snapshot, "Pictures: every:SECONDS or SECONDS,SECONDS,...");
  lab::VideoOptions& video = options.play.video;
  CLI::Option* film = command.add_option("--video", video.file, kVideoHelp);
  command.add_option("--video-camera", options.cameras, "As --camera of render")->needs(film);
  command
      .add_option("--video-size", options.video_size, "WIDTHxHEIGHT (default 960x600, for an animated image 640x400)")
      ->check(picture_size())
      ->needs(film);
  command
      .add_option("--video-frame-rate", video.frame_rate,
                  "Frames in a second of the film (default 25, for an animated image 10)")
      ->check(between(kFewestFrames, kMostFrames))
      ->needs(film);
  command.add_option("--video-max-size", options.most_of_video, kMaxSizeHelp)->check(byte_count())->needs(film);
  command.add_flag("--no-caption", options.no_caption,
                   "Leaves out the lines with time, points and the last events below pictures and film");
  command.add_option("--video-speed", video.speed, "Seconds of simulated time in a second of the film")
      ->check(between(kSlowest, kFastest))
      ->capture_default_str()
      ->needs(film);
  declare_play(command, options);
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Play a scenario");
  command->footer(
      "Examples:\n  cxlab run scenarios/rcll/game.yaml --seed 7\n  cxlab run scenarios/rcll/game.yaml --tier timed "
      "--set world.team=MAGENTA\n"
      "  cxlab run scenarios/rcll/game.yaml --snapshot every:300 --out /tmp/game\n"
      "  cxlab run scenarios/rcll/game.yaml --until 300 --video game.mp4 --video-camera top --video-speed 10");
  declare(*command, *options);
  command->callback([options, &action] { action = [options] { return run(*options); }; });
}

int run_first_program(int argc, char** argv, const Catalogue& catalogue) {
  return run_commands(argc, argv, catalogue, [](CLI::App& app, Action& action) -> Status {
    app.footer(
        "This is the part of cxlab that ./dev run builds first. ./dev cxlab --help builds the rest: other commands and "
        "worlds.");
    add_run(app, action);
    return {};
  });
}

}  // namespace cxlab::app
