#pragma once
// The page of a sweep, `index.html` in its folder: one file that loads nothing from elsewhere. It is made from the
// index (index.h), so whoever has the folder can make it.

#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/index.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/row.h"

namespace cxlab::lab {

/// What the page of a sweep is made from.
struct SweepRecord {
  std::filesystem::path path;  ///< as it was named
  std::vector<IndexedRow> rows;
};
/// Reads the record of a folder with an index. For any other folder or file of rows (read_rows) it has no commands.
Expected<SweepRecord> read_sweep(const std::filesystem::path& path, const Catalogue& catalogue = shipped());

struct SweepPageOptions {
  std::string metric{};          ///< empty: the one that the world compares
  std::string against{};         ///< the strategy from which differences are taken; empty: the first of each scenario
  std::filesystem::path file{};  ///< of the page: links are relative to its folder
};

/// Keeps what the requirements of the suite have come to in the folder of the sweep, for its page
/// (`requirements.json`); without answers it takes the file away.
Status keep_requirements(const std::filesystem::path& folder, const std::vector<Answer>& answers);

/// What the requirements of the suite have come to, if it has some; scores, differences, profiles and parts of the
/// metric; the worst and the best games, with the commands that play them again and links to their pages where these
/// are there (`folder_of_game`); failures and warnings; with `before` the same strategies in both sweeps. Fails where
/// --metric or --against name nothing, not where no game was completed.
Expected<std::string> sweep_page(const SweepRecord& sweep, const SweepRecord* before, const SweepPageOptions& options,
                                 const Catalogue& catalogue = shipped());

/// Where the run of a game that is played again lies: SWEEP/games/NAME.
std::filesystem::path folder_of_game(const std::filesystem::path& sweep, const IndexedRow& row);
/// The games that the page shows as the worst and the best of each strategy, each once, in order of cells.
std::vector<const IndexedRow*> shown_games(const SweepRecord& sweep, const std::string& metric,
                                           const Catalogue& catalogue = shipped());

}  // namespace cxlab::lab
