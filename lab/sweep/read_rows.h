#pragma once
// Rows of a sweep that was played before, for comparisons.

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/row.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

/// The episodes of a sweep, in its order: those of the folder's rows.csv, those of its rows/*.json if it has no
/// rows.csv, or those of a file like rows.csv. From a CSV, rows have the world whose metrics its columns are.
Expected<std::vector<Row>> read_rows(const std::filesystem::path& sweep, const Catalogue& catalogue = shipped());
/// The same from the text of a CSV; `from` is the file for errors.
Expected<std::vector<Row>> rows_of_csv(const std::string& text, const std::string& from,
                                       const Catalogue& catalogue = shipped());

/// How a metric of rows is printed; one that no world declares is a number of which more is better.
struct MetricOfRows {
  std::string name, title;
  bool more_is_better = true;
  int digits = 1;
};
/// Names of metrics by scenario.
using MetricNames = std::vector<std::pair<std::string, std::vector<std::string>>>;
/// Which metrics there are, for a message about one that is missing: "there are points and skills", or "game has
/// points; figures has walls" if scenarios have others.
std::string metrics_text(const std::string& missing, const MetricNames& names);
/// The metric of that name in these rows; with an empty name the one that their world compares. Fails if no row has a
/// value of it. With `scenario` only the rows of that one count.
Expected<MetricOfRows> metric_of(const std::vector<Row>& rows, const std::string& name,
                                 const Catalogue& catalogue = shipped(), const std::string* scenario = nullptr);
/// The same of each scenario that has it. Fails if none has.
Expected<std::map<std::string, MetricOfRows>> metrics_of_scenarios(const std::vector<Row>& rows,
                                                                   const std::string& name,
                                                                   const Catalogue& catalogue = shipped());
/// The rows of that scenario; with an empty name all. Fails if no row is of it.
Expected<std::vector<Row>> rows_of_scenario(std::vector<Row> rows, const std::string& name);

}  // namespace cxlab::lab
