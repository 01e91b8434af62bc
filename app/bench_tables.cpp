// cxlab bench show, bench plot, bench page, bench compare: statistics of sweeps that were played before.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/run_folder.h"
#include "lab/sweep/play_again.h"
#include "lab/sweep/plots.h"
#include "lab/sweep/read_rows.h"
#include "lab/sweep/score_tables.h"
#include "lab/sweep/sweep_page.h"
#include "lab/sweep/table.h"
#include "lab/table_text.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFormats{"text", "markdown", "csv", "latex", "json"};
const std::vector<std::string> kTables{"scores", "differences", "profile", "overview", "parts", "shares"};

struct TableOptions {
  std::string metric, format = "text";
  bool json = false;

  const std::string& written() const { return json ? kFormats.back() : format; }
};

struct ShowOptions : TableOptions {
  std::string sweep, against, scenario, table;
};

struct CompareOptions : TableOptions {
  std::string before, now, scenario;
};

const std::vector<std::string> kPlots{"scores", "differences", "profile", "parts", "shares"};

struct PlotOptions {
  std::string sweep, file, metric, against, scenario, kind = "scores";
};

struct PageOptions {
  std::string sweep, before, out, metric, against;
  bool play = false;
  int jobs = 1;
};

std::string written(const Table& table, const std::string& format) {
  if (format == "csv") return lab::table_csv(table);
  const Table shown = lab::titled(table);
  if (format == "markdown") return lab::table_markdown(shown);
  if (format == "latex") return lab::table_latex(shown);
  return lab::table_text(shown, line_width());
}

/// The rows of a sweep; with a scenario only those of that one.
Expected<std::vector<lab::Row>> rows_of(const std::string& sweep, const std::string& scenario) {
  auto rows = lab::read_rows(sweep, catalogue());
  return rows ? lab::rows_of_scenario(*std::move(rows), scenario) : rows;
}

/// Names the errors and warnings of games, which no table shows. rows.csv has no texts of them, the index has.
void print_errors(const std::string& sweep, std::vector<lab::Row> rows, const std::string& scenario = {}) {
  if (const fs::path index = fs::path(sweep) / "runs.sqlite"; is_file(index))
    if (auto read = lab::read_index(index)) {
      rows.clear();
      for (lab::IndexedRow& one : *read)
        if (scenario.empty() || one.row.cell.scenario == scenario) rows.push_back(std::move(one.row));
    }
  std::fputs(printable(lab::errors_text(lab::table_of(rows, catalogue()))).c_str(), stderr);
}

