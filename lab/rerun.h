#pragma once
// A recorded run, played again from its manifest into a new folder.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/journal_difference.h"
#include "lab/run.h"
#include "lab/session.h"

namespace cxlab::lab {

/// As in `PlayOptions`.
struct RerunOptions {
  std::string out = {};
  bool force = false;
  std::vector<std::string> command = {};
  bool trust_rules = false;          ///< rules that were trusted then are trusted again, else nothing is played
  bool from_copies = true;           ///< where files are missing; else their absence is an error
  std::optional<double> until = {};  ///< s; instead of the run's own end
  /// The run goes on otherwise from there; its file has not been read yet.
  std::optional<WhatIf> what_if = {};
};

struct Rerun {
  Played played;
  std::vector<std::string> differ;         ///< streams (and "physics") whose hashes differ
  std::vector<std::string> first;          ///< of each stream of them its first difference, as far as it was exported
  std::vector<std::string> changed_files;  ///< that the two runs read with another content, or only one of them

  // With `RerunOptions::what_if`, where `differ` and `first` are empty
  std::optional<Difference> before;   ///< the runs are not the same up to the change
  std::vector<Difference> after;      ///< the first one of each stream, in order of time
  std::vector<ResultChange> results;  ///< of the two runs
};

/// If files of the scenario are missing, it uses the run's own copies of all files, and the host gets a note. Compares
/// nothing if the new run did not come to an end (a stop by the host). The run must have been finished, unless it goes
/// on otherwise.
Expected<Rerun> rerun(const Run& run, const RerunOptions& options = {}, const Host& host = {});

}  // namespace cxlab::lab
