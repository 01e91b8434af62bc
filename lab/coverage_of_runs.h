#pragma once
// Coverage of recorded runs: their rules are played again, to their end. A sweep keeps no runs, so its games are played
// again first.

#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/coverage.h"
#include "lab/host.h"
#include "lab/run.h"
#include "lab/sweep/sweep_page.h"

namespace cxlab::lab {

/// These folders of runs, and all that lie below other folders, in order of their names.
Expected<std::vector<std::filesystem::path>> run_folders(const std::vector<std::string>& paths);

struct RunsCoverage {
  explain::Coverage coverage;
  Sources sources;                 ///< as the runs read them
  Places places;                   ///< where they are now
  std::vector<std::string> notes;  ///< runs that were not played to their end, and why
  std::size_t runs = 0;

  void add(RunsCoverage other);
  /// The counts, with files named where they are now, as stories name them.
  explain::Coverage by_place() const;
};
/// Each run is played in a copy of this process, which must have one thread only.
Expected<RunsCoverage> coverage_of_runs(const std::vector<Run>& runs, int jobs, const Host& host);
/// The same for all games of the sweep that ended. None of their runs stays.
Expected<RunsCoverage> coverage_of_sweep(const SweepRecord& sweep, int jobs, const Host& host);

}  // namespace cxlab::lab
