#pragma once
// How a scenario is played. Session, episode, environment managers and the manifest of a run (lab/manifest.h) share
// this one struct: the same scenario with the same spec is the same run.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/named_value.h"
#include "cx/base/time.h"
#include "cx/engine/limits.h"
#include "cx/executive/run_settings.h"
#include "cx/journal/journal.h"
#include "scenarios/what_if.h"

namespace cxlab {

/// No run is longer; the end of one that was killed, of which only its log knows how far it came.
inline constexpr SimTime kLongestRun = std::chrono::seconds(1'000'000'000);

struct RunSpec : cx::Conduct {
  std::optional<double> until = {};                 ///< s; none: the duration of the scenario
  JournalLevel journal = JournalLevel::kDecisions;  ///< what journal.jsonl holds
  bool sockets = false;  ///< programs outside reach the network of the episode on the loopback interface; the run is
                         ///< not deterministic then
  std::vector<std::string> prefixes = {};  ///< whose packages are found, before the default ones
  std::vector<WhatIf> what_if = {};        ///< changes in the middle of the run, in order of their time
  Limits limits = {};  ///< of all environments together; a session takes those of its host (lab/host.h)

  /// The one list of keys, as manifest.json has them. `programs` and `limits` protect the machine on which a run is
  /// opened, so the person who opens it gives them again. The run does not name `programs`; it names the limits for
  /// people.
  template <class Keys>
  void fields(Keys& keys) {
    keys.time("until", until);
    keys.required("journal", named(journal, kJournalLevels));
    keys.required("keep_going", keep_going);
    keys.required("strict_cx", strict);
    keys("release", named(release, cx::kRosReleases));
    keys("sockets", sockets);
    keys.required("prefixes", prefixes);
    keys.unless_empty("what_if", what_if);
    keys("memory", limits.memory);
    keys("disk", limits.disk);
    keys("steps", limits.steps);
  }
};

}  // namespace cxlab
