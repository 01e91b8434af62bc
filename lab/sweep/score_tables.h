#pragma once
// Statistics of sweeps as tables; docs/reference/sweep-statistics.md says what each column means.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/row.h"
#include "scenarios/question.h"

namespace cxlab::lab {

/// Tables have the same columns whatever the rows hold. A scenario without the metric has lines without figures in
/// tables of scores, and no lines in tables of differences and shares. It is an error if no scenario has the metric.

/// The table as people read it: a scenario or metric that all lines share is in the title and not in the columns.
Table titled(Table table);
/// A line for each strategy and scenario: mean, median and interquartile mean of a metric with their 95 % intervals,
/// the least and the most. An empty metric is the one that the world compares.
Expected<Table> score_table(const std::vector<Row>& rows, const std::string& metric,
                            const Catalogue& catalogue = shipped());
/// A line for each strategy and scenario. It has mean, interval and least of the metric that the world compares, and
/// the means of its other metrics that have a title. The last column is the difference from the first strategy, or from
/// `against`.
Expected<Table> overview_table(const std::vector<Row>& rows, const std::string& against,
                               const Catalogue& catalogue = shipped());
/// A line for each strategy and scenario: the share of games that reach each of some thresholds of its metric.
Expected<Table> profile_table(const std::vector<Row>& rows, const std::string& metric,
                              const Catalogue& catalogue = shipped());
/// A line for each strategy and scenario: the means of the metrics that are parts of this one (`parts_of`).
Expected<Table> part_table(const std::vector<Row>& rows, const std::string& metric,
                           const Catalogue& catalogue = shipped());

/// The share of the other strategy's figure that each game of this answer reaches. Games in which that one has no
/// figure above 0 are left out.
std::vector<double> shares_of(const Answer& answer);
/// A line for each strategy and scenario: its share of the figure of the first strategy, or of `against`, in the same
/// game (shares_of).
Expected<Table> share_table(const std::vector<Row>& rows, const std::string& against, const std::string& metric,
                            const Catalogue& catalogue = shipped());
/// A line for each answer that is a difference.
Table difference_table(const std::vector<Answer>& answers);
/// A line for each answer to a requirement.
Table requirement_table(const std::vector<Answer>& answers);
/// The metrics that are parts of the one of that name in the worlds of the rows (Metric::part_of), as far as rows have
/// columns of them. It is an error if there are none. With `scenario` only the rows of that one count.
Expected<std::vector<const Metric*>> parts_of(const std::vector<Row>& rows, const std::string& metric,
                                              const Catalogue& catalogue = shipped(),
                                              const std::string* scenario = nullptr);
/// What the tables do not show: games that were not completed, and questions that have too few games for an answer.
/// No sentence comes twice.
std::vector<std::string> remarks_on(const std::vector<Answer>& answers);
/// The worst games of an answer, as places in its `games`; three at most.
std::vector<std::size_t> worst_games(const Answer& answer);

}  // namespace cxlab::lab
