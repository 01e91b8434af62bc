// cxlab render: one picture, of a recorded run or of a scenario that is played up to then.

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/suggestions.h"
#include "lab/render.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

struct Options : lab::RenderOptions {
  std::string what, size = "960x720";
  std::optional<std::uint64_t> seed;
  std::vector<std::string> overrides;
};

Status read_size(const std::string& text, lab::RenderOptions& options) {
  char rest = 0;
  constexpr int kLeast = 16, kMost = 4096;
  const auto fits = [](int pixels) { return pixels >= kLeast && pixels <= kMost; };
  if (std::sscanf(text.c_str(), "%dx%d%c", &options.width, &options.height, &rest) == 2 && fits(options.width) &&
      fits(options.height))
    return {};
  return usage_error("--size: found '" + text + "', expected WIDTHxHEIGHT, each from 16 to 4096");
}

/// Pictures are PNG, whatever their name.
Status check_name(const std::string& out) {
  std::string suffix = fs::path(out).extension().string();
  std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (suffix.empty() || suffix == ".png") return {};
  return usage_error("--out: found '" + out + "', expected a name that ends in .png");
}

Status draw(const Options& options, const lab::Host& host) {
  if (fs::is_directory(options.what)) {
    auto run = lab::RecordedRun::open(options.what, catalogue());
    return run ? lab::render_run(*run, options) : Status(run.error());
  }
  std::vector<Override> overrides(options.overrides.begin(), options.overrides.end());
  if (options.seed) overrides.emplace_back("seed=" + std::to_string(*options.seed), "--seed");
  const auto file = find_scenario(options.what);
  if (!file) return file.error();
  auto scenario = Scenario::load(*file, catalogue(), overrides);
  return scenario ? lab::render_scenario(*std::move(scenario), options, host) : Status(scenario.error());
}

int render(Options options) {
  if (Status s = read_size(options.size, options); !s) return fail(s.error());
  if (Status s = check_name(options.out); !s) return fail(s.error());
  Console console(false);
  const Status drawn = draw(options, console.host());
  console.clear();
  if (const int code = interrupted("there is no picture")) return code;
  if (!drawn) return fail(drawn.error());
  std::printf("%s\n", options.out.c_str());
  return 0;
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("render", "Draws the world of a run or of a scenario at a time");
  add_limit_options(*command);
  suggest(command->add_option("what", options->what, "Folder of a run, or a scenario, which is played up to then"),
          scenario_names, true)
      ->required();
  command
      ->add_option("--at", options->at,
                   "When, s of simulated time (of a run: default its end, or how far its log goes)")
      ->check(not_negative());
  command->add_option("--out", options->out, "The picture (PNG)")->required();
  command->add_option("--camera", options->camera,
                      "Of a factory: field (default), top, follow-robot1, robot1 (what it sees) or a machine (C-CS1); "
                      "of turtles: canvas");
  command->add_option("--size", options->size, "WIDTHxHEIGHT; a canvas of turtles is the largest square in it")
      ->capture_default_str();
  seed_number(command->add_option("--seed", options->seed, "Of a scenario: seed of all chance"));
  once_each(command->add_option("--set", options->overrides, "Of a scenario: changes a value, a.b[0].c=VALUE"));
  command->footer(
      "Example:\n  cxlab render scenarios/rcll/game.yaml --at 60 --out field.png --camera top\n  cxlab render "
      "scenarios/turtlesim/figures.yaml --at 40 --out figures.png --size 500x500");
  command->callback([options, &action] { action = [options] { return render(*options); }; });
}

}  // namespace cxlab::app
