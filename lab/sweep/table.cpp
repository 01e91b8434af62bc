#include "lab/sweep/table.h"
#include "cx/base/json_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace cxlab::lab {

namespace {

using Json = nlohmann::ordered_json;

std::string text(const Summary& s, const char* mean_format, const char* half_format) {
  if (s.n == 0) return "-";
  char mean[32], half[32];
  std::snprintf(mean, sizeof mean, mean_format, s.mean);
  std::snprintf(half, sizeof half, half_format, s.half);
  return std::isnan(s.half) ? mean : std::string(mean) + " +- " + half;
}

std::string extreme(const Summary& s, double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%g", value);
  return s.n == 0 ? "-" : out;
}

Json summary_json(const Summary& s) {
  const auto of_any = [&s](double value) { return s.n == 0 ? Json() : Json(value); };
  return {{"n", s.n},
          {"mean", of_any(s.mean)},
          {"interval_95", std::isnan(s.half) ? Json() : Json(s.half)},
          {"min", of_any(s.min)},
          {"max", of_any(s.max)}};
}

void add_errors(const Row& row, TableLine& line) {
  for (const std::string& text : std::set<std::string>(row.errors.begin(), row.errors.end())) {
    const auto known = std::ranges::find(line.errors, text, [](const auto& error) { return error.first; });
    if (known == line.errors.end())
      line.errors.emplace_back(text, 1);
    else
      ++known->second;
  }
}

/// Errors and warnings, a line each.
std::string errors_text(const TableLine& line) {
  constexpr std::size_t kMost = 5;
  std::string out;
  for (std::size_t i = 0; i < std::min(kMost, line.errors.size()); ++i)
    out += line.scenario + ", " + line.strategy + ", " + std::to_string(line.errors[i].second) + " of " +
           std::to_string(line.episodes) + " episodes: " + line.errors[i].first + '\n';
  if (line.errors.size() > kMost)
    out += line.scenario + ", " + line.strategy + ": " + std::to_string(line.errors.size() - kMost) +
           " more, in rows/*.json\n";
  return out;
}

/// Column `figure` of the rows.
Summary summary_of(const std::vector<const Row*>& rows, double Figures::* figure) {
  std::vector<double> values;
  for (const Row* row : rows) values.push_back(row->figures.*figure);
  return summarize(values);
}

}  // namespace

double t_quantile(std::size_t freedom) {
  static constexpr double kTable[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                      2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                                      2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
  const double f = static_cast<double>(freedom);
  return freedom <= 30 ? kTable[freedom - 1] : 1.95996 + 2.3723 / f + 2.8225 / (f * f);  // Cornish and Fisher, 1937
}

Summary summarize(const std::vector<double>& values) {
  Summary s;
  s.n = values.size();
  s.half = std::numeric_limits<double>::quiet_NaN();
  if (values.empty()) return s;
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  s.min = *min;
  s.max = *max;
  const double n = static_cast<double>(s.n);
  for (const double v : values) s.mean += v / n;
  double squares = 0;
  for (const double v : values) squares += (v - s.mean) * (v - s.mean);
  if (s.n > 1) s.half = t_quantile(s.n - 1) * std::sqrt(squares / (n - 1) / n);
  return s;
}

std::vector<TableLine> table_of(const std::vector<Row>& rows) {
  std::vector<TableLine> out;
  std::vector<std::vector<const Row*>> counted;            // by line
  using Played = std::pair<std::string, std::uint64_t>;    // game and seed
  std::map<std::string, std::map<Played, double>> firsts;  // by scenario: points of its first strategy
  std::vector<std::vector<double>> differences;
  for (const Row& row : rows) {
    const auto same = [&](const TableLine& l) {
      return l.scenario == row.cell.scenario && l.strategy == row.cell.strategy;
    };
    auto line = std::find_if(out.begin(), out.end(), same);
    const bool first =
        std::none_of(out.begin(), line, [&](const TableLine& l) { return l.scenario == row.cell.scenario; });
    if (line == out.end()) {
      line = out.insert(out.end(), TableLine{row.cell.scenario, row.cell.strategy, 0, {}, {}, {}, {}, {}, {}});
      counted.emplace_back();
      differences.emplace_back();
    }
    const auto at = static_cast<std::size_t>(line - out.begin());
    ++line->episodes;
    add_errors(row, *line);
    if (!row.counts()) continue;
    counted[at].push_back(&row);
    auto& points = firsts[row.cell.scenario];
    const Played played{row.cell.game, row.cell.seed};
    if (first)
      points[played] = row.figures.points;
    else if (const auto other = points.find(played); other != points.end())
      differences[at].push_back(row.figures.points - other->second);
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].points = summary_of(counted[i], &Figures::points);
    out[i].deliveries = summary_of(counted[i], &Figures::deliveries);
    out[i].busy = summary_of(counted[i], &Figures::busy);
    out[i].real_time_factor = summary_of(counted[i], &Figures::real_time_factor);
    out[i].against_first = summarize(differences[i]);
    std::ranges::stable_sort(out[i].errors, std::ranges::greater(), [](const auto& error) { return error.second; });
  }
  return out;
}

std::string to_text(const std::vector<TableLine>& table) {
  char line[512];
  std::snprintf(line, sizeof line, "%-20s %-20s %7s  %-18s %6s %6s  %-14s %-14s %-14s %s\n", "scenario", "strategy",
                "done", "points", "min", "max", "deliveries", "busy", "real time", "points against the first strategy");
  std::string out = line;
  for (const TableLine& l : table) {
    std::snprintf(line, sizeof line, "%-20s %-20s %3zu/%-3zu  %-18s %6s %6s  %-14s %-14s %-14s %s\n",
                  l.scenario.c_str(), l.strategy.c_str(), l.points.n, l.episodes,
                  text(l.points, "%.1f", "%.1f").c_str(), extreme(l.points, l.points.min).c_str(),
                  extreme(l.points, l.points.max).c_str(), text(l.deliveries, "%.1f", "%.1f").c_str(),
                  text(l.busy, "%.3f", "%.3f").c_str(), text(l.real_time_factor, "%.0f", "%.0f").c_str(),
                  text(l.against_first, "%+.1f", "%.1f").c_str());
    out += line;
  }
  std::string errors;
  for (const TableLine& l : table) errors += errors_text(l);
  return errors.empty() ? out : out + "\nerrors and warnings:\n" + errors + '\n';
}

std::string to_json(const std::vector<TableLine>& table) {
  Json out = Json::array();
  for (const TableLine& l : table) {
    Json errors = Json::array();
    for (const auto& [text, episodes] : l.errors) errors.push_back({{"text", text}, {"episodes", episodes}});
    out.push_back({{"scenario", l.scenario},
                   {"strategy", l.strategy},
                   {"episodes", l.episodes},
                   {"points", summary_json(l.points)},
                   {"deliveries", summary_json(l.deliveries)},
                   {"busy", summary_json(l.busy)},
                   {"real_time_factor", summary_json(l.real_time_factor)},
                   {"points_against_first", summary_json(l.against_first)},
                   {"errors", std::move(errors)}});
  }
  return json_text(out, 2) + '\n';
}

}  // namespace cxlab::lab
