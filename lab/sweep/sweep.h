#pragma once
// Plays the episodes of a suite, each in a process of its own, and keeps their rows in a folder:
//
//   rows/*.json   one an episode; one that is there and current is not played again
//   rows/*.log    what the episode's process printed
//   rows.csv      all of them

#include <filesystem>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/sweep/row.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

struct SweepOptions {
  std::filesystem::path folder;
  int jobs = 1;  ///< episodes at once
};

/// The rows of all cells, in their order; also of episodes that failed or crashed. Fails if another sweep works in the
/// folder; after a stop by the host there are only the rows of the episodes that had ended. The calling process must
/// have one thread only: its copies play.
Expected<std::vector<Row>> sweep(const Suite& suite, const SweepOptions& options, const Host& host = {});

/// A digest of the program and libraries that play.
std::string program_digest();

}  // namespace cxlab::lab
