#pragma once
// Drawings of sweeps, as SVG for a page or a paper. Colours are attributes, which every program reads. Each element
// also has a class, by which a page gives it other colours. If a sweep has more games than a drawing can show, the
// drawing has quantiles: its size does not grow with the sweep.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/row.h"

namespace cxlab::lab {

/// A line for each strategy and scenario, with the figure of each game in grey. Above them is their mean with its 95 %
/// interval, in the colour that the strategy has in `profile_plot`. A dashed line shows the mean of the first strategy,
/// or of `against`. An empty metric is the one that the world compares. Scenarios with different metrics are an error.
Expected<std::string> score_plot(const std::vector<Row>& rows, const std::string& metric, const std::string& against,
                                 const Catalogue& catalogue = shipped());
/// A line for each difference: its mean with the 95 % interval, in the colour of its answer; 0 is no difference. All
/// are of one metric, else an error.
Expected<std::string> difference_plot(const std::vector<Answer>& answers, const std::string& against = {});
/// A line for each difference: the share of the other strategy's figure, in per cent, of each game in grey and their
/// mean with its 95 % interval above them. A dashed line is at 100 %. All are of one metric, else an error.
Expected<std::string> share_plot(const std::vector<Answer>& answers);
/// A curve for each strategy and scenario: the share of games (upwards) that reach a figure (to the right).
Expected<std::string> profile_plot(const std::vector<Row>& rows, const std::string& metric,
                                   const Catalogue& catalogue = shipped());
/// A bar for each strategy and scenario: the means of the metrics that are parts of this one (`parts_of`).
Expected<std::string> parts_plot(const std::vector<Row>& rows, const std::string& metric,
                                 const Catalogue& catalogue = shipped());

}  // namespace cxlab::lab
