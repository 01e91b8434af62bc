#pragma once
// What all commands share that play a scenario: `lab` plays, a person sees log, progress and errors on stderr.

#include <CLI/CLI.hpp>

#include "lab/session.h"

namespace cxlab::app {

struct PlayCommand {
  lab::PlayOptions play;
  bool json = false, quiet = false;
};

struct Outcome {
  int exit_code = 0;
  lab::Played played;
};
/// Plays, writes the page of the run and prints the errors. `played` is empty if there is nothing to tell of.
Outcome play(const PlayCommand& command, Scenario scenario);

}  // namespace cxlab::app
