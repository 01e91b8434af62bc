#include "lab/session.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "cx/bag/recording.h"
#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "lab/confine.h"
#include "lab/control/debugger.h"
#include "lab/manifest.h"
#include "lab/moment.h"
#include "lab/packages.h"
#include "lab/pictures.h"
#include "lab/scene_answer.h"
#include "lab/versions.h"
#include "lab/world_answer.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

class Meter : public WallMeter {
 public:
  void begin() override {
    start_ = Clock::now();
    runs_ = true;
  }
  void end() override {
    seconds_ += since(start_);
    runs_ = false;
  }
  double seconds() const { return seconds_; }
  /// A person lets the run wait, or lets it go on.
  void wait(bool begins) {
    if (runs_ && begins) seconds_ += since(start_);
    start_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }
  Clock::time_point start_;
  double seconds_ = 0;
  bool runs_ = false;
};

/// The socket at which a run is controlled, and what it does there.
struct Control {
  std::unique_ptr<ControlServer> server;
  std::unique_ptr<Debugger> debugger;
  inspect::Timelines timelines;  ///< what the person may ask about
  WorldRecords records;          ///< and what the world is asked with
  std::chrono::steady_clock::time_point wait_begun;
  std::chrono::steady_clock::duration waited{};  ///< in all
};

}  // namespace

/// Everything of one run that outlives the loop.
struct RunAtPlay {
  RunAtPlay();
  ~RunAtPlay();
  RunAtPlay(const RunAtPlay&) = delete;
  RunAtPlay& operator=(const RunAtPlay&) = delete;

  PlayOptions options;
  Scenario scenario;
  Host host;
  std::vector<double> snapshots;           // when, s
  std::filesystem::path folder;            // empty: nothing is written
  Control control;                         // outlives the episode
  std::unique_ptr<WhatIfControl> what_if;  // as this one
  std::unique_ptr<Happenings> happenings;  // and this one; for captions, if anything is drawn
  std::unique_ptr<Episode> episode;
  std::unique_ptr<Pictures> pictures;
  std::unique_ptr<Video> video;  // none if none is asked for
  std::chrono::steady_clock::time_point wall_start;
  Meter game, physics;
  Played played;
  bool refused = false;    // could not begin; its result says why
  Status so_far;           // an error has ended it
  std::int64_t ticks = 0;  // that were played
  bool over = false;       // its result is written
};

