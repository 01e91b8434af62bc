#include "app/play.h"

#include <algorithm>
#include <cstdio>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "lab/report.h"

namespace cxlab::app {

void declare_play(CLI::App& command, PlayCommand& options) {
  lab::PlayOptions& play = options.play;
  RunSpec& spec = play.spec;
  seed_number(command.add_option("--seed", options.seed, "Seed of all chance, instead of the scenario's"));
  time_option(command.add_option("--until", spec.until, "End, s of simulated time, or 5:12.4"));
  command.add_option("--out", play.out, "Folder of the run; 'none' writes nothing (default runs/<scenario>-<seed>)");
  command.add_flag("--force", play.force, "Overwrites a folder that is in use");
  add_choice(command, "--journal", named(spec.journal, kJournalLevels),
             "What journal.jsonl holds: none, decisions or full")
      ->default_str(std::string(named(spec.journal, kJournalLevels).word()));
  command.add_flag("--strict-cx", spec.strict,
                   "Reports as errors what the real CX would do differently (docs/reference/strict-cx.md)");
  add_choice(
      command, "--release", named(spec.release, cx::kRosReleases),
      "With --strict-cx: the release of ROS 2 for which the agent is meant: humble, jazzy or kilted (default kilted)");
  add_prefix_option(command, spec.prefixes);
  add_limit_options(command);
  command.add_flag("--control", play.control, "Opens a socket in the run's folder for cxlab attach");
  command.add_option("--control-at", play.control_at, "Opens the socket at a path, or at 127.0.0.1:PORT with a token");
  command.add_flag("--break", play.begin_stopped, "Begins stopped, for cxlab attach, and opens the socket");
  command.add_flag("--realtime", play.realtime, "Sleeps between ticks, to watch");
  command.add_flag("--sockets", spec.sockets,
                   "Lets programs of this machine reach the ports of agents and nodes; sleeps between ticks");
  command.add_flag("--json", options.json, "Prints result.json instead of a summary");
  command.add_flag("-v,--verbose", options.verbose, "Also shows the states of nodes and lines of level debug");
  command.add_flag("--quiet", options.quiet, "Prints neither progress nor log lines, only errors");
}

void declare_bag(CLI::App& command, lab::BagOptions& options) {
  command.add_option("--bag", options.file,
                     "Plays a recording: an MCAP file, or a folder of ros2 bag record (docs/how-to/replay-a-bag.md)");
  time_option(
      command.add_option("--bag-start", options.start, "Begins so many seconds after the first message of the bag"));
  time_option(command.add_option("--bag-offset", options.offset, "Simulated time of that first message (default 0)"));
  command.add_option("--bag-rate", options.rate, "Seconds of the bag in a second of simulated time (default 1)");
  command.add_option("--bag-topics", options.topics, "Regular expression: plays only names that contain a match");
  command.add_option("--bag-exclude", options.exclude, "Regular expression: leaves out names that contain a match");
  once_each(command.add_option("--bag-remap", options.remaps,
                               "FROM:=TO: plays a topic, service or action under another name"));
  command.add_flag("--bag-own", options.own, "Also plays topics that this run publishes");
}

Outcome play(const PlayCommand& command, Scenario scenario) {
  show_debug_lines({.lives = command.lives || command.verbose, .others = command.verbose});
  Console console(command.quiet);
  if (command.quiet) stop_reporting();
  lab::PlayOptions options = command.play;
  options.command = command_line();
  if (!command.quiet) doing("loading " + scenario.name);
  auto played = lab::play_scenario(options, std::move(scenario), console.host());
  console.clear();
  if (!played) return {fail(played.error()), {}};
  return {conclude(*played, console), *std::move(played)};
}

namespace {

/// The errors of rules, in their order. Whether what the run failed of is one of them.
bool print_rule_errors(const lab::Played& played) {
  constexpr std::size_t kMost = 20;
  std::size_t printed = 0;
  bool failure_printed = false;
  for (const RuleErrorResult& e : played.result.rule_errors) {
    if (e.side == "load") continue;
    if (++printed > kMost) continue;
    const std::string what = (e.side == "callback" ? "" : "rule ") + e.rule + ", " + e.side + ": " + e.message;
    const Error error = Error{ErrorKind::kRun, what, e.file, e.line, "rule_error"};
    failure_printed = failure_printed || (played.failure && played.failure->text() == error.text());
    (void)fail(error);
  }
  if (printed > kMost)
    std::fprintf(stderr, "%s %zu more, in result.json\n", coloured("errors:", kRed).c_str(), printed - kMost);
  return failure_printed;
}

std::string what_there_is(const lab::Played& played) {
  const std::string end = seconds_text(played.result.sim_time) + " of simulated time";
  if (played.result.status != RunStatus::kInterrupted) return "the run had come to its end after " + end;
  return "the run ended after " + end +
         (played.folder.empty() ? "" : ", and " + played.folder.string() + " has it up to then");
}

}  // namespace

int conclude(const lab::Played& played, const Console& console) {
  if (!console.quiet()) doing("writing the page of the run");
  const Status page = lab::write_report(played);
  const bool failure_printed = console.quiet() && print_rule_errors(played);
  std::size_t shown = 0;  // of files that could not be loaded, while the run went on
  for (const Error& error : played.errors)
    if (error.kind == ErrorKind::kInput && console.has_shown(error.text()))
      ++shown;
    else if (!failure_printed || error.text() != played.failure->text())
      (void)fail(error);
  if (shown > 0) std::fprintf(stderr, "%s %zu, reported in the log above\n", coloured("errors:", kRed).c_str(), shown);
  if (played.failure) return static_cast<int>(played.failure->kind);
  if (!console.quiet())
    for (const std::string& warning : played.result.all_warnings())
      std::fprintf(stderr, "%s %s\n", coloured("warning:", kYellow).c_str(), printable(warning).c_str());
  if (!page) return fail(page.error());
  return interrupted(what_there_is(played));
}

}  // namespace cxlab::app
