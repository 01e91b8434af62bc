#pragma once
// Comparisons of rows, answered better, worse or undecided: those of a suite's requirements, of two sweeps, and of the
// strategies of one (docs/reference/sweep-statistics.md).

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/read_rows.h"
#include "lab/sweep/requirement.h"
#include "lab/sweep/row.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

enum class Judgement { kUndecided, kBetter, kWorse };
std::string_view to_string(Judgement judgement);

/// A question about one strategy in one scenario, with its answer.
struct Answer {
  std::string scenario, strategy;
  std::string asked;  ///< the requirement, or the strategy and sweep that it is compared with
  MetricOfRows metric;
  bool is_difference = false;
  std::vector<double> values;  ///< the figures, or the differences in pairs, in the order of play
  std::vector<std::pair<std::string, std::uint64_t>> games;  ///< of the values: name and seed
  double bound = 0;                                          ///< `values` are compared with this
  std::vector<double> first, second;                         ///< of a difference: the figures of the pairs
  std::size_t lost = 0;    ///< games that the strategy did not complete, though what it is compared with did: one is
                           ///< enough for kWorse
  std::size_t gained = 0;  ///< of a difference: games that only the strategy completed
  Judgement judgement = Judgement::kUndecided;
  bool of_folder = false;  ///< its games are files of a folder
  std::size_t after = 0;   ///< games
  double p = 1;            ///< corrected for the other questions
};

/// The exit code of these answers: 1 if one is worse, else 6 if one is undecided, else 0.
int exit_code_of(const std::vector<Answer>& answers);
inline constexpr int kUndecidedExit = 6;

/// Asks the requirements of a suite of its rows.
class Judge {
 public:
  /// Reads the suite's earlier sweeps. Fails if one of its requirements names what there is not.
  static Expected<Judge> make(const Suite& suite);

  /// `look_after` are numbers of games (games x seeds) of which the last one is that of the whole suite. The rows are
  /// those of the first games of the suite, in its order. Fails if they lack a metric.
  Expected<std::vector<Answer>> judge(const std::vector<Row>& rows, const std::vector<std::size_t>& look_after) const;

 private:
  std::vector<Requirement> requirements_;
  std::vector<std::pair<std::string, std::vector<Row>>> earlier_;
  const Catalogue* catalogue_ = nullptr;
};

/// Each strategy of `now` against the one of the same name in `before`, in the same scenario and games; where both
/// sweeps have a single strategy in a scenario, these, whatever their names.
/// An empty metric is the one that the world compares. `notes` gets what is in one of them only, and the scenarios
/// without the metric. Fails if nothing is in both.
Expected<std::vector<Answer>> compare_sweeps(const std::vector<Row>& before, const std::vector<Row>& now,
                                             const std::string& metric, std::vector<std::string>& notes,
                                             const Catalogue& catalogue = shipped());
/// An error unless rows have a strategy of this name; an empty one stands for any.
Status check_strategy(const std::vector<Row>& rows, const std::string& name);
/// The strategies of one sweep against one of them; with an empty name against the first one of each scenario. A
/// scenario without the metric has no answers; it is an error if no scenario has it.
Expected<std::vector<Answer>> compare_strategies(const std::vector<Row>& rows, const std::string& against,
                                                 const std::string& metric, const Catalogue& catalogue = shipped());

}  // namespace cxlab::lab
