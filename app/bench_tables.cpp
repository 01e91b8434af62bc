// cxlab bench show, bench plot, bench compare: statistics of sweeps that were played before.

#include <cstdio>
#include <memory>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/sweep/read_rows.h"
#include "lab/sweep/score_plot.h"
#include "lab/sweep/score_tables.h"
#include "lab/table_text.h"

namespace cxlab::app {

namespace {

const std::vector<std::string> kFormats{"text", "markdown", "csv", "latex", "json"};
const std::vector<std::string> kTables{"scores", "differences", "profile", "overview"};

struct TableOptions {
  std::string metric, format = "text";
  bool json = false;

  const std::string& written() const { return json ? kFormats.back() : format; }
};

struct ShowOptions : TableOptions {
  std::string sweep, against, table;
};

struct CompareOptions : TableOptions {
  std::string before, now;
};

struct PlotOptions {
  std::string sweep, file, metric, against;
};

std::string written(const Table& table, const std::string& format) {
  if (format == "markdown") return lab::table_markdown(table);
  if (format == "csv") return lab::table_csv(table);
  if (format == "latex") return lab::table_latex(table);
  return lab::table_text(table, line_width());
}

int show(const ShowOptions& options) {
  const std::string& format = options.written();
  if (format == "csv" && options.table.empty())
    return fail(usage_error("--format csv prints one table; expected --table with one of: " +
                            some_of(kTables, kTables.size())));
  const auto rows = lab::read_rows(options.sweep, catalogue());
  if (!rows) return fail(rows.error());
  std::vector<Table> tables;
  for (const std::string& name : kTables) {
    if (options.table.empty() ? name == "overview" : name != options.table) continue;
    auto table = Expected<Table>(Table());
    if (name == "differences") {
      const auto answers = lab::compare_strategies(*rows, options.against, options.metric, catalogue());
      if (!answers) return fail(answers.error());
      if (answers->empty() && options.table.empty()) continue;  // a single strategy
      table = lab::difference_table(*answers);
    } else if (name == "overview") {
      table = lab::overview_table(*rows, options.against, catalogue());
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
  return 0;
}

int compare(const CompareOptions& options) {
  const auto before = lab::read_rows(options.before, catalogue());
  if (!before) return fail(before.error());
  const auto now = lab::read_rows(options.now, catalogue());
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
  return code;
}

int plot(const PlotOptions& options) {
  if (std::filesystem::path(options.file).extension() != ".svg")
    return fail(usage_error(options.file + ": the drawing is an SVG, expected a name that ends in .svg"));
  const auto rows = lab::read_rows(options.sweep, catalogue());
  if (!rows) return fail(rows.error());
  const auto drawing = lab::score_plot(*rows, options.metric, options.against, catalogue());
  if (!drawing) return fail(drawing.error());
  if (Status s = write_file(options.file, *drawing); !s) return fail(s.error());
  std::printf("%s\n", options.file.c_str());
  return 0;
}

void add_table_options(CLI::App& command, TableOptions& options) {
  command.add_option("--metric", options.metric,
                     "Which figure (default: the one that the world compares; cxlab list metrics)");
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
  show_command->add_option("--against", shown->against,
                           "The strategy from which differences are taken (default: the first of each scenario)");
  show_command->add_option("--table", shown->table, "Only this table; overview: several figures side by side")
      ->check(one_of(kTables));
  add_table_options(*show_command, *shown);
  show_command->callback([shown, &action] { action = [shown] { return show(*shown); }; });

  auto plotted = std::make_shared<PlotOptions>();
  CLI::App* plot_command =
      bench.add_subcommand("plot", "Draw the games of a sweep and their means with intervals, as SVG");
  plot_command->footer("Example:\n  cxlab bench plot runs/strategies strategies.svg");
  plot_command->add_option("sweep", plotted->sweep, "Folder of a sweep, or a file like its rows.csv")->required();
  plot_command->add_option("file", plotted->file, "Where (NAME.svg)")->required();
  plot_command->add_option("--metric", plotted->metric,
                           "Which figure (default: the one that the world compares; cxlab list metrics)");
  plot_command->add_option("--against", plotted->against, "The strategy with the dashed line (default: the first)");
  plot_command->callback([plotted, &action] { action = [plotted] { return plot(*plotted); }; });

  auto compared = std::make_shared<CompareOptions>();
  CLI::App* compare_command = bench.add_subcommand(
      "compare", "Compare two sweeps in the same games: better (exit code 0), worse (1) or undecided (6)");
  compare_command->footer("Example:\n  cxlab bench compare runs/before runs/after");
  compare_command->add_option("old", compared->before, "Folder of a sweep, or a file like its rows.csv")->required();
  compare_command->add_option("new", compared->now, "The sweep that is judged")->required();
  add_table_options(*compare_command, *compared);
  compare_command->callback([compared, &action] { action = [compared] { return compare(*compared); }; });
}

}  // namespace cxlab::app
