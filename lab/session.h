#pragma once
// Plays a scenario from beginning to end into the folder of a run: journal, logs, pictures, result.
//
//   auto scenario = Scenario::load("game.yaml", shipped());
//   auto played = lab::play_scenario({.out = "runs/first"}, *std::move(scenario));
//   if (played && !played->failure) ... played->result.score_board ...
//
// or step by step, with agents that are programs (scenarios/seat.h):
//
//   options.seats = {seat_of<Pilot>("pilot")};
//   auto session = lab::Session::load(options, *std::move(scenario));
//   while (auto step = (*session)->step(t += 1s)) if (look((*session)->episode()); step->over) break;
//   lab::Played played = (*session)->close();

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/picture.h"
#include "lab/video.h"
#include "lab/what_if.h"
#include "scenarios/episode.h"

namespace cxlab::lab {

struct PlayOptions {
  RunSpec spec = {};
  std::vector<Seat> seats = {};           ///< agents that are programs, after those of the scenario
  std::vector<PastAct> acts = {};         ///< `EpisodeOptions::acts`
  std::string out = {};                   ///< empty = runs/<scenario>-<seed>, "none" = nothing is written
  bool force = false;                     ///< `out` may be a folder in use
  bool realtime = false;                  ///< sleeps between ticks, as a run with sockets does
  std::string snapshot = {};              ///< "every:T" or "T,T,..."
  VideoOptions video = {};                ///< whether there is a caption goes for snapshots, too
  bool control = false;                   ///< opens a socket for `cxlab attach`, control.sock in the run's folder
  std::string control_at = {};            ///< opens it there, see `ControlAddress`; empty: as `control` says
  bool begin_stopped = false;             ///< before the first rule fires; opens the socket as well
  std::vector<std::string> command = {};  ///< for the manifest: the arguments of the program
  std::function<void(const std::filesystem::path&)> file_read = {};  ///< called with each file that the run reads
  std::vector<std::filesystem::path> also_read = {};                 ///< what the caller reads when the run is over
  WallMeters meters = {};  ///< of nodes and rules; the result has the time of physics anyway
};

struct Played {
  Scenario scenario;
  Result result;
  std::filesystem::path folder;  ///< empty = none
  std::vector<Picture> pictures;
  std::filesystem::path film;      ///< empty = none
  std::vector<WhatIfAct> changed;  ///< by `RunSpec::what_if`
  /// What ended the run early, or an expectation of the scenario that does not hold (kind kNo); none after a stop.
  std::optional<Error> failure;
  /// All that a person has to see: what could not be loaded, each once and in order, then `failure`.
  std::vector<Error> errors;
};

/// Until the scenario's end, `until` or a stop by the host. An error is one before there was a folder; later ones are
/// in `Played`, as in result.json.
Expected<Played> play_scenario(const PlayOptions& options, Scenario scenario, const Host& host = {});

struct RunAtPlay;

/// The same, which the caller plays step by step. There may be several in a process; each belongs to the thread that
/// plays it.
class Session {
 public:
  /// Reads everything that the scenario names and starts the agents, before tick 0. An error that comes when the run
  /// has its folder is in result.json, too.
  static Expected<std::unique_ptr<Session>> load(const PlayOptions& options, Scenario scenario, const Host& host = {});
  /// A run that was not closed is left as one that was killed.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Plays the ticks up to that time, one at it included; none after the end of the run, a stop by the host or an
  /// error. After each tick `pause`, if there is one, is asked whether the step ends there. In steps a run is byte for
  /// byte the one that `play_scenario` plays.
  Expected<StepReport> step(SimTime until, const std::function<bool()>& pause = {});
  /// A seat that joins between two steps.
  Status join(const Seat& seat);
  /// Whether another step plays none.
  bool over() const;
  Episode& episode();
  /// Deactivates the agents and completes the files. A run that has not come to its end is one with `until` here.
  /// Nothing is called after it.
  Played close();

 private:
  Session();
  std::unique_ptr<RunAtPlay> run_;
};

/// For the handler of a fault: the results of the runs that are being played say that they failed so.
void note_crash(const Error& error);

/// Options of `Episode::load` that every episode has: the spec with the limits of the host, and the data that comes
/// with cxlab.
EpisodeOptions shared_episode_options(const Host& host = {}, RunSpec spec = {});

}  // namespace cxlab::lab
