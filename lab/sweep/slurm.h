#pragma once
// A sweep as jobs of Slurm: an array that plays the cells, and a job that collects their rows.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::lab {

struct SlurmOptions {
  std::filesystem::path program;  ///< cxlab, as all nodes find it
  std::filesystem::path suite;    ///< its file, as all nodes find it
  std::filesystem::path folder;   ///< of the sweep, which all nodes share
  std::size_t cells = 0;          ///< of the suite
  std::size_t tasks = 0;          ///< of the array, which share the cells; 0 = one a cell, but no more than Slurm takes
  int jobs = 1;                   ///< processors of a task, and episodes at once
  double time_limit_s = 0;        ///< as of SweepOptions
  std::vector<std::string> more = {};  ///< words of the command that plays cells: "--memory", "4GB"
};

struct SlurmScripts {
  std::filesystem::path cells, collect, submit;
  std::size_t tasks = 0, cells_of_task = 0;  ///< the last one may have fewer
};

/// Writes the scripts into `folder`/slurm. `submit` hands its arguments on to sbatch.
Expected<SlurmScripts> write_slurm(const SlurmOptions& options);

}  // namespace cxlab::lab
