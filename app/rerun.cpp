// cxlab rerun: plays a run again from its manifest, and compares the hashes; or lets it go on otherwise from a time.

#include <algorithm>
#include <cstdio>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "cx/base/json.h"
#include "lab/rerun.h"

namespace cxlab::app {

namespace {

struct RerunOptions {
  std::string run, out;
  bool force = false, json = false, quiet = false, trust_rules = false, trust_programs = false;
  std::optional<double> at, until;
  WhatIf what_if;
};

void print_changed(const std::vector<std::string>& files, const std::vector<std::string>& surroundings) {
  for (const std::string& name : files) std::printf("  not the file of the run: %s\n", name.c_str());
  for (const std::string& what : surroundings) std::printf("  not as in the run: %s\n", what.c_str());
}

int compare(const RerunOptions& options, const lab::Run& run, const lab::Rerun& again) {
  const auto& [played, differ, first, changed, before, after, results] = again;
  if (options.json) {
    const Json out{{"same", differ.empty()},
                   {"run", options.run},
                   {"again", played.folder.string()},
                   {"differ", differ},
                   {"first_differences", first},
                   {"changed_files", changed},
                   {"changed_surroundings", run.changed_surroundings()}};
    std::printf("%s\n", json_text(out, 2).c_str());
  } else if (differ.empty()) {
    std::printf("the same: %zu streams%s; %s\n", run.stream_hashes.size(), run.physics_hash ? " and the physics" : "",
                played.folder.c_str());
  } else {
    std::string list;
    for (const std::string& name : differ) list += (list.empty() ? "" : ", ") + name;
    std::printf("different: %s; %s\n", list.c_str(), played.folder.c_str());
    for (const std::string& what : first) std::printf("  first: %s\n", what.c_str());
    print_changed(changed, run.changed_surroundings());
  }
  return differ.empty() ? 0 : static_cast<int>(ErrorKind::kNo);
}

// --- What if

Json to_json(const lab::Difference& difference) {
  return {{"stream", difference.stream},
          {"t", to_seconds(difference.t)},
          {"then", difference.then},
          {"now", difference.now}};
}

void print_what_if_json(const RerunOptions& options, const lab::Run& run, const lab::Rerun& again) {
  Json out{{"run", options.run},
           {"again", again.played.folder.string()},
           {"at", *options.at},
           {"same_before", !again.before},
           {"first_difference_before", again.before ? to_json(*again.before) : Json()},
           {"changes", Json::array()},
           {"then", Json::object()},
           {"now", Json::object()},
           {"first_differences", Json::array()},
           {"changed_files", again.changed_files},
           {"changed_surroundings", again.before ? run.changed_surroundings() : std::vector<std::string>()}};
  for (const lab::WhatIfAct& act : again.played.changed)
    out["changes"].push_back({{"t", to_seconds(act.t)}, {"env", act.environment}, {"what", act.what}});
  for (const lab::ResultChange& result : again.results) {
    const auto value = [](const std::string& text) {
      Json number = parse_json(text);
      return number.is_number() ? number : Json(text);
    };
    out["then"][result.what] = value(result.then);
    out["now"][result.what] = value(result.now);
  }
  for (const lab::Difference& difference : again.after) out["first_differences"].push_back(to_json(difference));
  std::printf("%s\n", json_text(out, 2).c_str());
}

/// One line of the terminal: records may be long.
std::string shortened(const std::string& text) {
  constexpr std::size_t kMost = 400;
  if (text.size() <= kMost) return text;
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // no half of a character
  return text.substr(0, end) + "...";
}

void print_what_if(const lab::Run& run, const lab::Rerun& again, double at) {
  if (again.before) {
    std::printf("different before %s: %s\n", seconds_text(from_seconds(at)).c_str(),
                printable(shortened(again.before->text())).c_str());
    print_changed(again.changed_files, run.changed_surroundings());
  } else if (!again.played.folder.empty()) {
    std::printf("as then up to %s\n", seconds_text(from_seconds(at)).c_str());
  }
  for (const lab::WhatIfAct& act : again.played.changed)
    std::printf("%s  %s: %s\n", seconds_text(act.t).c_str(), act.environment.c_str(), printable(act.what).c_str());
  std::size_t width = 0, column = 4;
  for (const lab::ResultChange& result : again.results) {
    width = std::max(width, result.what.size());
    column = std::max(column, result.then.size());
  }
  column = std::min<std::size_t>(column, 40);
  std::string then = "then", now = "now";
  if (const SimTime end = again.played.result.sim_time; run.finished && end != run.sim_time) {
    then += ", up to " + seconds_text(run.sim_time);
    now += ", up to " + seconds_text(end);
    column = std::max(column, then.size());
  }
  std::printf("\n%-*s  %-*s  %s\n", static_cast<int>(width), "", static_cast<int>(column), then.c_str(), now.c_str());
  for (const lab::ResultChange& result : again.results)
    std::printf("%-*s  %-*s  %s\n", static_cast<int>(width), result.what.c_str(), static_cast<int>(column),
                printable(result.then).c_str(), printable(result.now).c_str());
  if (again.after.empty() && !again.played.folder.empty())
    std::printf("\nno record of the journal differs\n");
  else if (!again.after.empty())
    std::printf("\n");
  constexpr std::size_t kMost = 5;
  for (std::size_t i = 0; i < again.after.size() && i < kMost; ++i)
    std::printf("%s: %s\n", i == 0 ? "first difference" : "and", printable(shortened(again.after[i].text())).c_str());
  if (again.after.size() > kMost) std::printf("and in %zu more streams\n", again.after.size() - kMost);
  if (!again.played.folder.empty()) std::printf("%s\n", again.played.folder.c_str());
}

/// The options for another course of the run, as a whole.
Expected<std::optional<WhatIf>> what_if_of(const RerunOptions& options) {
  WhatIf what_if = options.what_if;
  if (options.at) {
    what_if.at = *options.at;
    if (!what_if.environments.empty() && what_if.changes_nothing())
      return usage_error("--env: says for which environment --then, --set and --assert are, and none of them is given");
    return std::optional(what_if);
  }
  const char* given = !what_if.file.empty()           ? "--then"
                      : !what_if.set.empty()          ? "--set"
                      : !what_if.facts.empty()        ? "--assert"
                      : !what_if.environments.empty() ? "--env"
                      : options.until                 ? "--until"
                                                      : nullptr;
  if (!given) return std::optional<WhatIf>();
  return usage_error(std::string(given) + ": expected --at T as well, the time from which the run goes on otherwise");
}

int rerun(const RerunOptions& options) {
  auto what_if = what_if_of(options);
  if (!what_if) return fail(what_if.error());
  auto run = lab::Run::open(options.run, catalogue(), options.trust_programs);
  if (!run) return fail(run.error());
  if (!run->finished && !*what_if)
    return fail(input_error("the run was cut off before its end: there is nothing to compare with", options.run));
  Console console(options.quiet);
  if (options.quiet) stop_reporting();
  auto again = lab::rerun(*run,
                          {.out = options.out,
                           .force = options.force,
                           .command = command_line(),
                           .trust_rules = options.trust_rules,
                           .until = options.until,
                           .what_if = *what_if},
                          console.host());
  console.clear();
  if (!again) return fail(again.error());
  const int code = conclude(again->played, console);
  if (signal_that_came()) return 128 + signal_that_came();
  if (!*what_if) return again->played.result.stream_hashes.empty() ? code : compare(options, *run, *again);
  if (again->results.empty() || (again->played.failure && again->played.failure->code == lab::kWhatIfCode)) return code;
  if (options.json)
    print_what_if_json(options, *run, *again);
  else
    print_what_if(*run, *again, (*what_if)->at);
  return again->before ? static_cast<int>(ErrorKind::kNo) : code;
}

}  // namespace

void add_rerun(CLI::App& app, Action& action) {
  auto options = std::make_shared<RerunOptions>();
  CLI::App* command = app.add_subcommand(
      "rerun", "Play a run again into a new folder and compare the hashes, or continue it differently from a time");
  add_limit_options(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("--out", options->out, "Folder of the new run (default runs/<scenario>-<seed>)");
  command->add_flag("--force", options->force, "Overwrites a folder that is in use");
  time_option(command->add_option("--at", options->at,
                                  "What if: plays the run exactly up to this time (s, or 5:12.4), and continues with "
                                  "the changes of --then, --set and --assert"));
  command->add_option(
      "--then", options->what_if.file,
      "With --at: a file of rules, loaded as batch* does; a construct replaces the one of the same name");
  once_each(command->add_option("--set", options->what_if.set,
                                "With --at: NODE.NAME=VALUE, a parameter of an agent's node, or '?*NAME*=VALUE', a "
                                "global of rules (repeatable)"));
  once_each(
      command->add_option("--assert", options->what_if.facts, "With --at: a fact, as '(order (id 3))' (repeatable)"));
  once_each(command->add_option("--env", options->what_if.environments,
                                "With --at: the environment for --then, globals and facts (repeatable; default: all "
                                "environments; facts need exactly one)"));
  time_option(command->add_option("--until", options->until,
                                  "With --at: end of the new run (default: the end of the old one)"));
  command->add_flag("--trust-rules", options->trust_rules,
                    "Lets rules that were trusted in the run read, write and run anything again");
  add_trust_programs(*command, options->trust_programs);
  command->add_flag("--json", options->json, "Prints the answer as JSON");
  command->add_flag("--quiet", options->quiet, "Prints no progress and no log lines");
  command->footer(
      "Examples:\n  cxlab rerun runs/game-1\n"
      "  cxlab rerun runs/game-1 --at 5:12.4 --then repair.clp      # a repair, at the moment where it matters\n"
      "  cxlab rerun runs/game-1 --at 300 --assert '(order (id 11))' --set '?*patience*=20'");
  command->callback([options, &action] { action = [options] { return rerun(*options); }; });
}

}  // namespace cxlab::app
