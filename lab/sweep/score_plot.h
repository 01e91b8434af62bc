#pragma once
// A sweep as a drawing for a page or a paper.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/row.h"

namespace cxlab::lab {

/// An SVG with a line for each strategy and scenario: the figure of each game in grey, and their mean with its 95 %
/// interval in colour. A dashed line shows the mean of the first strategy, or of `against`. An empty metric is the one
/// that the world compares. Scenarios with different metrics are an error.
Expected<std::string> score_plot(const std::vector<Row>& rows, const std::string& metric, const std::string& against,
                                 const Catalogue& catalogue = shipped());

}  // namespace cxlab::lab