int show(const ShowOptions& options) {
  const std::string& format = options.written();
  if (format == "csv" && options.table.empty())
    return fail(usage_error("--format csv prints one table; expected --table with one of: " + some_of(kTables)));
  const auto rows = rows_of(options.sweep, options.scenario);
  if (!rows) return fail(rows.error());
  if (Status s = lab::check_strategy(*rows, options.against); !s) return fail(s.error());
  std::vector<Table> tables;
  for (const std::string& name : kTables) {
    if (options.table.empty() ? name != "scores" && name != "differences" && name != "profile" : name != options.table)
      continue;
    auto table = Expected<Table>(Table());
    if (name == "differences") {
      const auto answers = lab::compare_strategies(*rows, options.against, options.metric, catalogue());
      if (!answers) return fail(answers.error());
      if (answers->empty() && options.table.empty()) continue;  // a single strategy
      table = lab::difference_table(*answers);
    } else if (name == "overview") {
      table = lab::overview_table(*rows, options.against, catalogue());
    } else if (name == "parts") {
      table = lab::part_table(*rows, options.metric, catalogue());
      if (!table && options.table.empty()) continue;  // a metric without parts
    } else if (name == "shares") {
      table = lab::share_table(*rows, options.against, options.metric, catalogue());
    } else {
      table = name == "scores" ? lab::score_table(*rows, options.metric, catalogue())
                               : lab::profile_table(*rows, options.metric, catalogue());
    }
    if (!table) return fail(table.error());
    tables.push_back(*std::move(table));
  }
  if (format == "json") {
    Json json = Json::object();
    for (const Table& table : tables) json[table.key] = lab::table_json(table);
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  for (std::size_t i = 0; i < tables.size(); ++i)
    std::printf("%s%s", i ? "\n" : "", written(tables[i], format).c_str());
  print_errors(options.sweep, *rows, options.scenario);
  return 0;
}

int compare(const CompareOptions& options) {
  const auto before = rows_of(options.before, options.scenario);
  if (!before) return fail(before.error());
  const auto now = rows_of(options.now, options.scenario);
  if (!now) return fail(now.error());
  std::vector<std::string> notes;
  const auto answers = lab::compare_sweeps(*before, *now, options.metric, notes, catalogue());
  if (!answers) return fail(answers.error());
  for (const std::string& remark : lab::remarks_on(*answers)) notes.push_back(remark);
  const Table table = lab::difference_table(*answers);
  const int code = lab::exit_code_of(*answers);
  const char* const word = code == 0 ? "better" : code == lab::kUndecidedExit ? "undecided" : "worse";
  const std::string& format = options.written();
  if (format == "json") {
    const Json json{{"answer", word}, {"differences", lab::table_json(table)}, {"notes", notes}};
    std::printf("%s\n", json_text(json, 2).c_str());
    return code;
  }
  std::printf("%s", written(table, format).c_str());
  std::FILE* const out = format == "text" ? stdout : stderr;  // the others are files for other programs
  for (const std::string& note : notes) std::fprintf(out, "%s\n", printable(note).c_str());
  std::fprintf(out, "answer: %s\n", word);
  if (std::ranges::any_of(*answers, [](const lab::Answer& answer) { return answer.lost > 0; })) {
    print_errors(options.now, *now, options.scenario);
    if (is_file(fs::path(options.now) / "runs.sqlite"))  // it has the commands
      std::fprintf(stderr, "cxlab bench page %s shows these games with the commands that play them again\n",
                   printable(options.now).c_str());
  }
  return code;
}

Expected<std::string> drawn(const std::vector<lab::Row>& rows, const PlotOptions& options) {
  if (Status s = lab::check_strategy(rows, options.against); !s) return s.error();
  if (options.kind == "profile") return lab::profile_plot(rows, options.metric, catalogue());
  if (options.kind == "parts") return lab::parts_plot(rows, options.metric, catalogue());
  if (options.kind == "scores") return lab::score_plot(rows, options.metric, options.against, catalogue());
  const auto answers = lab::compare_strategies(rows, options.against, options.metric, catalogue());
  if (!answers) return answers.error();
  return options.kind == "shares" ? lab::share_plot(*answers) : lab::difference_plot(*answers);
}

int plot(const PlotOptions& options) {
  if (std::filesystem::path(options.file).extension() != ".svg")
    return fail(usage_error(options.file + ": the drawing is an SVG, expected a name that ends in .svg"));
  const auto rows = rows_of(options.sweep, options.scenario);
  if (!rows) return fail(rows.error());
  const auto drawing = drawn(*rows, options);
  if (!drawing) return fail(drawing.error());
  if (Status s = write_output(options.file, *drawing); !s) return fail(s.error());
  std::printf("%s\n", options.file.c_str());
  return 0;
}

/// Plays the games again that the page shows, into SWEEP/games, unless they are there.
Status play_shown_games(const lab::SweepRecord& sweep, const PageOptions& options) {
  std::vector<lab::GameAgain> missing;
  for (const lab::IndexedRow* game : lab::shown_games(sweep, options.metric, catalogue()))
    if (const fs::path folder = lab::folder_of_game(sweep.path, *game); !is_file(folder / "index.html"))
      missing.push_back({game, folder});
  Console console(true);
  const auto remarks = lab::play_again(missing, options.jobs, console.host());
  if (!remarks) return remarks.error();
  console.clear();
  for (const std::string& remark : *remarks) std::fprintf(stderr, "%s\n", printable(remark).c_str());
  return {};
}

int page(const PageOptions& options) {
  const auto sweep = lab::read_sweep(options.sweep, catalogue());
  if (!sweep) return fail(sweep.error());
  const bool folder = is_folder(options.sweep);
  if (!folder && options.out.empty())
    return fail(usage_error(options.sweep + " is not the folder of a sweep; expected --out FILE.html with it"));
  const fs::path file = options.out.empty() ? fs::path(options.sweep) / "index.html" : fs::path(options.out);
  std::optional<lab::SweepRecord> before;
  if (!options.before.empty()) {
    auto read = lab::read_sweep(options.before, catalogue());
    if (!read) return fail(read.error());
    before = *std::move(read);
  }
  const auto draw = [&] {
    return lab::sweep_page(*sweep, before ? &*before : nullptr,
                           {.metric = options.metric, .against = options.against, .file = file}, catalogue());
  };
  auto text = draw();
  if (text && options.play) {  // what is wrong with the options costs no game
    if (Status s = play_shown_games(*sweep, options); !s) return fail(s.error());
    text = draw();
  }
  if (!text) return fail(text.error());
  if (Status s = make_folder_of(file); !s) return fail(s.error());
  if (Status s = replace_file(file, *text); !s) return fail(s.error());
  std::printf("%s\n", file.c_str());
  return 0;
}

void add_scenario_option(CLI::App& command, std::string& scenario) {
  command.add_option("--scenario", scenario, "Only the games of this scenario")->type_name("NAME");
}

void add_table_options(CLI::App& command, TableOptions& options) {
  command.add_option("--metric", options.metric,
                     "The metric (default: the first one of the world; cxlab list metrics)");
  CLI::Option* format =
      command.add_option("--format", options.format, "How the tables are written")->check(one_of(kFormats));
  command.add_flag("--json", options.json, "Prints JSON, as --format json")->excludes(format);
}

}  // namespace

