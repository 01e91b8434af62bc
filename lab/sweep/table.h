#pragma once
// Rows of a sweep compared: mean and 95 % interval of each metric and strategy, and the paired difference from the
// first strategy.

#include <string>
#include <utility>
#include <vector>

#include "lab/sweep/row.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

struct Summary {
  std::size_t n = 0;
  double mean = 0;
  double half = 0;  ///< half width of the 95 % interval (Student's t); NaN for fewer than two values
  double min = 0, max = 0;
};
Summary summarize(const std::vector<double>& values);

/// One strategy in one scenario; summaries are over the episodes that count.
struct TableLine {
  std::string scenario, strategy;
  std::size_t episodes = 0, completed = 0;
  std::size_t planned = 0;           ///< games that the suite plays; 0: not known
  const WorldKind* world = nullptr;  ///< of its episodes; none: they have not come so far
  struct OfMetric {
    const Metric* metric;
    Summary summary;
  };
  std::vector<OfMetric> metrics;  ///< of the world, in their order
  /// The values of the world's first metric minus those of the first strategy with the same game and seed; empty for
  /// the first strategy.
  Summary against_first;
  std::vector<std::pair<std::string, std::size_t>> errors;  ///< errors and warnings of its episodes, the most frequent
                                                            ///< first, and in how many episodes each is
};
/// The lines come in the order of scenarios and strategies in the rows. The catalogue has their worlds.
std::vector<TableLine> table_of(const std::vector<Row>& rows, const Catalogue& catalogue = shipped());

/// The lines, under a header for each world in turn, and below them the errors and warnings of each.
std::string to_text(const std::vector<TableLine>& table);
/// The errors and warnings alone, a line each.
std::string errors_text(const std::vector<TableLine>& table);
std::string to_json(const std::vector<TableLine>& table);

}  // namespace cxlab::lab
