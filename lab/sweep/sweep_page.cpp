#include "lab/sweep/sweep_page.h"

#include <algorithm>
#include <map>
#include <set>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "lab/page.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/plots.h"
#include "lab/sweep/read_rows.h"
#include "lab/sweep/row_folder.h"
#include "lab/sweep/score_tables.h"
#include "lab/table_text.h"
#include "lab/versions.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownGames = 3;  ///< of each strategy, at each end
constexpr const char* kRequirements = "requirements.json";
constexpr std::size_t kMostReasons = 100;  ///< lines of the table of failures and of that of warnings

std::vector<Row> rows_alone(const std::vector<IndexedRow>& rows) {
  std::vector<Row> out;
  out.reserve(rows.size());
  for (const IndexedRow& one : rows) out.push_back(one.row);
  return out;
}

/// A value of a cell by which a column is ordered.
Json order_of(const TableCell& cell) {
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return *whole;
  if (const auto* value = std::get_if<double>(&cell.value)) return *value;
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value)) return stretch->first;
  return "";
}

Json json_of_table(const Table& table) {
  Json columns = Json::array(), rows = Json::array();
  for (const Column& column : table.columns)
    columns.push_back({{"key", column.key}, {"title", column.title}, {"number", column.kind != Column::Kind::kText}});
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (std::size_t i = 0; i < row.size(); ++i)
      cells.push_back({{"text", shown_text(row[i], table.columns[i].kind)}, {"order", order_of(row[i])}});
    rows.push_back(std::move(cells));
  }
  return {{"columns", std::move(columns)}, {"rows", std::move(rows)}};
}

/// The games of one scenario, in the order of the sweep.
struct OfScenario {
  std::string name;
  std::vector<const IndexedRow*> rows;
};

std::vector<OfScenario> by_scenario(const std::vector<IndexedRow>& rows) {
  std::vector<OfScenario> out;
  std::map<std::string, std::size_t> places;
  for (const IndexedRow& one : rows) {
    const auto [place, is_new] = places.try_emplace(one.row.cell.scenario, out.size());
    if (is_new) out.push_back({one.row.cell.scenario, {}});
    out[place->second].rows.push_back(&one);
  }
  return out;
}

/// A game that is shown, and as what.
struct ShownGame {
  const IndexedRow* game;
  double value;
  bool best;
};

/// The worst games of each strategy, then its best ones; no game twice.
std::vector<ShownGame> ends_of(const std::vector<const IndexedRow*>& rows, const MetricOfRows& metric) {
  std::vector<std::pair<std::string, std::vector<ShownGame>>> by_strategy;
  std::map<std::string, std::size_t> places;
  for (const IndexedRow* one : rows) {
    const auto value = one->row.counts() ? one->row.figure(metric.name) : std::nullopt;
    if (!value) continue;
    const auto [place, is_new] = places.try_emplace(one->row.cell.strategy, by_strategy.size());
    if (is_new) by_strategy.push_back({one->row.cell.strategy, {}});
    by_strategy[place->second].second.push_back({one, *value, false});
  }
  std::vector<ShownGame> out;
  for (auto& [strategy, games] : by_strategy) {
    std::ranges::stable_sort(games, {},
                             [&](const ShownGame& game) { return metric.more_is_better ? game.value : -game.value; });
    const std::size_t worst = std::min(kShownGames, games.size()), best = std::min(kShownGames, games.size() - worst);
    out.insert(out.end(), games.begin(), games.begin() + static_cast<std::ptrdiff_t>(worst));
    for (std::size_t i = 0; i < best; ++i) {
      out.push_back(games[games.size() - 1 - i]);
      out.back().best = true;
    }
  }
  return out;
}

std::string game_of(const Cell& cell) {
  return (cell.game.empty() ? "" : cell.game + ", ") + std::string("seed ") + std::to_string(cell.seed);
}

/// The command that plays the game again into its folder of the sweep; empty where the row has none.
std::string command_of_game(const SweepRecord& sweep, const IndexedRow& game) {
  if (game.command.empty()) return {};
  const fs::path folder = fs::absolute(folder_of_game(sweep.path, game)).lexically_normal();
  return game.command + " --out " + shell_word(folder.string());
}

