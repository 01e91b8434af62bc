// cxlab bench: scenarios x strategies x seeds, each episode in a process of its own.

#include <algorithm>
#include <cstdio>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "lab/sweep/sweep.h"
#include "lab/sweep/table.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

struct BenchOptions {
  std::string suite, out;
  int jobs = 1;
  bool json = false, quiet = false;
};

int bench(const BenchOptions& options) {
  auto suite = lab::Suite::load(options.suite);
  if (!suite) return fail(suite.error());
  suite->catalogue = &catalogue();
  if (Status s = suite->check(); !s) return fail(s.error());
  const fs::path folder = options.out.empty() ? fs::path("runs") / ("bench-" + fs::path(options.suite).stem().string())
                                              : fs::path(options.out);
  Console console(options.quiet);
  if (options.quiet) stop_reporting();
  const auto rows = lab::sweep(*suite, {folder, options.jobs}, console.host());
  if (!rows) return fail(rows.error());
  if (const int code = interrupted(std::to_string(rows->size()) + " of " + std::to_string(suite->cells().size()) +
                                   " episodes are finished and kept; the same command plays the others"))
    return code;
  const std::vector<lab::TableLine> table = lab::table_of(*rows, catalogue());
  if (options.json)
    std::fputs(lab::to_json(table).c_str(), stdout);
  else
    std::printf("%s%s\n", lab::to_text(table).c_str(), (folder / "rows.csv").c_str());
  const bool all_count = std::all_of(rows->begin(), rows->end(), [](const lab::Row& row) { return row.counts(); });
  return all_count ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_bench(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand("bench", "Plays scenarios x strategies x seeds and compares (docs/bench.md)");
  command->footer("Example:\n  cxlab bench benchmarks/rcll.yaml -j 2");
  add_limit_options(*command);
  command->add_option("suite", options->suite, "Suite file (YAML)")->required();
  whole_number(command->add_option("-j", options->jobs, "Episodes at once"), 1, 256);
  command->add_option("--out", options->out,
                      "Folder of the rows (default runs/bench-<suite>); rows that would come out the same are kept");
  command->add_flag("--json", options->json, "Prints JSON instead of the table");
  command->add_flag("--quiet", options->quiet, "No line for each episode");
  command->callback([options, &action] { action = [options] { return bench(*options); }; });
}

}  // namespace cxlab::app
