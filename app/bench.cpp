// cxlab bench: scenarios x strategies x seeds, each episode in a process of its own. Its commands for rows that are
// there are in bench_tables.cpp.

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "cx/yaml/seeds.h"
#include "lab/sweep/judged_sweep.h"
#include "lab/sweep/score_tables.h"
#include "lab/sweep/slurm.h"
#include "lab/sweep/sweep.h"
#include "lab/sweep/sweep_page.h"
#include "lab/sweep/table.h"
#include "lab/table_text.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  std::string suite, out, cell, seeds;
  std::vector<std::string> collect;
  std::vector<std::string> limits;  // of rules: options with their values
  int jobs = 1;
  double time_limit_s = 0;
  std::int64_t tasks = 0;  // of Slurm; 0: as many as there are cells
  bool json = false, quiet = false, verbose = false, cells = false, missing = false, slurm = false, all = false;

  fs::path folder() const {
    return out.empty() ? fs::path("runs") / ("bench-" + fs::path(suite).stem().string()) : fs::path(out);
  }
};

bool all_count(const std::vector<lab::Row>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const lab::Row& row) { return row.counts(); });
}

/// Writes the page of the sweep. The table is the answer, so a page that cannot be made is only reported.
void write_page(const BenchOptions& options, const lab::Host& host, const std::vector<lab::Answer>& requirements = {}) {
  if (Status s = lab::keep_requirements(options.folder(), requirements); !s) host.warn(s.error().text());
  const fs::path file = options.folder() / "index.html";
  const auto sweep = lab::read_sweep(options.folder(), catalogue());
  const auto page = sweep ? lab::sweep_page(*sweep, nullptr, {.file = file}, catalogue()) : sweep.error();
  const Status written = page ? replace_file(file, *page) : page.error();
  if (!written) host.warn("no page is written: " + written.error().text());
}

/// What requirement does not hold, the games that show it most, and the command that plays one of them again: the worst
/// one, or the first that was not completed.
void print_worst_games(const lab::JudgedRows& judged) {
  for (const lab::Answer& answer : judged.answers) {
    if (answer.judgement != lab::Judgement::kWorse) continue;
    const auto named = [](const std::string& name, std::uint64_t seed) {
      return (name.empty() ? "" : name + " ") + "seed " + std::to_string(seed);
    };
    std::string games;
    for (const std::size_t i : lab::worst_games(answer)) {
      const auto& [name, seed] = answer.games[i];
      games += (games.empty() ? "the worst games: " : ", ") + named(name, seed) + " (" +
               fixed_text(answer.values[i], answer.metric.digits) + ')';
    }
    const auto shown = std::ranges::find_if(judged.rows, [&](const lab::Row& row) {
      if (row.cell.scenario != answer.scenario || row.cell.strategy != answer.strategy) return false;
      if (answer.lost > 0) return !row.counts();
      return std::pair(row.cell.game, row.cell.seed) == answer.games[lab::worst_games(answer).front()];
    });
    if (shown == judged.rows.end()) continue;
    if (answer.lost > 0) games = named(shown->cell.game, shown->cell.seed) + " was not completed";
    std::printf("%s, %s: '%s' does not hold; %s\n  %s\n", printable(answer.scenario).c_str(),
                printable(answer.strategy).c_str(), printable(answer.asked).c_str(), printable(games).c_str(),
                shown->command().c_str());
  }
}

/// The table, and where `judged` is given what the requirements of the suite have come to. Returns the exit code.
int print_table(const lab::Suite& suite, const std::vector<lab::Row>& rows, const BenchOptions& options,
                const lab::JudgedRows* judged = nullptr) {
  std::vector<lab::TableLine> table = lab::table_of(rows, catalogue());
  for (lab::TableLine& line : table) line.planned = suite.planned_games();
  const std::string csv = (options.folder() / "rows.csv").string();
  const int code = all_count(rows) ? 0 : static_cast<int>(ErrorKind::kNo);
  if (!judged) {
    if (options.json)
      std::fputs(lab::to_json(table).c_str(), stdout);
    else
      std::printf("%s%s\n", lab::to_text(table).c_str(), csv.c_str());
    return code;
  }
  const Table answers = lab::requirement_table(judged->answers);
  const std::vector<std::string> remarks = lab::remarks_on(judged->answers);
  if (options.json) {
    const Json json{{"strategies", parse_json(lab::to_json(table))},
                    {"requirements", lab::table_json(answers)},
                    {"remarks", remarks},
                    {"games", judged->games},
                    {"planned", judged->planned}};
    std::printf("%s\n", json_text(json, 2).c_str());
  } else {
    std::printf("%s%s\n\n%s", lab::to_text(table).c_str(), csv.c_str(),
                lab::table_text(lab::titled(answers), line_width()).c_str());
    for (const std::string& remark : remarks) std::printf("%s\n", remark.c_str());
    print_worst_games(*judged);
    if (judged->games < judged->planned)
      std::printf("Answered after %zu of %zu games; --all plays the others, too.\n", judged->games, judged->planned);
  }
  return code != 0 ? code : lab::exit_code_of(judged->answers);
}

