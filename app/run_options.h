#pragma once
// What `cxlab run` and its kin take from the command line.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::app {

struct RunOptions {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::string tier;
  std::vector<std::string> overrides;
  std::optional<double> until;       ///< s
  std::string out;                   ///< empty = runs/<scenario>-<seed>, "none" = nothing is written
  bool force = false;
  std::string journal = "decisions";
  bool realtime = false;
  std::string snapshot;              ///< "every:T" or "T,T,..."
  std::string video;
  bool json = false;
  bool quiet = false;
};

void declare(CLI::App& command, RunOptions& options);
/// The times (s) at which pictures are taken, up to `end`.
Expected<std::vector<double>> snapshot_times(const std::string& text, double end);
/// Plays the episode from beginning to end; gives the exit code.
int run_episode(const RunOptions& options, const std::vector<std::string>& command_line);

}  // namespace cxlab::app
