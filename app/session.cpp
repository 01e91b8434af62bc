#include "app/session.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/log_printer.h"
#include "app/packages.h"
#include "app/pictures.h"
#include "app/report.h"
#include "cx/engine/version.h"
#include "cx/journal/run_folder.h"
#include "scenarios/episode.h"
#include "scenarios/share.h"
#include "sim/box2d/library.h"
#include "sim/mujoco/library.h"

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
  std::vector<std::string> named_prefixes;  // absolute
  std::vector<double> snapshots;            // when, s
  std::optional<RunFolder> folder;
  std::unique_ptr<Episode> episode;
  Meter game, physics;
  Report report;
};

Expected<std::optional<RunFolder>> make_folder(const RunOptions& options, const Scenario& scenario) {
  if (options.out == "none") return std::optional<RunFolder>();
  auto folder = options.out.empty()
                    ? RunFolder::create_numbered("runs", scenario.name + '-' + std::to_string(scenario.seed))
                    : RunFolder::create_at(options.out, options.force);
  if (!folder) return folder.error();
  return std::optional<RunFolder>(*std::move(folder));
}

std::string manifest(const Run& run) {
  nlohmann::ordered_json out;
  out["schema"] = 1;
  out["scenario"] = run.scenario.file.string();
  out["overrides"] = run.scenario.overrides;
  out["seed"] = run.scenario.seed;
  out["versions"] = {{"cxlab", CXLAB_VERSION},
                     {"CLIPS", clips_version()},
                     {"MuJoCo", sim::mujoco_version()},
                     {"Box2D", sim::box2d_version()},
                     {"ROS 2 CX studied", "90f440b1 (2026-06-13)"}};
  out["tier"] = run.scenario.world_kind == Scenario::WorldKind::kNone ? "none"
                : run.scenario.tier == Tier::kTimed                   ? "timed"
                                                                      : "physics";
  out["command"] = command_line();
  out["folder"] = std::filesystem::current_path().string();
  out["until"] = run.options.until ? nlohmann::ordered_json(*run.options.until) : nlohmann::ordered_json(nullptr);
  out["journal"] = run.options.journal;
  out["keep_going"] = run.options.keep_going;
  out["strict_cx"] = run.options.strict;
  out["prefixes"] = run.named_prefixes;
  out["agents"] = nlohmann::ordered_json::array();
  for (const AgentSpec& agent : run.scenario.agents)
    out["agents"].push_back({{"config", agent.config}, {"packages", run.scenario.shares(agent)}});
  out["repeat"] = "cxlab rerun " + run.folder->path().string();
  return out.dump(2) + '\n';
}

/// When the run ends at the latest, s.
double end_of(const Run& run) {
  const double duration = to_seconds(run.scenario.duration);
  return std::min(run.options.until.value_or(duration), duration);
}

Status play(Run& run, Progress& progress) {
  Episode& episode = *run.episode;
  const double end = end_of(run);
  auto pictures = Pictures::create(episode, run.folder ? &*run.folder : nullptr, run.snapshots, run.options.video);
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

/// Those that a person reads, relative to the run's folder.
std::vector<std::string> readable_files(const std::filesystem::path& folder) {
  std::vector<std::string> out = {"result.json", "manifest.json", "journal.jsonl"};
  std::error_code ignored;
  std::vector<std::string> logs;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "logs", ignored))
    if (!entry.is_symlink()) logs.push_back("logs/" + entry.path().filename().string());
  std::sort(logs.begin(), logs.end());
  out.insert(out.end(), logs.begin(), logs.end());
  return out;
}

RunStatus status_of(const Run& run, const Status& played) {
  if (!played) return RunStatus::kFailed;
  if (g_signal) return RunStatus::kInterrupted;
  return run.episode->completed() ? RunStatus::kCompleted : RunStatus::kStopped;
}

