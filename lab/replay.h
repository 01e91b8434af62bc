#pragma once
// One half of a recorded run again, rules or physics, without the other.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

/// The outcome of one half.
struct ReplayOutcome {
  std::vector<std::string> same, differ;  ///< streams of environments, or "physics"
  std::string first_difference;           ///< empty if there is none
  SimTime end{};                          ///< how far it was replayed
  std::optional<Error> broken;            ///< what is wrong with the log itself, which was replayed up to there
  bool stopped = false;                   ///< by the host; then nothing was compared

  bool agrees() const { return differ.empty() && first_difference.empty() && !broken; }
};

/// The run must have been finished. Reads nothing but its folder.
Expected<ReplayOutcome> replay_rules(const Run& run, const Host& host = {});
/// kInput if the run has no physics.
Expected<ReplayOutcome> replay_physics(const Run& run, const Host& host = {});

/// Where two journals of a stream part, as far as the recorded one was exported: "env/main:12 at 0.500 s: then ..., now
/// ...".
std::string first_difference(const std::string& stream, const std::filesystem::path& recorded,
                             const std::filesystem::path& now);

}  // namespace cxlab::lab