/// What a suite consists of, a line each: the number that `--cell` takes, and what is played.
int list_cells(const lab::Suite& suite, const BenchOptions& options, const Limits& limits) {
  constexpr std::size_t kAtOnce = 1000;  // a suite may have a million
  Json list = Json::array();
  const lab::Allowance allowance(limits);
  const auto add = [&list, &options, &allowance](const lab::Cell& cell) {
    if (!options.json) {
      std::string title = lab::title_of(cell);
      std::ranges::replace(title, '\n', ' ');
      std::printf("%zu\t%s\n", cell.number, title.c_str());
      return;
    }
    Json parameters = Json::object();
    for (const lab::Parameter& parameter : cell.parameters) parameters[parameter.name] = parameter.value;
    list.push_back({{"cell", cell.number},
                    {"scenario", cell.scenario},
                    {"strategy", cell.strategy},
                    {"game", cell.game},
                    {"seed", cell.seed},
                    {"parameters", std::move(parameters)},
                    {"tags", cell.tags},
                    {"row", "rows/" + lab::row_name(cell) + ".json"},
                    {"command", lab::command_of(cell) + allowance.options()}});
  };
  if (options.missing) {
    const auto cells = lab::missing_cells(suite, options.folder(), limits);
    if (!cells) return fail(cells.error());
    for (const lab::Cell& cell : *cells) add(cell);
  } else {
    for (std::size_t first = 1; first <= suite.size(); first += kAtOnce)
      for (const lab::Cell& cell : suite.cells(first, std::min(first + kAtOnce - 1, suite.size()))) add(cell);
  }
  if (options.json) std::printf("%s\n", json_text(list, 2).c_str());
  return 0;
}

/// The cells of "17" or "17..20".
Expected<std::vector<lab::Cell>> chosen_cells(const lab::Suite& suite, const std::string& text) {
  const std::size_t dots = text.find("..");
  const auto first = read_number<std::size_t>(text.substr(0, dots));
  const auto last = dots == text.npos ? first : read_number<std::size_t>(text.substr(dots + 2));
  if (!first || !last || *first < 1 || *last < *first || *last > suite.size())
    return usage_error("--cell: " +
                       found_text(text, "the number of a cell, 1 to " + std::to_string(suite.size()) +
                                            ", or a range of them, as 1.." + std::to_string(suite.size())));
  return suite.cells(*first, *last);
}

std::string finished_text(std::size_t rows, std::size_t cells) {
  return std::to_string(rows) + " of " + lab::count_text(cells, "episode") + (rows == 1 ? " is" : " are") +
         " finished and kept; the same command plays the others";
}

int play_cells(const lab::Suite& suite, const BenchOptions& options, const lab::Host& host) {
  const auto cells = chosen_cells(suite, options.cell);
  if (!cells) return fail(cells.error());
  const auto rows = lab::play_cells(suite, *cells, {options.folder(), options.jobs, options.time_limit_s}, host);
  if (!rows) return fail(rows.error());
  Json list = Json::array();
  for (const lab::Row& row : *rows) {
    const std::string file = (options.folder() / "rows" / (lab::row_name(row.cell) + ".json")).string();
    if (options.json)
      list.push_back({{"cell", row.cell.number},
                      {"status", row.status},
                      {"exit", row.exit_code},
                      {"row", file},
                      {"key", row.key}});
    else
      std::printf("%s\n", file.c_str());
  }
  if (options.json) std::printf("%s\n", json_text(list, 2).c_str());
  if (const int code = interrupted(finished_text(rows->size(), cells->size()))) return code;
  return all_count(*rows) ? 0 : static_cast<int>(ErrorKind::kNo);
}

