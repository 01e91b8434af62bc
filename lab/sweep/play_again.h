#pragma once
// Games of a sweep that are played again: a sweep keeps rows, not runs.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/sweep/index.h"

namespace cxlab::lab {

/// A game and the folder that its run gets.
struct GameAgain {
  const IndexedRow* game = nullptr;
  std::filesystem::path folder{};
};

/// Plays each by the command of its row with this program, in a process of its own, `jobs` at a time. `ended` is called
/// for each in their order once its run is there; an error of it ends all. Gives a line for each game that goes
/// otherwise now than in the sweep. kInput for a row without a command, kResource for a game that leaves no run.
Expected<std::vector<std::string>> play_again(const std::vector<GameAgain>& games, int jobs, const Host& host,
                                              const std::function<Status(const GameAgain&)>& ended = {});

}  // namespace cxlab::lab
