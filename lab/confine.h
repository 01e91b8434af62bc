#pragma once
// The wall around an episode (cx/wall/wall.h), raised where the host wants one.

#include <optional>
#include <string>

#include "lab/host.h"
#include "scenarios/episode.h"

namespace cxlab::lab {

/// To be called when all is open that the rules do not need, before `Episode::start`. `more` is what else this process
/// reads and writes afterwards. Where the kernel has no wall, the host gets a note, once.
void confine(const Episode& episode, const Host& host, const Wall& more = {});

/// The same around what only reads files, and plays nothing.
void confine(const Host& host, const Wall& wall);

/// What a person is told where the kernel cannot confine processes that play rules.
std::optional<std::string> warning_without_wall();

}  // namespace cxlab::lab
