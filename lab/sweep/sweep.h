#pragma once
// Plays the episodes of a suite, each in a process of its own, and keeps their rows in a folder (row_folder.h). Any
// machine can play single cells; their rows are collected afterwards.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/sweep/row.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

struct SweepOptions {
  std::filesystem::path folder;
  int jobs = 1;             ///< episodes at once
  double time_limit_s = 0;  ///< of wall time for an episode, which is ended then; 0 = none
};

/// When a sweep may end before all games are played.
struct SweepStages {
  std::vector<std::size_t> games;  ///< of each strategy and scenario; ascending, the last one is all
  /// Asked after each stage with the rows of its games; true: the sweep ends, but for later stages that are there.
  std::function<Expected<bool>(std::size_t games, const std::vector<Row>& rows)> is_answered;
};

/// The rows of all cells, in their order; also of episodes that failed or crashed. Rows that are there and current are
/// kept, others are played; then come the tables. Fails if another sweep works in the folder, or the tables of
/// another suite are in it; after a stop by the host
/// there are only the rows of the episodes that had ended; with `stages` only those of the stages that were played, and
/// current ones of later games. Rows of answers have no `files`. The calling process must have one thread only: its
/// copies play.
Expected<std::vector<Row>> sweep(const Suite& suite, const SweepOptions& options, const Host& host = {},
                                 const SweepStages* stages = nullptr);

/// The same for some cells: the job of one machine. It writes their rows and no tables, and others may play other cells
/// into the same folder.
Expected<std::vector<Row>> play_cells(const Suite& suite, const std::vector<Cell>& cells, const SweepOptions& options,
                                      const Host& host = {});

/// The cells that `sweep` would play in this folder: those without a row that is there and current. Fails if a sweep
/// works in the folder.
Expected<std::vector<Cell>> missing_cells(const Suite& suite, const std::filesystem::path& folder,
                                          const Limits& limits = {});

struct Collected {
  std::vector<Row> rows;             ///< in the order of their cells
  std::vector<std::size_t> missing;  ///< numbers of cells without a row
  std::size_t taken = 0;             ///< rows that came from elsewhere
  // Files that are no rows of this suite
  std::size_t of_other_programs = 0, outdated = 0, broken = 0;
  /// Cells of which two rows of the same game differ.
  std::vector<std::size_t> contradictory;
  std::pair<std::filesystem::path, std::filesystem::path> differ{};  ///< the two files of the first such cell
};

/// Takes the rows that count for the suite from these folders of sweeps into `folder`, and writes the tables. Each cell
/// counts once; a row of a game that crashed counts where there is no other one.
Expected<Collected> collect(const Suite& suite, const std::vector<std::filesystem::path>& from,
                            const std::filesystem::path& folder, const Host& host = {});

/// A digest of the program and libraries that play.
std::string program_digest();

}  // namespace cxlab::lab