/// "3, 5..8, 12", with no more than a few of them.
std::string ranges_text(const std::vector<std::size_t>& numbers) {
  constexpr std::size_t kMost = 8;
  std::string out;
  std::size_t ranges = 0;
  for (std::size_t i = 0; i < numbers.size(); ++ranges) {
    std::size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (ranges == kMost) return out + ", ...";
    out += (out.empty() ? "" : ", ") + std::to_string(numbers[i]);
    if (end > i + 1) out += ".." + std::to_string(numbers[end - 1]);
    i = end;
  }
  return out;
}

std::string cells_text(const std::vector<std::size_t>& numbers) {
  return (numbers.size() == 1 ? "cell " : "cells ") + ranges_text(numbers);
}

int collect_rows(const lab::Suite& suite, const BenchOptions& options, const lab::Host& host) {
  const auto found = lab::collect(suite, {options.collect.begin(), options.collect.end()}, options.folder(), host);
  if (!found) return fail(found.error());
  if (const int code = interrupted("nothing is collected")) return code;
  const std::size_t cells = found->rows.size() + found->missing.size();
  host.note(std::to_string(found->rows.size()) + " of " + lab::count_text(cells, "cell") +
            (found->rows.size() == 1 ? " has" : " have") + " a row; " + lab::count_text(found->taken, "row") +
            (found->taken == 1 ? " was" : " were") + " taken");
  // Also with --quiet: no table shows which rows do not count.
  const auto left_out = [](std::size_t n, const std::string& what, const std::string& is, const std::string& are) {
    if (n > 0) std::fprintf(stderr, "%s %s\n", lab::count_text(n, what).c_str(), (n == 1 ? is : are).c_str());
  };
  left_out(found->of_other_programs, "row", "is of another build of cxlab, and does not count",
           "are of another build of cxlab, and do not count");
  left_out(found->outdated, "row",
           "is of a game that this suite does not play: its files have changed, or it never had it",
           "are of games that this suite does not play: its files have changed, or it never had them");
  left_out(found->broken, "file", "is not a row, or is cut short", "are not rows, or are cut short");
  const auto judged = suite.require.empty() || !found->missing.empty()
                          ? std::nullopt
                          : std::optional(lab::judged_rows(suite, found->rows));
  if (judged && !*judged) {
    print_table(suite, found->rows, options, nullptr);
    return fail(judged->error());
  }
  if (!found->rows.empty()) write_page(options, host, judged ? (*judged)->answers : std::vector<lab::Answer>());
  const int code = print_table(suite, found->rows, options, judged ? &**judged : nullptr);
  if (!found->contradictory.empty())
    return fail(negative(cells_text(found->contradictory) + ": two rows of the same game differ, " +
                         found->differ.first.string() + " and " + found->differ.second.string() +
                         "; the machines that played them differ, or one of the files was changed by hand"));
  if (!found->missing.empty())
    return fail(negative(cells_text(found->missing) + (found->missing.size() == 1 ? " has" : " have") +
                         " no row; cxlab bench " + options.suite + " --out " + options.folder().string() + " plays " +
                         (found->missing.size() == 1 ? "it" : "them")));
  return code;
}

int write_slurm(const lab::Suite& suite, const BenchOptions& options) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const auto scripts = lab::write_slurm({.program = error ? fs::path("cxlab") : program,
                                         .suite = options.suite,
                                         .folder = options.folder(),
                                         .cells = suite.size(),
                                         .tasks = static_cast<std::size_t>(options.tasks),
                                         .jobs = options.jobs,
                                         .time_limit_s = options.time_limit_s,
                                         .more = options.limits});
  if (!scripts) return fail(scripts.error());
  std::printf(
      "%s: %zu tasks of up to %zu cells\n%s: collects their rows and prints the table\n"
      "%s submits both, and hands its arguments on to sbatch\n",
      scripts->cells.c_str(), scripts->tasks, scripts->cells_of_task, scripts->collect.c_str(),
      scripts->submit.c_str());
  return 0;
}

