#pragma once
// Small linear programs: a dense tableau in two phases with Bland's rule, so that it always ends (Chvatal 1983).

#include <cstdint>
#include <optional>
#include <vector>

namespace cxlab::planner {

/// sum of coefficients[i] * x[i] <= bound
struct LinearRow {
  std::vector<double> coefficients;
  double bound = 0;
};

/// Values x >= 0 that keep all rows and make the sum of objective[i] * x[i] least, or some that keep the rows where
/// that has no bound; none if no values keep them all.
/// Adds the cells that were looked at to `work`.
std::optional<std::vector<double>> minimize(const std::vector<LinearRow>& rows, const std::vector<double>& objective,
                                            std::int64_t* work = nullptr);

}  // namespace cxlab::planner
