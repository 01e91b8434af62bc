#include "lab/sweep/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/statistics/distributions.h"
#include "lab/statistics/statistics.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

namespace {

/// "12.5 +- 3.1"; with the sign of the mean where it is a difference.
std::string text(const Summary& s, int digits, bool difference = false) {
  if (s.n == 0) return "-";
  const std::string mean = (difference && s.mean >= 0 ? "+" : "") + fixed_text(s.mean, digits);
  return std::isnan(s.half) ? mean : mean + " +- " + fixed_text(s.half, digits);
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
          {"interval_95", std::isnan(s.half) ? Json() : Json{s.mean - s.half, s.mean + s.half}},
          {"min", of_any(s.min)},
          {"max", of_any(s.max)}};
}

void add_errors(const Row& row, TableLine& line) {
  std::set<std::string> texts(row.errors.begin(), row.errors.end());
  texts.insert(row.warnings.begin(), row.warnings.end());
  for (const std::string& text : texts) {
    const auto known = std::ranges::find(line.errors, text, [](const auto& error) { return error.first; });
    if (known == line.errors.end())
      line.errors.emplace_back(text, 1);
    else
      ++known->second;
  }
}

/// Errors and warnings, a line each.
std::string errors_of_line(const TableLine& line) {
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

/// Summarises the rows that have a value of the metric.
Summary summary_of(const std::vector<const Row*>& rows, std::string_view metric) {
  std::vector<double> values;
  for (const Row* row : rows)
    if (const auto value = row->figure(metric)) values.push_back(*value);
  return summarize(values);
}

}  // namespace

Summary summarize(const std::vector<double>& values) {
  Summary s;
  s.n = values.size();
  s.half = std::numeric_limits<double>::quiet_NaN();
  if (values.empty()) return s;
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  s.min = *min;
  s.max = *max;
  s.mean = statistics::mean(values);
  s.half = statistics::student_half_95(values);
  return s;
}

std::vector<TableLine> table_of(const std::vector<Row>& rows, const Catalogue& catalogue) {
  struct Counted {
    std::vector<const Row*> rows;
    std::vector<double> differences;
  };
  std::vector<TableLine> out;
  std::vector<Counted> counted;                          // by line
  using Played = std::pair<std::string, std::uint64_t>;  // game and seed
  using Compared = std::pair<std::string, std::string>;  // scenario and metric
  std::map<Compared, std::map<Played, double>> firsts;   // of the first strategy
  for (const Row& row : rows) {
    const auto same = [&](const TableLine& l) {
      return l.scenario == row.cell.scenario && l.strategy == row.cell.strategy;
    };
    auto line = std::find_if(out.begin(), out.end(), same);
    const bool first =
        std::none_of(out.begin(), line, [&](const TableLine& l) { return l.scenario == row.cell.scenario; });
    if (line == out.end()) {
      line = out.insert(out.end(), TableLine());
      line->scenario = row.cell.scenario;
      line->strategy = row.cell.strategy;
      counted.emplace_back();
    }
    Counted& of_line = counted[static_cast<std::size_t>(line - out.begin())];
    ++line->episodes;
    if (!line->world) line->world = catalogue.find_world(row.world);
    add_errors(row, *line);
    if (!row.counts()) continue;
    of_line.rows.push_back(&row);
    const std::optional<double> value = row.figure(row.compared);
    if (!value) continue;
    auto& of_first = firsts[{row.cell.scenario, row.compared}];
    const Played played{row.cell.game, row.cell.seed};
    if (first)
      of_first[played] = *value;
    else if (const auto other = of_first.find(played); other != of_first.end())
      of_line.differences.push_back(*value - other->second);
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].completed = counted[i].rows.size();
    if (out[i].world)
      for (const Metric* metric : metrics_of(*out[i].world))
        out[i].metrics.push_back({metric, summary_of(counted[i].rows, metric->name)});
    out[i].against_first = summarize(counted[i].differences);
    std::ranges::stable_sort(out[i].errors, std::ranges::greater(), [](const auto& error) { return error.second; });
  }
  return out;
}

