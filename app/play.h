#pragma once
// Code that all commands that play a scenario share: `lab` plays, and a person sees log, progress and errors on stderr.

#include <CLI/CLI.hpp>

#include "app/console.h"
#include "lab/bag_options.h"
#include "lab/session.h"

namespace cxlab::app {

struct PlayCommand {
  lab::PlayOptions play;
  std::optional<std::uint64_t> seed = {};
  bool json = false, quiet = false, verbose = false;
  bool lives = false;  ///< the log shows the lives of nodes
};
/// Declares the options that all these commands have.
void declare_play(CLI::App& command, PlayCommand& options);

/// The options of a recording that is played.
void declare_bag(CLI::App& command, lab::BagOptions& options);

struct Outcome {
  int exit_code = 0;
  lab::Played played;
};
/// `played` is empty if the run could not begin.
Outcome play(const PlayCommand& command, Scenario scenario);
/// Writes the page of the run and prints its errors, but not again those of files that the log has shown; the exit
/// code.
int conclude(const lab::Played& played, const Console& console);

}  // namespace cxlab::app
