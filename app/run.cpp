// cxlab run: plays one episode.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/command.h"
#include "app/console.h"
#include "app/log_printer.h"
#include "app/pictures.h"
#include "app/report.h"
#include "app/run_options.h"
#include "app/share.h"
#include "cx/engine/version.h"
#include "cx/journal/run_folder.h"
#include "scenarios/episode.h"
#include "sim/mujoco/version.h"

namespace cxlab::app {

namespace {

volatile std::sig_atomic_t g_signal = 0;
void remember_signal(int number) { g_signal = number; }

class Meter : public WallMeter {
 public:
  void begin() override { start_ = Clock::now(); }
  void end() override { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  double seconds() const { return seconds_; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_;
  double seconds_ = 0;
};

/// Everything of one run that outlives the loop.
struct Run {
  RunOptions options;
  Scenario scenario;
  std::optional<RunFolder> folder;
  std::unique_ptr<Episode> episode;
  Meter game, physics;
  Report report;
};

Expected<Scenario> load_scenario(const RunOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.seed) overrides.push_back("seed=" + std::to_string(*options.seed));
  if (!options.tier.empty()) overrides.push_back("tier=" + options.tier);
  return Scenario::load(options.scenario, overrides);
}

Expected<std::optional<RunFolder>> make_folder(const RunOptions& options, const Scenario& scenario) {
  if (options.out == "none") return std::optional<RunFolder>();
  auto folder = options.out.empty() ? RunFolder::create_numbered("runs", scenario.name + '-' + std::to_string(scenario.seed))
                                    : RunFolder::create_at(options.out, options.force);
  if (!folder) return folder.error();
  return std::optional<RunFolder>(*std::move(folder));
}

std::string manifest(const Run& run, const std::vector<std::string>& command_line) {
  nlohmann::ordered_json out;
  out["schema"] = 1;
  out["scenario"] = run.scenario.file.string();
  out["overrides"] = run.scenario.overrides;
  out["seed"] = run.scenario.seed;
  out["tier"] = run.scenario.tier == Tier::kTimed ? "timed" : "physics";
  out["versions"] = {{"cxlab", CXLAB_VERSION}, {"CLIPS", clips_version()}, {"MuJoCo", sim::mujoco_version()}, {"ROS 2 CX studied", "90f440b1 (2026-06-13)"}};
  out["command"] = command_line;
  out["repeat"] = "cxlab rerun " + run.folder->path().string();
  return out.dump(2) + '\n';
}

Status play(Run& run, Progress& progress) {
  Episode& episode = *run.episode;
  const double end = run.options.until.value_or(to_seconds(run.scenario.duration));
  auto times = snapshot_times(run.options.snapshot, end);
  if (!times) return times.error();
  auto pictures = Pictures::create(episode, run.folder ? &*run.folder : nullptr, *times, run.options.video);
  if (!pictures) return pictures.error();

  if (Status s = episode.start(); !s) return s;
  const auto wall_start = std::chrono::steady_clock::now();
  while (!episode.over() && !g_signal && !(run.options.until && to_seconds(episode.now()) >= *run.options.until)) {
    run.game.begin();
    const Status ticked = episode.tick();
    run.game.end();
    if (!ticked) return ticked;
    if (Status s = (*pictures)->look(episode); !s) return s;
    progress.show(to_seconds(episode.now()), end, {});
    if (run.options.realtime)
      std::this_thread::sleep_until(wall_start + std::chrono::duration_cast<std::chrono::nanoseconds>(episode.now()));
  }
  if (Status s = (*pictures)->finish(); !s) return s;
  run.report.pictures = (*pictures)->taken();
  return {};
}

RunStatus status_of(const Run& run, const Status& played) {
  if (!played) return RunStatus::kFailed;
  if (g_signal) return RunStatus::kInterrupted;
  return run.episode->completed() ? RunStatus::kCompleted : RunStatus::kStopped;
}

int finish(Run& run, const Status& played) {
  Result& result = run.report.result;
  result = run.episode->close(status_of(run, played), played ? std::nullopt : std::optional<Error>(played.error()));
  result.wall_time_s = run.game.seconds();
  result.physics_wall_s = run.physics.seconds();
  result.real_time_factor = run.game.seconds() > 0 ? to_seconds(result.sim_time) / run.game.seconds() : 0;
  result.peak_rss_mb = peak_rss_mb();
  const std::string json = result.to_json();
  std::optional<Error> failure = result.reason;
  if (run.folder) {
    Status written = run.folder->write("result.json", json);
    if (written) written = read_story(run.folder->path() / "journal.jsonl", run.report);
    if (written) written = run.folder->write("index.html", to_html(run.report));
    if (!written && !failure) failure = written.error();
  }
  if (run.options.json) std::fputs(json.c_str(), stdout);
  else std::fputs(score_board(result).c_str(), stdout);
  if (run.folder && !run.options.json) std::printf("%s\n", (run.folder->path() / "index.html").c_str());
  if (failure) return fail(*failure);
  if (g_signal) return 128 + g_signal;
  if (Status s = check_expectations(run.scenario.expect, json, run.scenario.file.string()); !s) return fail(s.error());
  return 0;
}

}  // namespace

Expected<std::vector<double>> snapshot_times(const std::string& text, double end) {
  const auto bad = [&](const std::string& found) {
    return Error{ErrorKind::kUsage, "--snapshot: found '" + found + "', expected every:SECONDS or SECONDS,SECONDS,...", {}, 0, {}};
  };
  const auto seconds = [](const std::string& word) -> std::optional<double> {
    char* rest = nullptr;
    const double value = std::strtod(word.c_str(), &rest);
    return !word.empty() && *rest == '\0' && value >= 0 && value < 1e9 ? std::optional<double>(value) : std::nullopt;
  };
  std::vector<double> times;
  if (text.empty()) return times;
  if (text.starts_with("every:")) {
    const auto step = seconds(text.substr(6));
    if (!step || *step <= 0) return bad(text);
    for (int k = 0; k * *step <= end; ++k) times.push_back(k * *step);
    return times;
  }
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto time = seconds(word);
    if (!time) return bad(text);
    times.push_back(*time);
  }
  std::sort(times.begin(), times.end());
  return times;
}

int run_episode(const RunOptions& options, const std::vector<std::string>& command_line) {
  Run run;
  run.options = options;
  const auto level = parse_journal_level(options.journal);
  if (!level) return fail(Error{ErrorKind::kUsage, "--journal: " + level.error().message, {}, 0, {}});
  auto scenario = load_scenario(options);
  if (!scenario) return fail(scenario.error());
  run.scenario = *std::move(scenario);
  auto folder = make_folder(options, run.scenario);
  if (!folder) return fail(folder.error());
  run.folder = *std::move(folder);
  if (run.folder) {
    Status written = run.folder->write("result.json", unfinished_result(run.scenario).to_json());
    if (written) written = run.folder->write("manifest.json", manifest(run, command_line));
    if (!written) return fail(written.error());
    std::fprintf(stderr, "run: %s\n", run.folder->path().c_str());
  }
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);

