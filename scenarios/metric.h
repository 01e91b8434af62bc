#pragma once
// Figures by which runs are compared. A world declares its metrics (WorldKind::metrics), the first of which is the one
// that `cxlab bench` compares; each is computed from result.json alone, so that any program can compute it again.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

struct Scenario;
struct WorldKind;

struct Metric {
  enum class Fold : std::uint8_t { kSum, kMean };

  std::string_view name;  ///< a column of rows.csv
  std::string_view what;  ///< one line for people
  /// Where the numbers are in result.json; `*` stands for each part of a list or map: "teams.*.points". True is 1.
  std::string_view from;
  Fold fold = Fold::kSum;
  std::string_view per = {};   ///< the path of a number that the result is divided by: "sim_time_s"
  std::string_view unit = {};  ///< "s", "m"; "share" is 0 to 1; empty: a plain number
  bool more_is_better = true;
  bool of_machine = false;  ///< depends on the machine and the hour: kept out of files that are compared byte for byte
  std::string_view title = {};  ///< of its column in the table of `bench`; empty: it is in the rows only
  int digits = 1;               ///< after the point, in that table
  /// The metric whose value this one is a share of, by name: all parts of `points` add up to it. Empty: of none.
  std::string_view part_of = {};
};

/// "sum of teams.*.points", "mean of robots.*.busy_s / sim_time_s".
std::string formula_of(const Metric& metric);
/// The metrics of every run, whatever its world: time, plans.
std::span<const Metric> common_metrics();
/// The metrics of the world, then the common ones.
std::vector<const Metric*> metrics_of(const WorldKind& world);
/// Their values in that order. A metric has none where result.json has nothing at its path, or nothing to average.
std::vector<std::optional<double>> measure(const std::vector<const Metric*>& metrics, const std::string& result_json);
/// The values of one metric, by name: where its path goes through the keys of a map, one for each key, named
/// "KEY.LAST" ("CYAN.points", "CYAN.ring"); else the value as `measure` gives it, by the metric's name.
std::vector<std::pair<std::string, double>> measure_apart(const Metric& metric, const std::string& result_json);
/// The scenario's world declares each metric once, at a path that its result can have; else an error of kind kBug.
Status check_metrics(const Scenario& scenario);

}  // namespace cxlab
