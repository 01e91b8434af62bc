#include "lab/sweep/read_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "lab/sweep/row_folder.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

struct CsvLine {
  int line = 0;
  std::vector<std::string> fields;
};

/// RFC 4180, with any ends of lines.
Expected<std::vector<CsvLine>> lines_of_csv(const std::string& text, const std::string& from) {
  std::vector<CsvLine> out;
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    CsvLine& one = out.emplace_back(CsvLine{line, {}});
    for (bool more = true; more;) {
      std::string& field = one.fields.emplace_back();
      if (i < text.size() && text[i] == '"') {
        for (++i;; ++i) {
          if (i >= text.size()) return input_error("a quote without its end", from, one.line);
          if (text[i] == '"') {
            if (i + 1 >= text.size() || text[i + 1] != '"') break;
            ++i;
          }
          if (text[i] == '\n') ++line;
          field += text[i];
        }
        ++i;
        if (i < text.size() && text[i] != ',' && text[i] != '\r' && text[i] != '\n')
          return input_error(found_expected("text after the end of a quote", "a comma"), from, line);
      } else {
        while (i < text.size() && text[i] != ',' && text[i] != '\r' && text[i] != '\n') field += text[i++];
      }
      more = i < text.size() && text[i] == ',';
      if (more) ++i;
    }
    if (i < text.size() && text[i] == '\r') ++i;
    if (i < text.size() && text[i] == '\n') ++i;
    ++line;
    if (one.fields.size() == 1 && one.fields.front().empty()) out.pop_back();  // an empty line
  }
  return out;
}

/// Which of these columns are figures of a sweep that was not made by hand: all between `exit` and `journal_hash`.
bool is_about_the_episode(const std::string& column) {
  static const std::set<std::string> kNot{"scenario", "strategy", "game", "seed", "status", "exit", "journal_hash"};
  return kNot.contains(column);
}

/// The world that declares all metrics of which these rows have values; nullptr if there is none.
const WorldKind* world_of(const std::vector<const Row*>& rows, const Catalogue& catalogue) {
  std::set<std::string> with_value;
  for (const Row* row : rows)
    for (const Figure& figure : row->figures)
      if (figure.value) with_value.emplace(figure.metric);
  for (const WorldKind* world : catalogue.worlds) {
    if (world->metrics.empty() || !with_value.contains(std::string(world->metrics.front().name))) continue;
    return world;
  }
  return nullptr;
}

}  // namespace

Expected<std::vector<Row>> rows_of_csv(const std::string& text, const std::string& from, const Catalogue& catalogue) {
  auto lines = lines_of_csv(text, from);
  if (!lines) return lines.error();
  if (lines->empty()) return input_error(found_expected("an empty file", "the rows of a sweep"), from);
  const std::vector<std::string> columns = lines->front().fields;
  const auto column = [&columns](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
  };
  for (const char* needed : {"scenario", "strategy", "seed"})
    if (column(needed) == columns.size())
      return input_error(found_expected("the columns " + some_of(columns, 8),
                                        std::string("'") + needed + "' among them, as in rows.csv of cxlab bench"),
                         from, lines->front().line);
  std::vector<Row> out;
  for (auto line = lines->begin() + 1; line != lines->end(); ++line) {
    if (line->fields.size() != columns.size())
      return input_error(found_expected(std::to_string(line->fields.size()) + " fields",
                                        std::to_string(columns.size()) + ", as in the first line"),
                         from, line->line);
    const auto field = [&](std::string_view name, const char* otherwise) {
      const std::size_t at = column(name);
      return at < columns.size() ? line->fields[at] : std::string(otherwise);
    };
    const auto not_number = [&](const std::string& name, const std::string& what) {
      return input_error(found_expected("'" + field(name, "") + "' as " + name, what), from, line->line);
    };
    Row& row = out.emplace_back();
    row.cell.scenario = field("scenario", "");
    row.cell.strategy = field("strategy", "");
    row.cell.game = field("game", "");
    row.status = field("status", "completed");
    row.journal_hash = field("journal_hash", "");
    const auto seed = read_number<std::uint64_t>(field("seed", ""));
    const auto exit = read_number<int>(field("exit", "0"));
    if (!seed) return not_number("seed", "a whole number from 0");
    if (!exit) return not_number("exit", "a whole number");
    row.cell.seed = *seed;
    row.exit_code = *exit;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (is_about_the_episode(columns[i])) continue;
      const auto value = read_number<double>(line->fields[i]);
      if (line->fields[i].empty() ? false : !value || !std::isfinite(*value))
        return not_number(columns[i], "a number, or nothing where there is none");
      row.figures.push_back({shared_name(columns[i]), value});
    }
  }
  std::map<std::string, std::vector<const Row*>> by_scenario;
  for (const Row& row : out) by_scenario[row.cell.scenario].push_back(&row);
  std::map<std::string, const WorldKind*> worlds;
  for (const auto& [scenario, rows] : by_scenario) worlds[scenario] = world_of(rows, catalogue);
  for (Row& row : out) {
    const WorldKind* world = worlds.at(row.cell.scenario);
    if (!world) continue;
    row.world = world->name;
    row.compared = world->metrics.front().name;
  }
  return out;
}