namespace {

/// The metric that is compared in a world; nullptr if it declares none.
const Metric* compared_in(const WorldKind* world) {
  return world && !world->metrics.empty() ? &world->metrics.front() : nullptr;
}

std::string cell(const std::string& text, std::size_t width) {
  return text.size() >= width ? text + ' ' : text + std::string(width + 1 - text.size(), ' ');
}

std::size_t width_of(const Metric& metric) { return std::max<std::size_t>(14, metric.title.size()); }

/// Columns of the names.
struct Widths {
  std::size_t scenario = 20, strategy = 20;
};

std::string header_of(const TableLine& line, const Widths& widths) {
  const Metric* compared = compared_in(line.world);
  std::string out = cell("scenario", widths.scenario) + cell("strategy", widths.strategy) + cell("   done", 8);
  if (compared) out += cell(std::string(compared->title), 18) + "   min    max  ";
  for (const auto& [metric, summary] : line.metrics)
    if (metric != compared && !metric->title.empty()) out += cell(std::string(metric->title), width_of(*metric));
  if (compared)
    out += std::string(compared->title) + " against the first strategy" +
           (compared->more_is_better ? "" : " (less is better)");
  return out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
}

std::string text_of(const TableLine& line, const Widths& widths) {
  const Metric* compared = compared_in(line.world);
  char done[32];
  std::snprintf(done, sizeof done, "%3zu/%-3zu ", line.completed, std::max(line.planned, line.episodes));
  std::string out = cell(line.scenario, widths.scenario) + cell(line.strategy, widths.strategy) + cell(done, 8);
  for (const auto& [metric, s] : line.metrics) {
    if (metric == compared) {
      char extremes[64];
      std::snprintf(extremes, sizeof extremes, "%6s %6s  ", extreme(s, s.min).c_str(), extreme(s, s.max).c_str());
      out += cell(text(s, metric->digits), 18) + extremes;
    } else if (!metric->title.empty()) {
      out += cell(text(s, metric->digits), width_of(*metric));
    }
  }
  if (compared) out += text(line.against_first, compared->digits, true);
  return out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
}

}  // namespace

std::string errors_text(const std::vector<TableLine>& table) {
  std::string out;
  for (const TableLine& line : table) out += errors_of_line(line);
  return out;
}

std::string to_text(const std::vector<TableLine>& table) {
  std::string out, header;
  Widths widths;
  for (const TableLine& line : table) {
    widths.scenario = std::max(widths.scenario, line.scenario.size());
    widths.strategy = std::max(widths.strategy, line.strategy.size());
  }
  for (const TableLine& line : table) {
    if (std::string own = header_of(line, widths); own != header && (line.world || header.empty())) {
      if (!header.empty()) out += '\n';
      out += header = std::move(own);
    }
    out += text_of(line, widths);
  }
  const std::string errors = errors_text(table);
  return errors.empty() ? out : out + "\nerrors and warnings:\n" + errors + '\n';
}

std::string to_json(const std::vector<TableLine>& table) {
  Json out = Json::array();
  for (const TableLine& l : table) {
    Json line{{"scenario", l.scenario}, {"strategy", l.strategy}, {"episodes", l.episodes}, {"completed", l.completed}};
    for (const auto& [metric, summary] : l.metrics) line[std::string(metric->name)] = summary_json(summary);
    if (const Metric* compared = compared_in(l.world)) {
      line["compared"] = compared->name;
      line["more_is_better"] = compared->more_is_better;
      line[std::string(compared->name) + "_against_first"] = summary_json(l.against_first);
    }
    line["errors"] = Json::array();
    for (const auto& [text, episodes] : l.errors) line["errors"].push_back({{"text", text}, {"episodes", episodes}});
    out.push_back(std::move(line));
  }
  return json_text(out, 2) + '\n';
}

}  // namespace cxlab::lab
