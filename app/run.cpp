// cxlab run: plays one episode.

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "scenarios/share.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::app {

namespace {

struct Options : PlayCommand {
  std::string scenario, tier;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> overrides;
};

int run(const Options& options) {
  std::vector<Override> overrides(options.overrides.begin(), options.overrides.end());
  if (options.seed) overrides.emplace_back("seed=" + std::to_string(*options.seed), "--seed");
  if (!options.tier.empty()) overrides.emplace_back("tier=" + options.tier, "--tier " + options.tier);
  const auto file = find_scenario(options.scenario);
  if (!file) return fail(file.error());
  auto scenario = Scenario::load(*file, shipped(), overrides);
  if (!scenario) return fail(scenario.error());
  const auto [code, played] = play(options, *std::move(scenario));
  if (played.result.journal_hash.empty()) return code;
  if (options.json) {
    std::fputs(played.result.to_json().c_str(), stdout);
  } else if (played.result.status == RunStatus::kFailed) {
    std::printf("failed after %.3f s of simulated time\n", to_seconds(played.result.sim_time));
  } else {
    std::fputs(played.result.score_board.c_str(), stdout);
  }
  if (!options.json && !played.folder.empty()) std::printf("%s\n", (played.folder / "index.html").c_str());
  return code;
}

void declare(CLI::App& command, Options& options) {
  command
      .add_option("scenario", options.scenario,
                  "Scenario: a file (YAML), or the name of one that comes with cxlab (cxlab list scenarios)")
      ->required();
  command.add_option("--seed", options.seed, "Seed of all chance, instead of the scenario's")->check(seed_number());
  command.add_option("--tier", options.tier, "physics: MuJoCo; timed: durations only")
      ->check(CLI::IsMember({"physics", "timed"}));
  command.add_option("--set", options.overrides, "Changes a value: a.b[0].c=VALUE (may be given often)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--until", options.play.until, "Stops at this simulated time, s")->check(not_negative());
  command.add_option("--out", options.play.out,
                     "Folder of the run; 'none' writes nothing (default runs/<scenario>-<seed>)");
  command.add_flag("--force", options.play.force, "Overwrites a folder that is in use");
  command.add_option("--journal", options.play.journal, "What journal.jsonl holds: none, decisions or full")
      ->capture_default_str();
  command.add_flag("--strict-cx", options.play.strict, "Parameters that CX does not know are errors, not INFO lines");
  command
      .add_option("--prefix,--plugin-path", options.play.prefixes,
                  "DIR: packages installed below it are found, with their plugins (also $CXLAB_PREFIX_PATH)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_flag("--realtime", options.play.realtime, "Sleeps between ticks, to watch");
  command.add_option("--snapshot", options.play.snapshot, "Pictures: every:SECONDS or SECONDS,SECONDS,...");
  command.add_option("--video", options.play.video, "Film of the game (needs ffmpeg)");
  command.add_flag("--json", options.json, "Prints result.json instead of the score board");
  command.add_flag("--quiet", options.quiet, "No progress and no log lines");
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("run", "Plays a scenario");
  command->footer(
      "Examples:\n  cxlab run scenarios/rcll/game.yaml --seed 7\n  cxlab run scenarios/rcll/game.yaml --tier timed "
      "--set world.team=MAGENTA\n"
      "  cxlab run scenarios/rcll/game.yaml --snapshot every:300 --out /tmp/game");
  declare(*command, *options);
  command->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace cxlab::app