  Progress progress(options.quiet);
  LogPrinter printer(progress, options.quiet);
  EpisodeOptions episode_options;
  if (run.folder) episode_options.run_folder = run.folder->path();
  episode_options.journal = *level;
  episode_options.log = &printer;
  episode_options.physics_meter = &run.physics;
  const Share share = find_share();
  episode_options.interfaces = share.interfaces;
  episode_options.models = share.models;
  auto episode = Episode::load(run.scenario, episode_options);
  if (!episode) {
    if (run.folder) {
      Result result = unfinished_result(run.scenario);
      result.reason = episode.error();
      if (Status s = run.folder->write("result.json", result.to_json()); !s) return fail(s.error());
    }
    return fail(episode.error());
  }
  run.episode = *std::move(episode);
  const Status played = play(run, progress);
  progress.clear();
  return finish(run, played);
}

void declare(CLI::App& command, RunOptions& options) {
  command.add_option("scenario", options.scenario, "Scenario file (YAML)")->required();
  command.add_option("--seed", options.seed, "Seed of all chance, instead of the scenario's");
  command.add_option("--tier", options.tier, "physics: MuJoCo; timed: durations only")->check(CLI::IsMember({"physics", "timed"}));
  command.add_option("--set", options.overrides, "Changes a value: a.b[0].c=VALUE (may be given often)")->take_all();
  command.add_option("--until", options.until, "Stops at this simulated time, s")->check(CLI::NonNegativeNumber);
  command.add_option("--out", options.out, "Folder of the run; 'none' writes nothing (default runs/<scenario>-<seed>)");
  command.add_flag("--force", options.force, "Overwrites a folder that is in use");
  command.add_option("--journal", options.journal, "What journal.jsonl holds: none, decisions or full")->capture_default_str();
  command.add_flag("--realtime", options.realtime, "Sleeps between ticks, to watch");
  command.add_option("--snapshot", options.snapshot, "Pictures: every:SECONDS or SECONDS,SECONDS,...");
  command.add_option("--video", options.video, "Film of the game (needs ffmpeg)");
  command.add_flag("--json", options.json, "Prints result.json instead of the score board");
  command.add_flag("--quiet", options.quiet, "No progress and no log lines");
}

void add_run(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Plays a scenario");
  command->footer("Examples:\n  cxlab run scenarios/rcll/game.yaml --seed 7\n  cxlab run scenarios/rcll/game.yaml --tier timed --set world.team=MAGENTA\n"
                  "  cxlab run scenarios/rcll/game.yaml --snapshot every:300 --out /tmp/game");
  declare(*command, *options);
  command->callback([options, &action] {
    action = [options] { return run_episode(*options, command_line()); };
  });
}

}  // namespace cxlab::app