Json json_of_game(const ShownGame& shown, const MetricOfRows& metric, const SweepRecord& sweep,
                  const SweepPageOptions& options) {
  const IndexedRow& one = *shown.game;
  Json out{{"strategy", one.row.cell.strategy},
           {"which", shown.best ? "best" : "worst"},
           {"game", game_of(one.row.cell)},
           {"seed", one.row.cell.seed},
           {"text", fixed_text(shown.value, metric.digits)},
           {"order", shown.value},
           {"command", command_of_game(sweep, one)},
           {"page", ""}};
  if (one.command.empty()) return out;
  const fs::path folder = fs::absolute(folder_of_game(sweep.path, one)).lexically_normal();
  if (is_file(folder / "index.html"))
    out["page"] = (folder / "index.html")
                      .lexically_proximate(fs::absolute(options.file).parent_path().lexically_normal())
                      .generic_string();
  return out;
}

/// A text that games of a strategy have left, with the first of these games.
struct Reason {
  const IndexedRow* first;
  std::string text;
  std::size_t games = 0;
};

/// The most frequent ones first. `texts` are those of a row.
template <class Texts>
std::vector<Reason> reasons_of(const std::vector<IndexedRow>& rows, Texts texts) {
  std::vector<Reason> out;
  std::map<std::tuple<std::string, std::string, std::string>, std::size_t> places;
  for (const IndexedRow& one : rows)
    for (const std::string& text : texts(one.row)) {
      const auto [place, is_new] = places.try_emplace({one.row.cell.scenario, one.row.cell.strategy, text}, out.size());
      if (is_new) out.push_back({&one, text, 0});
      ++out[place->second].games;
    }
  std::ranges::stable_sort(out, std::ranges::greater(), &Reason::games);
  return out;
}

Json json_of_reasons(const std::vector<Reason>& reasons, const SweepRecord& sweep, bool failed) {
  Json out = Json::array();
  for (std::size_t i = 0; i < std::min(kMostReasons, reasons.size()); ++i) {
    const Reason& one = reasons[i];
    out.push_back({{"scenario", one.first->row.cell.scenario},
                   {"strategy", one.first->row.cell.strategy},
                   {"failed", failed},
                   {"status", one.first->row.status},
                   {"exit", one.first->row.exit_code},
                   {"text", one.text},
                   {"games", one.games},
                   {"first", game_of(one.first->row.cell)},
                   {"command", command_of_game(sweep, *one.first)}});
  }
  return out;
}

/// An SVG by the name under which it is saved, and what it shows; nothing where there is none.
void add_plot(Json& plots, const std::string& name, const std::string& title, const Expected<std::string>& svg) {
  if (svg) plots.push_back({{"name", name}, {"title", title}, {"svg", *svg}});
}

std::vector<Answer> answers_in(const std::vector<Answer>& answers, const std::string& scenario) {
  std::vector<Answer> out;
  std::ranges::copy_if(answers, std::back_inserter(out),
                       [&scenario](const Answer& answer) { return answer.scenario == scenario; });
  return out;
}