/// What went wrong while files and plugins were loaded (with --keep-going there may be much), each once and in order;
/// then `failure`, if it is none of them.
std::vector<Error> errors_of(Episode& episode, const Error& failure) {
  std::vector<Error> out;
  const auto add = [&out](const Error& error) {
    const auto same = [&error](const Error& told) { return told.text() == error.text(); };
    if (std::none_of(out.begin(), out.end(), same)) out.push_back(error);
  };
  for (const auto& agent : episode.agents())
    for (const Error& error : agent->load_errors()) add(error);
  add(failure);
  return out;
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
    run.report.files = readable_files(run.folder->path());
    if (written) written = run.folder->write("index.html", to_html(run.report));
    if (!written && !failure) failure = written.error();
  }
  if (run.options.json && !run.options.silent) std::fputs(json.c_str(), stdout);
  if (!run.options.json && !run.options.silent) std::fputs(score_board(result).c_str(), stdout);
  if (run.folder && !run.options.json && !run.options.silent)
    std::printf("%s\n", (run.folder->path() / "index.html").c_str());
  if (failure) {
    for (const Error& e : errors_of(*run.episode, *failure)) (void)fail(e);
    return static_cast<int>(failure->kind);
  }
  if (g_signal) return 128 + g_signal;
  if (Status s = check_expectations(run.scenario.expect, json, run.scenario.file.string()); !s) return fail(s.error());
  return 0;
}

}  // namespace

void watch_signals() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
}

int signal_that_came() { return g_signal; }

EpisodeOptions shared_episode_options() {
  const Share share = find_share();
  EpisodeOptions options;
  options.interfaces = share.interfaces;
  options.models = share.models;
  return options;
}

Played play_scenario(const RunOptions& options, Scenario scenario) {
  const auto failed = [](const Error& error) { return Played{fail(error), {}, {}}; };
  Run run;
  run.options = options;
  run.scenario = std::move(scenario);
  for (const std::string& prefix : options.prefixes)
    run.named_prefixes.push_back(std::filesystem::absolute(prefix).lexically_normal().string());
  auto installed = installed_packages(run.named_prefixes);
  if (!installed) return failed(installed.error());
  run.scenario.packages.merge(*installed);
  const auto level = parse_journal_level(options.journal);
  if (!level) return failed(usage_error("--journal: " + level.error().message));
  auto snapshots = snapshot_times(options.snapshot, end_of(run));
  if (!snapshots) return failed(snapshots.error());
  run.snapshots = *std::move(snapshots);
  auto folder = make_folder(options, run.scenario);
  if (!folder) return failed(folder.error());
  run.folder = *std::move(folder);
  if (run.folder) {
    Status written = run.folder->write("result.json", unfinished_result(run.scenario).to_json());
    if (written) written = run.folder->write("manifest.json", manifest(run));
    if (!written) return failed(written.error());
    std::fprintf(stderr, "run: %s\n", run.folder->path().c_str());
  }
  watch_signals();

  Progress progress(options.quiet);
  LogPrinter printer(progress, options.quiet);
  EpisodeOptions episode_options = shared_episode_options();
  if (run.folder) episode_options.run_folder = run.folder->path();
  episode_options.journal = *level;
  episode_options.log = &printer;
  episode_options.physics_meter = &run.physics;
  episode_options.keep_going = options.keep_going;
  episode_options.strict = options.strict;
  auto episode = Episode::load(run.scenario, episode_options);
  if (!episode) {
    if (run.folder) {
      Result result = unfinished_result(run.scenario);
      result.reason = episode.error();
      if (Status s = run.folder->write("result.json", result.to_json()); !s) return failed(s.error());
    }
    return failed(episode.error());
  }
  run.episode = *std::move(episode);
  const Status played = play(run, progress);
  progress.clear();
  const int exit_code = finish(run, played);
  return {exit_code, run.report.result, run.folder ? run.folder->path() : std::filesystem::path()};
}

}  // namespace cxlab::app
