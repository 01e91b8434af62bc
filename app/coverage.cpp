// cxlab coverage: which rules and conditions of recorded runs were reached.

#include "app/coverage.h"

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/coverage_of_runs.h"

namespace cxlab::app {

namespace {

struct RunsCoverageOptions {
  std::vector<std::string> paths;
  lab::CoverageOptions reports;
  int jobs = 1;
  bool trust_programs = false, json = false;
};

/// What the sweeps among the paths have covered, then the runs.
Expected<lab::RunsCoverage> covered_by(const RunsCoverageOptions& options, const lab::Host& host) {
  std::vector<std::string> paths;
  std::vector<lab::SweepRecord> sweeps;
  for (const std::string& path : options.paths) {
    const std::filesystem::path folder(path);
    if (!is_file(folder / "runs.sqlite") || is_file(folder / "manifest.json")) {
      paths.push_back(path);
      continue;
    }
    if (!options.trust_programs)
      return usage_error(
          "the games of a sweep are played again by the commands in its runs.sqlite; if you trust them, add "
          "--trust-programs",
          path);
    auto sweep = lab::read_sweep(path, catalogue());
    if (!sweep) return sweep.error();
    sweeps.push_back(*std::move(sweep));
  }
  const auto folders = lab::run_folders(paths);
  if (!folders) return folders.error();
  std::vector<lab::Run> runs;
  for (const std::filesystem::path& folder : *folders) {
    auto run = open_run(folder.string(), options.trust_programs);
    if (!run) return run.error();
    runs.push_back(*std::move(run));
  }
  lab::RunsCoverage out;
  for (const lab::SweepRecord& sweep : sweeps) {
    auto covered = lab::coverage_of_sweep(sweep, options.jobs, host);
    if (!covered) return covered.error();
    out.add(*std::move(covered));
  }
  auto covered = lab::coverage_of_runs(runs, options.jobs, host);
  if (!covered) return covered.error();
  out.add(*std::move(covered));
  return out;
}

int coverage(const RunsCoverageOptions& options) {
  Console console(true);
  const auto covered = covered_by(options, console.host());
  if (const int code = interrupted("not all runs were played")) return code;
  if (!covered) return fail(covered.error());
  for (const std::string& note : covered->notes) std::fprintf(stderr, "note: %s\n", printable(note).c_str());
  if (options.json) {
    Json json{{"runs", covered->runs}};
    json.update(lab::json_of(covered->coverage));
    std::printf("%s\n", json_text(json, 2).c_str());
  } else {
    std::fputs(explain::text_of(covered->coverage).c_str(), stdout);
  }
  if (!options.reports.lcov.empty())
    for (const std::string& note : lab::notes_on_places(covered->coverage, covered->sources, covered->places))
      std::fprintf(stderr, "note: %s\n", printable(note).c_str());
  if (Status s = lab::write_reports(covered->coverage, options.reports, covered->sources, covered->places,
                                    covered->runs == 1 ? "Coverage of " + options.paths.front()
                                                       : "Coverage of " + std::to_string(covered->runs) + " runs");
      !s)
    return fail(s.error());
  const Status enough = lab::check_share(covered->coverage, options.reports);
  return enough ? 0 : fail(enough.error());
}

}  // namespace

CLI::Option* add_fail_under(CLI::App& command, std::optional<double>& percent, const std::string& what) {
  return command.add_option("--fail-under", percent, what)->check(between(0, 100))->type_name("PERCENT");
}

void add_coverage(CLI::App& command, const char* page, lab::CoverageOptions& options) {
  command.add_option(page, options.page,
                     "Writes a page with the coloured source of all rule files, which needs no other file");
  add_fail_under(command, options.fail_under, "Exit code 1 if fewer percent of the rules fired, or there is none");
}

void add_coverage(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunsCoverageOptions>();
  CLI::App* command = app.add_subcommand(
      "coverage", "Report which rules of recorded runs fired, how far conditions got, and which functions were called");
  command
      ->add_option("runs", options->paths,
                   "Folders of runs, folders with such folders below, or sweeps; the counts are summed up")
      ->required();
  add_limit_options(*command);
  add_trust_programs(*command, options->trust_programs);
  command->add_option("--lcov", options->reports.lcov, "Writes the counts as lcov, for genhtml and CI");
  add_coverage(*command, "--html", options->reports);
  whole_number(command->add_option("-j,--jobs", options->jobs, "Processes"), 1, 256);
  command->add_flag("--json", options->json, "Prints JSON");
  command->footer(
      "cxlab plays the rules of each run again from its records, to its end and through deactivation. A sweep keeps\n"
      "no runs, so its games are played again first, which takes a little longer than the sweep. The commands of\n"
      "these games come from runs.sqlite of the sweep, so --trust-programs is necessary.\n"
      "Exit code 1: fewer rules fired than --fail-under says. For the coverage of stories, use cxlab test --coverage\n"
      "(docs/reference/coverage.md).\n"
      "Examples:\n  cxlab coverage runs/game-1\n  cxlab coverage runs --html coverage.html --fail-under 80 -j 2\n"
      "  cxlab coverage runs/bench-rcll --trust-programs -j 2");
  command->callback([options, &action] { action = [options] { return coverage(*options); }; });
}

}  // namespace cxlab::app