Json json_of_scenario(const OfScenario& scenario, const std::vector<Answer>& answers, const SweepRecord& sweep,
                      const SweepPageOptions& options, const Catalogue& catalogue) {
  Json out{{"name", scenario.name}, {"metric", ""}, {"parts", Json::array()}, {"games", Json::array()}};
  std::vector<Row> rows;
  for (const IndexedRow* one : scenario.rows) rows.push_back(one->row);
  const bool any = std::ranges::any_of(rows, [](const Row& row) { return row.counts(); });
  const auto metric = metric_of(rows, options.metric, catalogue);
  if (!metric || !any) return out;
  out["metric"] = metric->title;
  const std::string prefix = metric->name + '-';
  const auto add_part = [&out](const std::string& key, const Expected<Table>& table, Json plots) {
    Json one{{"key", key}, {"plots", std::move(plots)}};
    if (table && !table->rows.empty()) one["table"] = json_of_table(titled(*table));
    if (one.contains("table") || !one["plots"].empty()) out["parts"].push_back(std::move(one));
  };
  Json plots = Json::array();
  add_plot(plots, prefix + "scores", "",
           score_plot(rows, options.metric, answers.empty() ? "" : answers.front().asked, catalogue));
  add_part("scores", score_table(rows, options.metric, catalogue), std::move(plots));
  if (!answers.empty()) {
    plots = Json::array();
    add_plot(plots, prefix + "differences", "", difference_plot(answers));
    add_part("differences", difference_table(answers), std::move(plots));
  }
  plots = Json::array();
  add_plot(plots, prefix + "profile", "", profile_plot(rows, options.metric, catalogue));
  add_part("profile", profile_table(rows, options.metric, catalogue), std::move(plots));
  plots = Json::array();
  add_plot(plots, prefix + "parts", "", parts_plot(rows, options.metric, catalogue));
  add_part("parts", part_table(rows, options.metric, catalogue), std::move(plots));
  if (!answers.empty()) {
    plots = Json::array();
    add_plot(plots, prefix + "shares", "", share_plot(answers));
    add_part("shares", share_table(rows, answers.front().asked, options.metric, catalogue), std::move(plots));
  }
  if (options.metric.empty())
    add_part("overview", overview_table(rows, answers.empty() ? "" : answers.front().asked, catalogue), Json::array());
  for (const ShownGame& game : ends_of(scenario.rows, *metric))
    out["games"].push_back(json_of_game(game, *metric, sweep, options));
  return out;
}

Json facts_of(const SweepRecord& sweep) {
  std::size_t completed = 0;
  double cpu_s = 0;
  std::set<std::string> strategies, scenarios, hosts, commits, programs;
  const auto list = [](const std::set<std::string>& all) {
    std::vector<std::string> texts(all.begin(), all.end());
    std::erase(texts, "");
    return some_of(texts, 6);
  };
  for (const auto& [row, command, file] : sweep.rows) {
    completed += row.counts();
    cpu_s += row.circumstances.cpu_s;
    strategies.insert(row.cell.strategy);
    scenarios.insert(row.cell.scenario);
    hosts.insert(row.circumstances.host);
    commits.insert(row.circumstances.agent_commit);
    programs.insert(row.program.substr(0, 12));
  }
  Json out = Json::array();
  const auto fact = [&out](const std::string& what, const std::string& text) {
    if (!text.empty()) out.push_back({{"what", what}, {"text", text}});
  };
  if (auto suite = read_file(sweep.path / kSuiteFile)) {
    suite->erase(suite->find_last_not_of('\n') + 1);
    fact("suite", *suite);
  }
  fact("games", std::to_string(sweep.rows.size()) + ", of which " + std::to_string(completed) + " were completed");
  fact("strategies", std::to_string(strategies.size()));
  fact("scenarios", std::to_string(scenarios.size()) + ": " + list(scenarios));
  if (cpu_s > 0) fact("CPU time", fixed_text(cpu_s, 1) + " s in all");
  fact("machines", list(hosts));
  fact("commit of the agent", list(commits));
  fact("build of cxlab", list(programs));
  return out;
}

}  // namespace

Expected<SweepRecord> read_sweep(const fs::path& path, const Catalogue& catalogue) {
  SweepRecord out{path, {}};
  if (is_folder(path) && is_file(path / "runs.sqlite")) {
    auto rows = read_index(path / "runs.sqlite");
    if (!rows) return rows.error();
    if (rows->empty()) return input_error(found_expected("no row", "at least one"), (path / "runs.sqlite").string());
    out.rows = *std::move(rows);
    return out;
  }
  auto rows = read_rows(path, catalogue);
  if (!rows) return rows.error();
  for (Row& row : *rows) out.rows.push_back({std::move(row), {}, {}});
  return out;
}

Status keep_requirements(const fs::path& folder, const std::vector<Answer>& answers) {
  const fs::path file = folder / kRequirements;
  if (answers.empty()) {
    std::error_code error;
    fs::remove(file, error);
    return error ? Status(resource_error(error.message(), file.string())) : Status();
  }
  const Table table = requirement_table(answers);
  const Json json{
      {"requirements", table_json(table)}, {"remarks", remarks_on(answers)}, {"shown", json_of_table(titled(table))}};
  return replace_file(file, json_text(json, 2) + '\n');
}