int bench(const BenchOptions& options) {
  auto suite = lab::Suite::load(options.suite);
  if (!suite) return fail(suite.error());
  suite->catalogue = &catalogue();
  if (!options.seeds.empty()) {
    auto seeds = yaml::seeds_of(options.seeds);
    if (!seeds) return fail(usage_error("--seeds: " + seeds.error().message));
    suite->seeds = *std::move(seeds);
  }
  Console console(options.quiet);
  if (options.quiet) stop_reporting();
  if (options.verbose) console.show_all_games();
  const lab::Host host = console.host();
  if (options.cells) return list_cells(*suite, options, host.most);
  // The job of one machine reads what it plays, and no more: a file that is missing there is the reason in its row.
  if (options.cell.empty())
    if (Status s = suite->check(); !s) return fail(s.error());
  if (options.slurm) {
    if (const auto judge = lab::Judge::make(*suite); !judge) return fail(judge.error());
    return write_slurm(*suite, options);
  }
  if (!options.cell.empty()) return play_cells(*suite, options, host);
  if (!options.collect.empty()) return collect_rows(*suite, options, host);
  if (!suite->require.empty()) {
    const auto judged =
        lab::judged_sweep(*suite, {options.folder(), options.jobs, options.time_limit_s}, options.all, host);
    console.clear();
    if (!judged) return fail(judged.error());
    if (const int code = interrupted(finished_text(judged->rows.size(), suite->size()))) return code;
    write_page(options, host, judged->answers);
    return print_table(*suite, judged->rows, options, &*judged);
  }
  const auto rows = lab::sweep(*suite, {options.folder(), options.jobs, options.time_limit_s}, host);
  console.clear();
  if (!rows) return fail(rows.error());
  if (const int code = interrupted(finished_text(rows->size(), suite->size()))) return code;
  write_page(options, host);
  return print_table(*suite, *rows, options);
}

}  // namespace

void add_bench(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand(
      "bench", "Play scenarios with strategies and seeds, and compare them (docs/reference/sweeps.md)");
  command->footer(
      "Examples:\n"
      "  cxlab bench benchmarks/rcll.yaml -j 2\n"
      "  cxlab bench benchmarks/rcll.yaml --cell 17 --out rows-of-this-machine\n"
      "  cxlab bench benchmarks/rcll.yaml --collect rows-of-* --out runs/bench-rcll\n"
      "  cxlab bench show runs/bench-rcll --format markdown\n"
      "  cxlab bench page runs/bench-rcll --play -j 2\n"
      "  cxlab bench compare runs/before runs/after");
  add_limit_options(*command);
  CLI::Option* suite = command->add_option("suite", options->suite, "Suite file (YAML)");
  whole_number(command->add_option("-j,--jobs", options->jobs, "Episodes at once"), 1, 256);
  command->add_option("--out", options->out,
                      "Folder of the rows (default runs/bench-<suite>); keeps rows that are still current");
  command->add_option("--time-limit", options->time_limit_s, "Ends an episode after so many seconds of wall time")
      ->check(positive())
      ->type_name("S");
  CLI::Option* cells =
      command->add_flag("--cells", options->cells, "Lists the cells of the suite by number, and plays nothing");
  command
      ->add_flag("--missing", options->missing,
                 "With --cells: only those without a current row in the folder of --out, which a sweep would play")
      ->needs(cells);
  CLI::Option* cell =
      command->add_option("--cell", options->cell, "Plays only this cell, or those of a range: writes their rows")
          ->type_name("N[..M]");
  CLI::Option* collect =
      command
          ->add_option(
              "--collect", options->collect,
              "Collects the rows of these folders in the folder of --out, writes its tables, and plays nothing")
          ->type_name("DIR")
          ->expected(1, -1);
  CLI::Option* slurm = command->add_flag(
      "--slurm", options->slurm, "Writes a job array of Slurm and its collector below --out, and plays nothing");
  whole_number(command->add_option(
                   "--tasks", options->tasks,
                   "Tasks of the array of --slurm, which share the cells (default one for each cell, at most 1000)"),
               1, 1000000)
      ->needs(slurm);
  CLI::Option* seeds =
      command
          ->add_option("--seeds", options->seeds, "Plays these seeds instead of those of the suite: 7, 1..5 or 1..5,9")
          ->type_name("SEEDS");
  const std::array modes{cells, cell, collect, slurm, seeds};
  for (std::size_t i = 0; i < modes.size(); ++i)
    for (std::size_t j = i + 1; j < modes.size(); ++j) modes[i]->excludes(modes[j]);
  command->add_flag("--json", options->json, "Prints JSON instead of the table");
  command->add_flag("--quiet", options->quiet, "Prints no progress and no lines for episodes");
  command->add_flag("-v,--verbose", options->verbose, "Prints a line for each episode");
  command->add_flag("--all", options->all, "Plays all games, also when the requirements of the suite are answered");
  add_bench_tables(*command, action);
  command->callback([command, suite, options, &action] {
    if (!command->get_subcommands().empty()) return;
    if (suite->count() == 0) throw CLI::RequiredError(suite->get_name());
    options->limits = given_options(*command, {"--memory", "--disk", "--steps"});
    action = [options] { return bench(*options); };
  });
}

}  // namespace cxlab::app
