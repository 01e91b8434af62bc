// cxlab render: a picture or a film, of a recorded run or of a scenario that is played up to then.

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/suggestions.h"
#include "cx/base/file.h"
#include "lab/render.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

struct RenderOptions {
  std::string what, size, camera, most;
  bool no_caption = false;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> overrides;
  lab::RenderOptions picture;
  lab::FilmOptions film;
};

/// Pictures are PNG, whatever their name.
Status check_name(const std::string& out) {
  std::string suffix = fs::path(out).extension().string();
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix.empty() || suffix == ".png") return {};
  return usage_error("--out: " + found_text(out, "a name that ends in .png"));
}

Expected<Scenario> load_scenario(const RenderOptions& options) {
  std::vector<Override> overrides(options.overrides.begin(), options.overrides.end());
  if (options.seed) overrides.emplace_back("seed=" + std::to_string(*options.seed), "--seed");
  const auto file = find_scenario(options.what);
  if (!file) return file.error();
  return Scenario::load(*file, catalogue(), overrides);
}

Status draw(const RenderOptions& options, const lab::Host& host) {
  const bool film = !options.film.video.file.empty();
  if (is_folder(options.what)) {
    if (options.seed || !options.overrides.empty())
      return usage_error(std::string(options.seed ? "--seed" : "--set") + ": " + options.what +
                         " is a run, which was played already: only a scenario takes it");
    auto run = lab::Run::open(options.what, catalogue());
    if (!run) return run.error();
    return film ? lab::film_run(*run, options.film, host) : lab::render_run(*run, options.picture);
  }
  auto scenario = load_scenario(options);
  if (!scenario) return scenario.error();
  return film ? lab::film_scenario(*std::move(scenario), options.film, host)
              : lab::render_scenario(*std::move(scenario), options.picture, host);
}

int render(RenderOptions options) {
  lab::RenderOptions& picture = options.picture;
  lab::VideoOptions& video = options.film.video;
  const std::string out = video.file.empty() ? picture.out.string() : video.file;
  if (out.empty()) return fail(usage_error(found_expected("nothing to draw", "--out PICTURE or --video FILM")));
  if (Status s = check_name(picture.out.string()); !s) return fail(s.error());
  if (Status s = make_folder_of(out); !s) return fail(s.error());
  if (!options.size.empty()) {
    read_size(options.size, picture.width, picture.height);
    video.width = picture.width;
    video.height = picture.height;
  }
  picture.cameras = video.cameras = lab::camera_names(options.camera);
  picture.caption = video.caption = !options.no_caption;
  video.most_bytes = read_bytes(options.most);
  Console console(false);
  const Status drawn = draw(options, console.host());
  console.clear();
  const std::string left = video.file.empty() ? "there is no picture" : video.file + " ends there";
  if (const int code = interrupted(left)) return code;
  if (!drawn) return fail(drawn.error());
  std::printf("%s\n", out.c_str());
  return 0;
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Draw the world of a run or of a scenario");
  add_limit_options(*command);
  suggest(command->add_option("what", options->what, "Folder of a run, or a scenario, which is played up to --at"),
          scenario_names, true)
      ->required();
  CLI::Option* out = command->add_option("--out", options->picture.out, "A picture (PNG)");
  CLI::Option* at = time_option(
      command->add_option("--at", options->picture.at,
                          "Time: s of simulated time, or 5:12.4 (default for a run: its end, or the end of its log)"));
  CLI::Option* film = command->add_option("--video", options->film.video.file, kVideoHelp)->excludes(out)->excludes(at);
  time_option(command->add_option("--from", options->film.from, "Film: its beginning, s"))->needs(film);
  time_option(command->add_option("--to", options->film.to, "Film: its end, s (default: the end of the run)"))
      ->needs(film);
  command->add_option("--speed", options->film.video.speed, "Film: seconds of simulated time in a second of the film")
      ->check(between(kSlowest, kFastest))
      ->capture_default_str()
      ->needs(film);
  command
      ->add_option("--frame-rate", options->film.video.frame_rate,
                   "Film: frames in a second (default 25, for an animated image 10)")
      ->check(between(kFewestFrames, kMostFrames))
      ->needs(film);
  command->add_option("--max-size", options->most, kMaxSizeHelp)->check(byte_count())->needs(film);
  command->add_option("--camera", options->camera,
                      "Factory: field (default), top, follow-robot1, robot1 (what it sees) or a machine (C-CS1). "
                      "Turtles: canvas. Several side by side: field,follow-robot1");
  command
      ->add_option("--size", options->size,
                   "WIDTHxHEIGHT (default 960x600, for an animated image 640x400); a canvas of turtles is the largest "
                   "square in it")
      ->check(picture_size());
  command->add_flag("--no-caption", options->no_caption, "Leaves out the lines with time, points and the last events");
  seed_number(command->add_option("--seed", options->seed, "Scenario: seed of all chance"));
  once_each(command->add_option("--set", options->overrides, "Scenario: changes a value, a.b[0].c=VALUE"));
  command->footer(
      "Examples:\n  cxlab render scenarios/rcll/game.yaml --at 60 --out field.png --camera top\n"
      "  cxlab render runs/game-1 --video film.mp4 --from 30 --to 120 --speed 5 --camera field,follow-robot1\n"
      "  cxlab render runs/game-1 --video game.gif --max-size 2MB\n"
      "  cxlab render scenarios/turtlesim/figures.yaml --at 40 --out figures.png --size 500x500");
  command->callback([options, &action] { action = [options] { return render(*options); }; });
}

}  // namespace cxlab::app
