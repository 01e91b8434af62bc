#pragma once
// Rows of a sweep compared: mean and 95 % interval of each strategy, and the paired difference from the first one.

#include <string>
#include <utility>
#include <vector>

#include "lab/sweep/row.h"

namespace cxlab::lab {

struct Summary {
  std::size_t n = 0;
  double mean = 0;
  double half = 0;  ///< half width of the 95 % interval (Student's t); NaN for fewer than two values
  double min = 0, max = 0;
};
Summary summarize(const std::vector<double>& values);
/// The 97.5 % quantile of Student's t; `freedom` of at least 1.
double t_quantile(std::size_t freedom);

/// One strategy in one scenario; summaries are over the episodes that count.
struct TableLine {
  std::string scenario, strategy;
  std::size_t episodes = 0;
  Summary points, deliveries, busy, real_time_factor;
  Summary against_first;  ///< points minus those of the first strategy with the same game and seed; of others than the
                          ///< first
  std::vector<std::pair<std::string, std::size_t>> errors;  ///< errors and warnings of its episodes, the most frequent
                                                            ///< first, and in how many episodes each is
};
/// In the order in which scenarios and strategies come in the rows.
std::vector<TableLine> table_of(const std::vector<Row>& rows);

/// The lines, and below them the errors and warnings of each.
std::string to_text(const std::vector<TableLine>& table);
std::string to_json(const std::vector<TableLine>& table);

}  // namespace cxlab::lab