fs::path folder_of_game(const fs::path& sweep, const IndexedRow& row) {
  return sweep / "games" / fs::path(row.file).stem();
}

std::vector<const IndexedRow*> shown_games(const SweepRecord& sweep, const std::string& metric,
                                           const Catalogue& catalogue) {
  std::vector<const IndexedRow*> out;
  for (const OfScenario& scenario : by_scenario(sweep.rows)) {
    std::vector<Row> rows;
    for (const IndexedRow* one : scenario.rows) rows.push_back(one->row);
    if (const auto found = metric_of(rows, metric, catalogue))
      for (const ShownGame& shown : ends_of(scenario.rows, *found)) out.push_back(shown.game);
  }
  std::ranges::sort(out, {}, [](const IndexedRow* one) { return one->row.cell.number; });
  return out;
}

Expected<std::string> sweep_page(const SweepRecord& sweep, const SweepRecord* before, const SweepPageOptions& options,
                                 const Catalogue& catalogue) {
  const std::vector<Row> rows = rows_alone(sweep.rows);
  const fs::path whole = fs::absolute(sweep.path).lexically_normal();
  Json data{{"title", (whole.has_filename() ? whole : whole.parent_path()).filename().string()},
            {"facts", facts_of(sweep)},
            {"scenarios", Json::array()},
            {"version", cxlab_version()}};
  const bool any = std::ranges::any_of(rows, [](const Row& row) { return row.counts(); });
  auto answers = Expected<std::vector<Answer>>(std::vector<Answer>());
  if (any) answers = compare_strategies(rows, options.against, options.metric, catalogue);
  if (!answers && (!options.against.empty() || !options.metric.empty())) return answers.error();
  for (const OfScenario& scenario : by_scenario(sweep.rows))
    data["scenarios"].push_back(json_of_scenario(
        scenario, answers ? answers_in(*answers, scenario.name) : std::vector<Answer>(), sweep, options, catalogue));
  data["remarks"] = answers ? remarks_on(*answers) : std::vector<std::string>();
  const auto failures = reasons_of(sweep.rows, [](const Row& row) {
    if (row.counts()) return std::vector<std::string>();
    return row.errors.empty() ? std::vector<std::string>{"no reason is recorded"} : row.errors;
  });
  const auto warnings = reasons_of(sweep.rows, [](const Row& row) { return row.warnings; });
  data["failures"] = json_of_reasons(failures, sweep, true);
  data["warnings"] = json_of_reasons(warnings, sweep, false);
  data["more_failures"] = failures.size() - data["failures"].size();
  data["more_warnings"] = warnings.size() - data["warnings"].size();
  data["requirements"] = nullptr;
  if (is_folder(sweep.path) && is_file(sweep.path / kRequirements)) {
    const auto text = read_file(sweep.path / kRequirements);
    if (!text) return text.error();
    const Json kept = parse_json(*text);
    if (!kept.is_object() || !kept.contains("remarks") || !kept.contains("shown") || !kept["shown"].contains("rows"))
      return input_error("found no table of requirements; cxlab bench writes it",
                         (sweep.path / kRequirements).string());
    data["requirements"] = kept["shown"];
    data["requirements"]["remarks"] = kept["remarks"];
    Json& remarks = data["remarks"];
    for (const Json& said : kept["remarks"]) remarks.erase(std::ranges::remove(remarks, said).begin(), remarks.end());
  }
  data["comparison"] = nullptr;
  if (before) {
    std::vector<std::string> notes;
    const auto compared = compare_sweeps(rows_alone(before->rows), rows, options.metric, notes, catalogue);
    if (!compared) return compared.error();
    for (const std::string& remark : remarks_on(*compared)) notes.push_back(remark);
    const int code = exit_code_of(*compared);
    Json plots = Json::array();
    add_plot(plots, "comparison", "", difference_plot(*compared, before->path.string()));
    data["comparison"] = {{"with", before->path.string()},
                          {"answer", code == 0                ? "better"
                                     : code == kUndecidedExit ? "undecided"
                                                              : "worse"},
                          {"table", json_of_table(titled(difference_table(*compared)))},
                          {"plots", std::move(plots)},
                          {"notes", notes}};
  }
  return render_page("sweep.html", json_text(data));
}

}  // namespace cxlab::lab
