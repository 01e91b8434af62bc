#pragma once
// What a sweep plays: scenarios x strategies x games x seeds (docs/reference/sweeps.md). A grid of parameters gives a
// strategy for each combination of its values.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"
#include "lab/sweep/requirement.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::lab {

/// What a grid varies, by its name there, and the value that it has.
struct Parameter {
  std::string name, value;

  bool operator==(const Parameter&) const = default;
};

struct Strategy {
  std::string name;
  std::vector<std::string> overrides;      ///< as of `--set`
  std::vector<Origin> origins = {};        ///< of these
  std::vector<Parameter> parameters = {};  ///< in the order of its grid; none: it is not of a grid
  std::vector<std::string> tags = {};      ///< words by which its games are found again
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
  std::filesystem::path game_file{};
  std::vector<Parameter> parameters{};
  std::vector<std::string> tags{};  ///< of the suite, then of the strategy
  std::size_t number = 0;           ///< in the suite, from 1
};

/// The overrides, with the file of the game by its name alone: the same wherever it lies.
std::vector<std::string> portable_overrides(const Cell& cell);
/// "game fast game g1 seed 7".
std::string title_of(const Cell& cell);
/// The command that plays the game of this cell again, for a shell, with the scenario's path from the root.
std::string command_of(const Cell& cell);

/// The text as one word of a shell.
std::string shell_word(const std::string& text);
/// The words of a command that is made of `shell_word`s and blanks.
std::vector<std::string> words_of_shell(const std::string& command);

struct Suite {
  std::filesystem::path file{};          ///< empty: it was made without one
  std::vector<SuiteScenario> scenarios;  ///< these three as in the file; nothing twice
  std::vector<Strategy> strategies;  ///< then those of the grid, in the order of its keys; the last one varies fastest
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteGame> games;  ///< in order of names; none: as the scenarios say
  Origin games_origin{};
  std::vector<std::string> tags{};      ///< of all games
  std::vector<Requirement> require{};   ///< what the rows must show
  std::vector<EarlierSweep> earlier{};  ///< that these name
  std::string tier;                     ///< instead of the scenarios'; empty = theirs
  Origin tier_origin{};
  const Catalogue* catalogue = &shipped();  ///< has the worlds and nodes of the scenarios; outlives the sweep

  static Expected<Suite> load(const std::filesystem::path& file);
  /// How many games each strategy plays in each scenario.
  std::size_t planned_games() const;
  /// How many cells there are.
  std::size_t size() const;
  /// By scenario, strategy, game and seed. Reads the scenarios where the suite has games.
  std::vector<Cell> cells() const { return cells(1, size()); }
  /// The cells with these numbers, both included: a caller that plays a few of a million need not make them all.
  std::vector<Cell> cells(std::size_t first, std::size_t last) const;
  /// Loads every scenario with every strategy, and with every game, and begins games with the rules. So a misspelt
  /// override, a missing file or a syntax error in rules does not cost a night of failed episodes. This process must
  /// have one thread only.
  Status check() const;
  /// Loads what this cell names.
  Status check(const Cell& cell) const;
};

}  // namespace cxlab::lab