void add_bench_tables(CLI::App& bench, Action& action) {
  auto shown = std::make_shared<ShowOptions>();
  CLI::App* show_command = bench.add_subcommand(
      "show", "Print scores of a sweep with intervals, differences from a strategy, and how many games reach a figure");
  show_command->footer(
      "Examples:\n  cxlab bench show runs/bench-rcll\n"
      "  cxlab bench show runs/strategies --against greedy --table differences --format latex");
  show_command->add_option("sweep", shown->sweep, "Folder of a sweep, or a file like its rows.csv")->required();
  show_command->add_option(
      "--against", shown->against,
      "Differences are from this strategy, and shares of its points (default: the first of each scenario)");
  show_command
      ->add_option("--table", shown->table,
                   "Only this table; overview: several figures side by side; parts: points by kind; shares: of the "
                   "figure of --against in the same game")
      ->check(one_of(kTables));
  add_scenario_option(*show_command, shown->scenario);
  add_table_options(*show_command, *shown);
  show_command->callback([shown, &action] { action = [shown] { return show(*shown); }; });

  auto plotted = std::make_shared<PlotOptions>();
  CLI::App* plot_command = bench.add_subcommand(
      "plot", "Draw scores, differences, profiles, parts or shares of a figure of a sweep, as SVG");
  plot_command->footer(
      "Examples:\n  cxlab bench plot runs/strategies strategies.svg\n"
      "  cxlab bench plot runs/strategies late.svg --kind differences --metric late_s");
  plot_command->add_option("sweep", plotted->sweep, "Folder of a sweep, or a file like its rows.csv")->required();
  plot_command->add_option("file", plotted->file, "The file (NAME.svg)")->required();
  plot_command->add_option("--metric", plotted->metric,
                           "The metric (default: the first one of the world; cxlab list metrics)");
  plot_command->add_option("--against", plotted->against,
                           "Differences are from this strategy, which has the dashed line (default: the first)");
  plot_command
      ->add_option("--kind", plotted->kind,
                   "The plot (default scores: games and means with intervals); parts: points by kind; shares: of the "
                   "figure of --against in the same game")
      ->check(one_of(kPlots));
  add_scenario_option(*plot_command, plotted->scenario);
  plot_command->callback([plotted, &action] { action = [plotted] { return plot(*plotted); }; });

  auto paged = std::make_shared<PageOptions>();
  CLI::App* page_command = bench.add_subcommand(
      "page", "Write the page of a sweep: all tables and plots, worst and best games, failures, in one file");
  page_command->footer(
      "Examples:\n  cxlab bench page runs/bench-rcll\n"
      "  cxlab bench page runs/after runs/before --play -j 2");
  page_command->add_option("sweep", paged->sweep, "Folder of a sweep, or a file like its rows.csv")->required();
  page_command->add_option("old", paged->before, "An earlier sweep, to compare the same games");
  page_command->add_option("--out", paged->out, "The file (default SWEEP/index.html)")->type_name("FILE");
  page_command->add_option("--metric", paged->metric,
                           "The metric (default: the first one of the world; cxlab list metrics)");
  page_command->add_option("--against", paged->against,
                           "Differences are from this strategy (default: the first of each scenario)");
  CLI::Option* play_games = page_command->add_flag(
      "--play", paged->play, "Plays the shown games again, into SWEEP/games, and links to their pages");
  whole_number(page_command->add_option("-j,--jobs", paged->jobs, "Games at once"), 1, 256)->needs(play_games);
  page_command->callback([paged, &action] { action = [paged] { return page(*paged); }; });

  auto compared = std::make_shared<CompareOptions>();
  CLI::App* compare_command = bench.add_subcommand(
      "compare", "Compare two sweeps in the same games: better (exit code 0), worse (1) or undecided (6)");
  compare_command->footer("Example:\n  cxlab bench compare runs/before runs/after");
  compare_command->add_option("old", compared->before, "Folder of a sweep, or a file like its rows.csv")->required();
  compare_command->add_option("new", compared->now, "The sweep that is judged")->required();
  add_scenario_option(*compare_command, compared->scenario);
  add_table_options(*compare_command, *compared);
  compare_command->callback([compared, &action] { action = [compared] { return compare(*compared); }; });
}

}  // namespace cxlab::app
