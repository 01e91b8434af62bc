#pragma once
// Decides, game by game, whether figures lie above or below 0, and stops asking once that is certain.
//
// A group-sequential test with the boundaries of Haybittle (1971) and Peto (1976) for N planned games. After each tenth
// of them it looks whether p <= 0.001, and after the last one whether p <= 0.04. Together, the ten looks are wrong with
// a probability of at most 9 * 0.001 + 0.04 < 5 %, because the probability of a union is at most the sum. This holds
// however the looks depend on each other. Several questions at once are corrected by Holm at each look, so the 5 % are
// those of all answers together.
//
// It assumes that N is fixed before the first look, and games are independent of each other. For differences in pairs
// it assumes that both signs are equally likely if nothing differs (sign_flip_p). The test is then exact for any
// distribution. For a mean against a number that is not 0 by symmetry, as that of differences against a margin, no test
// holds for all distributions (Bahadur and Savage, 1956). Hall's is near its level for figures that are skewed like an
// exponential distribution or less (mean_p; docs/reference/sweep-statistics.md has measurements). A loss that comes in
// one of ten games is missing in 28 % of twelve games and in 4 % of thirty. So no early look finds a mean above 0 in
// fewer than thirty games, or above or below it where all values are the same.

#include <cstddef>
#include <optional>
#include <vector>

#include "lab/statistics/statistics.h"

namespace cxlab::statistics {

inline constexpr double kEarlyLevel = 0.001, kLastLevel = 0.04;
inline constexpr std::size_t kEarlyLooks = 9;
inline constexpr std::size_t kFewestForEarlyMean = 30;  ///< above 0

/// After how many of the planned games the test looks, the last look included; `together` games are played as one.
/// There is no early look after less than eleven games, because 2 / 2^11 is the first p below 0.001.
std::vector<std::size_t> looks(std::size_t planned, std::size_t together = 1);

struct Question {
  /// kDifferences: pairs against 0; kMean: a figure against a number, or pairs against a margin.
  enum class About { kDifferences, kMean };
  About about = About::kDifferences;
  /// By game, in the order of playing, as far as there are any; less what they are compared with. None: the game has
  /// no figure.
  std::vector<std::optional<double>> values;
};

/// With fewer games than that the last look cannot decide such a question, asked as one of so many.
std::size_t fewest_games(Question::About about, std::size_t questions);

enum class Side { kUndecided, kAbove, kBelow };

struct Decision {
  Side side = Side::kUndecided;
  std::size_t after = 0;  ///< games; of an undecided one those of the last look
  double p = 1;           ///< at that look, corrected for the other questions
};

/// The decision of each question. `look_after` are the looks, the last one after all planned games. A look comes when
/// each question has its values up to there.
std::vector<Decision> decide(const std::vector<Question>& questions, const std::vector<std::size_t>& look_after,
                             const Resampling& flips = {.resamples = 99999});

}  // namespace cxlab::statistics