namespace {

/// The runs that are being played, for `note_crash`.
struct RunsAtPlay {
  std::mutex mutex;
  std::set<const RunAtPlay*> all;
};
RunsAtPlay& runs_at_play() {
  static RunsAtPlay runs;
  return runs;
}

Expected<std::filesystem::path> folder_of(const PlayOptions& options, const Scenario& scenario) {
  if (options.out == "none") return std::filesystem::path();
  if (options.out.empty()) return make_numbered_folder("runs", scenario.name + '-' + std::to_string(scenario.seed));
  if (Status s = make_output_folder(options.out, options.force); !s) return s.error();
  return std::filesystem::path(options.out);
}

Manifest manifest_of(const RunAtPlay& run) {
  namespace fs = std::filesystem;
  const Scenario& scenario = run.scenario;
  Manifest out;
  out.scenario = scenario.file.string();
  out.overrides = scenario.overrides;
  out.seed = scenario.seed;
  for (const auto& [name, version] : versions()) out.versions[name] = version;
  out.versions["ROS 2 CX studied"] = "90f440b1 (2026-06-13)";
  for (const auto& [name, value] : machine()) out.machine[name] = value;
  out.tier = scenario.tier_name();
  out.command = run.options.command;
  out.folder = fs::current_path().string();
  out.out = fs::absolute(run.folder).lexically_normal().string();
  out.spec = run.options.spec;
  out.spec.limits = run.host.limits();
  for (const Seat& seat : run.options.seats) out.seats.push_back(seat.name);
  for (const AgentSpec& agent : scenario.agents) out.agents.push_back({agent.config, scenario.shares(agent)});
  for (const auto& [key, file] : scenario.world_files) out.world_files[key] = fs::absolute(file.path).string();
  if (scenario.bag) {
    const fs::path file = fs::absolute(scenario.resolve(scenario.bag.file)).lexically_normal();
    out.bag["file"] = file.string();
    if (const auto digest = bag::digest_of(file)) out.bag["digest"] = *digest;
  }
  out.repeat = "cxlab rerun " + run.folder.string();
  return out;
}

std::vector<cx::Environment*> environments_of(const RunAtPlay& run) {
  return run.episode ? run.episode->environments() : std::vector<cx::Environment*>();
}

Status open_control(RunAtPlay& run) {
  const PlayOptions& options = run.options;
  if (!options.spec.what_if.empty()) {
    run.what_if = std::make_unique<WhatIfControl>(options.spec.what_if);
    run.what_if->watch([&run] { return environments_of(run); });
    return {};
  }
  const std::string& given = options.control_at;
  if (!options.control && !options.begin_stopped && given.empty()) return {};
  if (given.empty() && run.folder.empty())
    return usage_error("a run without a folder needs --control-at with the path of a socket, or 127.0.0.1:PORT");
  auto address = ControlAddress::parse(given.empty() ? (run.folder / "control.sock").string() : given);
  if (!address) return address.error();
  auto server = ControlServer::open(*address);
  if (!server) return server.error();
  Control& control = run.control;
  control.server = *std::move(server);
  const std::string& token = control.server->token();
  Debugger::Options debugger;
  debugger.begin_stopped = options.begin_stopped;
  debugger.address = given.empty() ? run.folder.string() : control.server->address().text();
  run.host.note("control: cxlab attach " + debugger.address + (token.empty() ? "" : " --token " + token));
  debugger.log = run.host.log;
  debugger.over = [&run] { return run.host.stopped(); };
  debugger.note = [&run](std::string_view text) { run.host.note(text); };
  debugger.waits = [&run](bool begins) {
    const auto now = std::chrono::steady_clock::now();
    run.game.wait(begins);
    if (begins)
      run.control.wait_begun = now;
    else
      run.control.waited += now - run.control.wait_begun;
  };
  control.debugger = std::make_unique<Debugger>(*control.server, std::move(debugger));
  control.debugger->watch(
      {.environments = [&run] { return environments_of(run); },
       .inspect =
           [&run](cx::Environment& environment) {
             return inspector_of(environment, *run.episode, run.control.timelines);
           },
       .look = [&run](const std::string& what) { return scene_text({run.episode->scene()}, what); },
       .look_json = [&run](const std::string& what) { return scene_json({run.episode->scene()}, what); },
       .world_questions = run.scenario.world.kind->questions,
       .ask_world = [&run](const WorldQuestion& question, const std::string& about) -> Expected<WorldAnswered> {
         const SimTime now = std::max(run.episode->now(), SimTime::zero());
         auto answer = question.ask({run.folder, run.scenario, run.control.records.all(), {}, now, false, about});
         if (!answer) return answer.error();
         return WorldAnswered{.answer = *std::move(answer), .to = now};
       }});
  run.host.log = control.debugger.get();
  return {};
}

/// Folders of packages that lie elsewhere than the scenario; empty: none.
std::string folders_elsewhere(const Scenario& scenario) {
  namespace fs = std::filesystem;
  constexpr std::size_t kMost = 5;
  const fs::path here = fs::absolute(scenario.file).lexically_normal().parent_path();
  std::set<std::string> folders;
  std::map<std::string, PackageSpec> packages = scenario.packages;
  for (const AgentSpec& agent : scenario.agents) packages.insert(agent.packages.begin(), agent.packages.end());
  for (const auto& [name, package] : packages) {
    const fs::path folder = fs::absolute(scenario.resolve(package.folder)).lexically_normal();
    const fs::path relative = folder.lexically_relative(here);
    if (relative.empty() || *relative.begin() == "..") folders.insert(folder.string());
  }
  std::string text;
  std::size_t shown = 0;
  for (const std::string& folder : folders)
    if (++shown <= kMost) text += (text.empty() ? "" : ", ") + folder;
  return shown > kMost ? text + ", and " + std::to_string(shown - kMost) + " more" : text;
}

/// When the run ends at the latest, s.
double end_of(const RunAtPlay& run) {
  const double duration = to_seconds(run.scenario.duration);
  return std::min(run.options.spec.until.value_or(duration), duration);
}

/// Waits for the wall clock; a signal to stop ends that, however long a tick is.
void wait_until(std::chrono::steady_clock::time_point then, const Host& host) {
  constexpr auto kSlice = std::chrono::milliseconds(20);
  for (auto now = std::chrono::steady_clock::now(); now < then && !host.stopped();
       now = std::chrono::steady_clock::now())
    std::this_thread::sleep_until(std::min(then, now + kSlice));
}

ViewMaker views_at_play(Episode& episode) {
  return [&episode](int width, int height) -> Expected<std::unique_ptr<View>> {
    auto view = view_of(episode.stage(), width, height);
    if (!view) return resource_error("no pictures: " + view.error().message);
    return view;
  };
}

/// A film from the episode's stage; none if none is asked for.
Expected<std::unique_ptr<Video>> start_video(const RunAtPlay& run) {
  const VideoOptions& options = run.options.video;
  if (options.file.empty()) return std::unique_ptr<Video>();
  return Video::create(options, views_at_play(*run.episode), run.host, run.happenings.get());
}

/// Prepares the pictures, and raises the wall before the first rule is read.
Status prepare_pictures(RunAtPlay& run) {
  if (!run.snapshots.empty() || !run.options.video.file.empty()) {
    run.happenings = std::make_unique<Happenings>(run.episode->scenario());
    run.episode->journal().observe(*run.happenings);
  }
  auto pictures =
      Pictures::create(*run.episode, run.folder, run.snapshots, run.options.video.caption, run.happenings.get());
  if (!pictures) return pictures.error();
  auto video = start_video(run);
  if (!video) return video.error();
  run.pictures = *std::move(pictures);
  run.video = *std::move(video);
  Wall drawn;
  drawn.read = run.options.also_read;
  drawn.pictures = !run.snapshots.empty() || run.video;
  confine(*run.episode, run.host, drawn);
  return {};
}

Status start_agents(RunAtPlay& run) {
  if (Status s = run.episode->start(); !s) return s;
  run.control.timelines.start_is_over();
  run.wall_start = std::chrono::steady_clock::now();
  return {};
}

bool has_ended(const RunAtPlay& run) {
  const std::optional<double>& until = run.options.spec.until;
  return run.episode->over() || run.host.stopped() || (until && to_seconds(run.episode->now()) >= *until);
}

Status play_tick(RunAtPlay& run, SimTime next) {
  Episode& episode = *run.episode;
  run.game.begin();
  const Status ticked = episode.tick_at(next);
  run.game.end();
  ++run.ticks;
  if (!ticked) return ticked;
  const SimTime now = episode.now();
  if (!run.snapshots.empty() || run.video) {
    const SimTime seen_until = has_ended(run) ? now : std::min(episode.next_tick(), from_seconds(end_of(run)));
    if (Status s = run.pictures->look(now, seen_until); !s) return s;
    if (run.video)
      if (Status s = run.video->look(now, seen_until); !s) return s;
  }
  run.host.show(to_seconds(now), end_of(run));
  if (!run.options.realtime && !run.options.spec.sockets) return {};
  run.game.begin();
  wait_until(run.wall_start + run.control.waited + std::chrono::duration_cast<std::chrono::nanoseconds>(now), run.host);
  run.game.end();
  return {};
}

/// Plays each tick up to `until`, unless the run ends or `pause` returns true after a tick.
void play_on(RunAtPlay& run, SimTime until, const std::function<bool()>& pause = {}) {
  for (SimTime next; run.so_far && !has_ended(run) && (next = run.episode->next_tick()) <= until;) {
    run.so_far = play_tick(run, next);
    if (pause && pause()) return;
  }
}

/// Completes what was drawn of a run that was played so, of one that failed as well.
Status complete_pictures(RunAtPlay& run, const Status& played) {
  if (run.pictures) run.played.pictures = run.pictures->taken();
  if (!run.video) return played;
  const Status finished = run.host.complete([&] { return run.video->finish(run.host); });
  if (finished) run.played.film = run.options.video.file;
  run.video.reset();
  return played ? finished : played;
}

RunStatus status_of(const RunAtPlay& run, const Status& played) {
  if (!played) return RunStatus::kFailed;
  if (run.host.stopped()) return RunStatus::kInterrupted;
  return run.episode->completed() ? RunStatus::kCompleted : RunStatus::kStopped;
}

/// What went wrong while files and plugins were loaded (with --keep-going there may be much), each once and in order;
/// then `failure`, if it is none of them.
std::vector<Error> errors_of(Episode& episode, const Error& failure) {
  std::vector<Error> out;
  const auto add = [&out](const Error& error) {
    const auto same = [&error](const Error& known) { return known.text() == error.text(); };
    if (std::none_of(out.begin(), out.end(), same)) out.push_back(error);
  };
  for (const auto& agent : episode.agents())
    for (const Error& error : agent->load_errors()) add(error);
  add(failure);
  return out;
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void finish(RunAtPlay& run, const Status& played) {
  Result& result = run.played.result;
  std::optional<Error>& failure = run.played.failure;
  result = run.episode->close(status_of(run, played), played ? std::nullopt : std::optional<Error>(played.error()));
  result.wall_time_s = run.game.seconds();
  result.physics_wall_s = run.physics.seconds();
  result.real_time_factor = run.game.seconds() > 0 ? to_seconds(result.sim_time) / run.game.seconds() : 0;
  result.peak_rss_mb = peak_rss_mb();
  const std::string json = result.to_json();
  failure = result.reason;
  const bool interrupted = result.status == RunStatus::kInterrupted;
  if (!run.folder.empty())
    if (Status written = replace_file(run.folder / "result.json", json); !written && !failure)
      failure = written.error();
  if (failure) {
    run.played.errors = errors_of(*run.episode, *failure);
    if (interrupted) failure.reset();
  } else if (!interrupted) {
    if (Status s = check_expectations(run.scenario.expect, json); !s) run.played.errors = {*(failure = s.error())};
  }
}

/// The answer for a run that could not begin. It has a folder all the same.
Expected<Played> refused(RunAtPlay& run, const Error& error) {
  run.played.result = unfinished_result(run.scenario);
  run.played.result.reason = error;
  if (!run.folder.empty())
    if (Status s = replace_file(run.folder / "result.json", run.played.result.to_json()); !s) return s.error();
  run.played.failure = error;
  run.played.errors = {error};
  return std::move(run.played);
}

EpisodeOptions episode_options(const RunAtPlay& run) {
  EpisodeOptions options = shared_episode_options(run.host, run.options.spec);
  options.log = run.host.log;
  return options;
}

/// A former run is replaced only by one that can begin.
Status try_out(const RunAtPlay& run) {
  std::error_code error;
  const std::string& out = run.options.out;
  if (!run.options.force || out.empty() || !std::filesystem::is_directory(out, error) ||
      std::filesystem::is_empty(out, error))
    return {};
  EpisodeOptions options = episode_options(run);
  options.log = nullptr;
  auto episode = Episode::load(run.scenario, options);
  if (!episode) return episode.error();
  const VideoOptions& video = run.options.video;
  if (video.file.empty() && run.snapshots.empty()) return {};
  const ViewMaker make = views_at_play(**episode);
  if (!video.file.empty()) return Video::check(video, make);
  const auto frames = Frames::create(make, {.caption = video.caption});
  return frames ? Status() : Status(frames.error());
}

/// The run that could not begin, or what is wrong with what was asked for.
Status refuse(RunAtPlay& run, Error error) {
  run.refused = true;
  return error;
}

/// Everything before the start.
Status set_up(RunAtPlay& run) {
  const PlayOptions& options = run.options;
  for (std::string& prefix : run.options.spec.prefixes)
    prefix = std::filesystem::absolute(prefix).lexically_normal().string();
  name_copies(run.options.spec.what_if);
  if (const std::string folders = folders_elsewhere(run.scenario); !folders.empty() && !run.scenario.trust_rules)
    run.host.note("rules may read " + folders);
  auto installed = installed_packages(options.spec.prefixes);
  if (!installed) return installed.error();
  for (const auto& [name, package_folder] : *installed)
    run.scenario.packages.try_emplace(name, PackageSpec{package_folder});
  run.played.scenario = run.scenario;
  auto snapshots = snapshot_times(options.snapshot, end_of(run));
  if (!snapshots) return snapshots.error();
  run.snapshots = *std::move(snapshots);
  if (Status s = try_out(run); !s) return refuse(run, s.error());
  auto folder = folder_of(options, run.scenario);
  if (!folder) return folder.error();
  run.folder = *std::move(folder);
  if (!run.folder.empty()) {
    Status written = replace_file(run.folder / "result.json", unfinished_result(run.scenario).to_json());
    if (written) written = replace_file(run.folder / "manifest.json", manifest_of(run).to_json());
    if (!written) return written.error();
    run.played.folder = run.folder;
    run.host.note("run: " + run.folder.string());
  }
  if (Status s = open_control(run); !s) return refuse(run, s.error());

  EpisodeOptions for_episode = episode_options(run);
  for_episode.seats = options.seats;
  for_episode.acts = options.acts;
  for_episode.run_folder = run.folder;
  for_episode.control = run.control.debugger.get();
  if (run.what_if) for_episode.control = run.what_if.get();
  for_episode.meters = options.meters;
  for_episode.meters.physics = &run.physics;
  for_episode.file_read = options.file_read;
  auto episode = Episode::load(run.scenario, for_episode);
  if (!episode) return refuse(run, episode.error());
  run.episode = *std::move(episode);
  if (run.control.debugger) {
    run.episode->journal().observe(run.control.timelines);
    run.episode->journal().observe(run.control.records);
  }
  return {};
}

/// Ends a run that could begin.
Played conclude(RunAtPlay& run, const Status& played) {
  finish(run, complete_pictures(run, played));
  if (run.what_if) run.played.changed = run.what_if->done();
  if (run.control.debugger)
    run.control.debugger->end(std::string(to_string(run.played.result.status)) + " at " +
                              fixed_text(to_seconds(run.played.result.sim_time), 3) + " s");
  run.over = true;
  return std::move(run.played);
}

}  // namespace

EpisodeOptions shared_episode_options(const Host& host, RunSpec spec) {
  const Share share = find_share();
  EpisodeOptions options;
  options.spec = std::move(spec);
  options.spec.limits = host.limits();
  options.interfaces = share.interfaces;
  options.models = share.models;
  return options;
}

RunAtPlay::RunAtPlay() {
  const std::scoped_lock lock(runs_at_play().mutex);
  runs_at_play().all.insert(this);
}
RunAtPlay::~RunAtPlay() {
  const std::scoped_lock lock(runs_at_play().mutex);
  runs_at_play().all.erase(this);
}

void note_crash(const Error& error) {
  for (const RunAtPlay* run : std::exchange(runs_at_play().all, {})) {
    if (run->folder.empty() || run->over) continue;
    Result result = unfinished_result(run->scenario);
    result.reason = error;
    if (run->episode) result.sim_time = std::max(run->episode->now(), SimTime::zero());
    (void)replace_file(run->folder / "result.json", result.to_json());
    if (run->episode) run->episode->flush();
  }
}

Expected<Played> play_scenario(const PlayOptions& options, Scenario scenario, const Host& host) {
  RunAtPlay run;
  run.options = options;
  run.scenario = std::move(scenario);
  run.host = host;
  if (Status s = set_up(run); !s) return run.refused ? refused(run, s.error()) : s.error();
  run.so_far = prepare_pictures(run);
  if (run.so_far) run.so_far = start_agents(run);
  play_on(run, kNever);
  return conclude(run, run.so_far);
}

Session::Session() : run_(std::make_unique<RunAtPlay>()) {}
Session::~Session() = default;

Expected<std::unique_ptr<Session>> Session::load(const PlayOptions& options, Scenario scenario, const Host& host) {
  std::unique_ptr<Session> session(new Session);
  RunAtPlay& run = *session->run_;
  run.options = options;
  run.scenario = std::move(scenario);
  run.host = host;
  if (Status s = set_up(run); !s) {
    if (run.refused) (void)refused(run, s.error());
    return s.error();
  }
  Status started = prepare_pictures(run);
  if (started) started = start_agents(run);
  if (started) return session;
  const Played played = conclude(run, started);
  return played.failure ? *played.failure : started.error();
}

Expected<StepReport> Session::step(SimTime until, const std::function<bool()>& pause) {
  RunAtPlay& run = *run_;
  const std::int64_t before = run.ticks;
  play_on(run, until, pause);
  if (!run.so_far) return run.so_far.error();
  return StepReport{run.episode->now(), run.ticks - before, has_ended(run)};
}

Status Session::join(const Seat& seat) {
  RunAtPlay& run = *run_;
  if (Status s = run.episode->join(seat); !s) return s;
  run.options.seats.push_back(seat);
  return run.folder.empty() ? Status() : replace_file(run.folder / "manifest.json", manifest_of(run).to_json());
}

bool Session::over() const { return !run_->so_far || has_ended(*run_); }

Episode& Session::episode() { return *run_->episode; }

Played Session::close() {
  RunAtPlay& run = *run_;
  // The caller ends it here: who plays it again does so, too.
  if (run.so_far && !has_ended(run)) {
    run.options.spec.until = to_seconds(std::max(run.episode->now(), SimTime::zero()));
    if (!run.folder.empty()) run.so_far = replace_file(run.folder / "manifest.json", manifest_of(run).to_json());
  }
  return conclude(run, run.so_far);
}

}  // namespace cxlab::lab
