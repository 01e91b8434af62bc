#pragma once
// Plays one episode from beginning to end, for all commands that do so: folder, log, progress, signals, result.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/episode.h"

namespace cxlab::app {

struct RunOptions {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::string tier;
  std::vector<std::string> overrides;
  std::optional<double> until;  ///< s
  std::string out;              ///< empty = runs/<scenario>-<seed>, "none" = nothing is written
  bool force = false;
  std::string journal = "decisions";
  bool realtime = false;
  std::string snapshot;  ///< "every:T" or "T,T,..."
  std::string video;
  bool json = false;
  bool quiet = false;
  std::vector<std::string> prefixes;  ///< whose packages are found, before the default ones
  bool keep_going = false;            ///< errors in rule files are reported and the run goes on
  bool strict = false;                ///< unknown parameters of the CX are errors
  bool silent = false;                ///< nothing on stdout: the command says itself what came out
};

void declare(CLI::App& command, RunOptions& options);

struct Played {
  int exit_code = 0;
  Result result;
  std::filesystem::path folder;  ///< empty = none
};
/// Until the scenario's end, `until` or a signal. Errors have been printed. The exit code is that of `cxlab run`.
Played play_scenario(const RunOptions& options, Scenario scenario);

/// SIGINT and SIGTERM are remembered from now on, instead of ending the process.
void watch_signals();
/// The number of the signal that came, 0 if none.
int signal_that_came();
/// Options of `load` that every episode has: the data that comes with cxlab.
EpisodeOptions shared_episode_options();

}  // namespace cxlab::app
