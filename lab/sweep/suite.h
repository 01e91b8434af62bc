#pragma once
// What a sweep plays: scenarios x strategies x games x seeds (docs/bench.md).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::lab {

struct Strategy {
  std::string name;
  std::vector<std::string> overrides;  ///< as of `--set`
  std::vector<Origin> origins = {};    ///< of these
};

struct SuiteScenario {
  std::string name;  ///< the file's name without extension, after as many of its folders as make it the only one
  std::filesystem::path file;
  Origin origin{};
  std::string named{};  ///< as the suite names it
};

/// A file that says what chance would decide otherwise (WorldKind::games_key).
struct SuiteGame {
  std::string name;  ///< the file's name without extension
  std::filesystem::path file;
};

/// One episode of a suite.
struct Cell {
  std::string scenario, strategy;
  std::uint64_t seed = 0;
  std::filesystem::path file;
  std::vector<std::string> overrides;  ///< all: of the strategy, then tier, game and seed
  std::string game{};                  ///< by name; empty = as the scenario says
  std::string game_override{};         ///< the one of the overrides that names the file of the game
  std::string named{};                 ///< the scenario as the suite names it
};

struct Suite {
  std::vector<SuiteScenario> scenarios;  ///< these three as in the file; nothing twice
  std::vector<Strategy> strategies;
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteGame> games;  ///< in order of names; none: as the scenarios say
  Origin games_origin{};
  std::string tier;                         ///< instead of the scenarios'; empty = theirs
  const Catalogue* catalogue = &shipped();  ///< has the worlds and nodes of the scenarios; outlives the sweep

  static Expected<Suite> load(const std::filesystem::path& file);
  /// By scenario, strategy, game and seed. Reads the scenarios where the suite has games.
  std::vector<Cell> cells() const;
  /// Loads every scenario with every strategy, and with every game, so that a misspelt override or a missing file does
  /// not cost a night of failed episodes.
  Status check() const;
};

}  // namespace cxlab::lab