namespace {

Expected<std::vector<Row>> rows_of_folder(const fs::path& folder) {
  const std::vector<fs::path> files = row_files(folder);
  if (files.empty())
    return input_error(
        found_expected("no rows.csv and no rows/*.json", "the folder of a sweep, as cxlab bench writes it"),
        folder.string());
  std::vector<Row> out;
  for (const fs::path& file : files) {
    const auto text = read_file(file);
    if (!text) return text.error();
    auto row = Row::parse(*text);
    if (!row) return input_error(row.error().message, file.string());
    out.push_back(*std::move(row));
  }
  std::ranges::stable_sort(out, {}, [](const Row& row) { return row.cell.seed; });
  return out;
}

/// The same episode twice would count as two samples.
Status check_rows(const std::vector<Row>& rows, const std::string& from) {
  std::set<std::tuple<std::string, std::string, std::string, std::uint64_t>> known;
  for (const Row& row : rows)
    if (const Cell& cell = row.cell; !known.insert({cell.scenario, cell.strategy, cell.game, cell.seed}).second)
      return input_error(
          found_expected("two rows of " + cell.scenario + ", " + cell.strategy +
                             (cell.game.empty() ? "" : ", game " + cell.game) + ", seed " + std::to_string(cell.seed),
                         "one: the same game is no second sample"),
          from);
  return rows.empty() ? Status(input_error(found_expected("no row", "at least one"), from)) : Status();
}

}  // namespace

Expected<std::vector<Row>> read_rows(const fs::path& sweep, const Catalogue& catalogue) {
  if (!path_exists(sweep))
    return input_error("there is no such sweep; expected a folder of cxlab bench", sweep.string());
  const fs::path csv = is_folder(sweep) ? sweep / "rows.csv" : sweep;
  if (!path_exists(csv)) {
    auto rows = rows_of_folder(sweep);
    if (!rows) return rows;
    if (Status s = check_rows(*rows, sweep.string()); !s) return s.error();
    return rows;
  }
  const auto text = read_file(csv);
  if (!text) return text.error();
  auto rows = rows_of_csv(*text, csv.string(), catalogue);
  if (!rows) return rows;
  if (Status s = check_rows(*rows, csv.string()); !s) return s.error();
  return rows;
}

std::string metrics_text(const std::string& missing, const MetricNames& names) {
  const auto has_those_of_the_first = [&](const auto& one) { return one.second == names.front().second; };
  if (std::ranges::all_of(names, has_those_of_the_first))
    return names.empty() ? "there is none" : "there are " + some_of_and_nearest(missing, names.front().second);
  std::string out;
  std::vector<std::string> all;
  for (const auto& [scenario, of_scenario] : names) {
    out += (out.empty() ? "" : "; ") + scenario + " has " + some_of(of_scenario);
    all.insert(all.end(), of_scenario.begin(), of_scenario.end());
  }
  return out + did_you_mean(missing, all, "; ");
}

namespace {

Error nothing_to_compare(const std::vector<Row>& rows) {
  const bool none_counts = std::ranges::none_of(rows, &Row::counts);
  return input_error("no row has a figure that could be compared" +
                     std::string(rows.empty() || !none_counts
                                     ? ""
                                     : ": no game was completed; the column reason of runs.sqlite has the reasons, and "
                                       "the page of the sweep (cxlab bench page SWEEP)"));
}

}  // namespace

Expected<MetricOfRows> metric_of(const std::vector<Row>& rows, const std::string& name, const Catalogue& catalogue,
                                 const std::string* scenario) {
  MetricNames names;                 // that have a value
  std::string wanted = name, first;  // the first that is not of the machine
  for (const Row& row : rows) {
    if (scenario && row.cell.scenario != *scenario) continue;
    if (wanted.empty()) wanted = row.compared;
    for (const Figure& figure : row.figures) {
      if (!figure.value) continue;
      auto of_scenario = std::ranges::find(names, row.cell.scenario, &MetricNames::value_type::first);
      if (of_scenario == names.end()) of_scenario = names.insert(names.end(), {row.cell.scenario, {}});
      if (std::ranges::find(of_scenario->second, figure.metric) == of_scenario->second.end())
        of_scenario->second.emplace_back(figure.metric);
      if (first.empty() && !figure.of_machine) first = figure.metric;
    }
  }
  if (wanted.empty()) wanted = first;
  if (names.empty()) return nothing_to_compare(rows);
  if (std::ranges::none_of(names, [&](const auto& one) { return std::ranges::count(one.second, wanted) > 0; }))
    return input_error("no row has a metric '" + wanted + "'; " + metrics_text(wanted, names));
  MetricOfRows out{wanted, wanted};
  for (const Row& row : rows)
    if (const WorldKind* world = catalogue.find_world(row.world))
      for (const Metric* metric : metrics_of(*world))
        if (metric->name == wanted) {
          if (!metric->title.empty()) out.title = metric->title;
          out.more_is_better = metric->more_is_better;
          out.digits = metric->digits;
          return out;
        }
  return out;
}

Expected<std::map<std::string, MetricOfRows>> metrics_of_scenarios(const std::vector<Row>& rows,
                                                                   const std::string& name,
                                                                   const Catalogue& catalogue) {
  if (const auto any = metric_of(rows, name, catalogue); !any && !name.empty()) return any.error();
  std::map<std::string, MetricOfRows> out;
  std::set<std::string> scenarios;
  for (const Row& row : rows)
    if (scenarios.insert(row.cell.scenario).second)
      if (const auto found = metric_of(rows, name, catalogue, &row.cell.scenario)) out[row.cell.scenario] = *found;
  if (out.empty()) return nothing_to_compare(rows);
  return out;
}

Expected<std::vector<Row>> rows_of_scenario(std::vector<Row> rows, const std::string& name) {
  if (name.empty()) return rows;
  std::vector<std::string> names;
  for (const Row& row : rows)
    if (std::ranges::find(names, row.cell.scenario) == names.end()) names.push_back(row.cell.scenario);
  std::erase_if(rows, [&name](const Row& row) { return row.cell.scenario != name; });
  if (rows.empty())
    return input_error("there is no scenario '" + name + "'; there are " + some_of_and_nearest(name, names, 8));
  return rows;
}

}  // namespace cxlab::lab
