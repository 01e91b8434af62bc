// cxlab rerun: plays a run again from its manifest, and compares the hashes.

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "cx/base/json_text.h"
#include "lab/rerun.h"

namespace cxlab::app {

namespace {

struct RerunOptions {
  std::string run, out;
  bool force = false, json = false, quiet = false, trust_rules = false, trust_programs = false;
};

int rerun(const RerunOptions& options) {
  auto run = lab::RecordedRun::open(options.run, catalogue());
  if (!run) return fail(run.error());
  run->options.programs = options.trust_programs;
  if (!run->finished)
    return fail(input_error("the run was cut off before its end: there is nothing to compare with", options.run));
  Console console(options.quiet);
  if (options.quiet) stop_reporting();
  auto again = lab::rerun(*run, {options.out, options.force, command_line(), options.trust_rules}, console.host());
  console.clear();
  if (!again) return fail(again.error());
  const auto& [played, differ, first, changed] = *again;
  const int code = conclude(played, console);
  if (signal_that_came()) return 128 + signal_that_came();
  if (played.result.stream_hashes.empty()) return code;
  if (options.json) {
    const nlohmann::ordered_json out{{"same", differ.empty()},
                                     {"run", options.run},
                                     {"again", played.folder.string()},
                                     {"differ", differ},
                                     {"first_differences", first},
                                     {"changed_files", changed},
                                     {"changed_surroundings", run->changed_surroundings()}};
    std::printf("%s\n", json_text(out, 2).c_str());
  } else if (differ.empty()) {
    std::printf("the same: %zu streams%s; %s\n", run->stream_hashes.size(), run->physics_hash ? " and the physics" : "",
                played.folder.c_str());
  } else {
    std::string list;
    for (const std::string& name : differ) list += (list.empty() ? "" : ", ") + name;
    std::printf("different: %s; %s\n", list.c_str(), played.folder.c_str());
    for (const std::string& what : first) std::printf("  first: %s\n", what.c_str());
    for (const std::string& name : changed) std::printf("  not the file of then: %s\n", name.c_str());
    for (const std::string& what : run->changed_surroundings()) std::printf("  not as then: %s\n", what.c_str());
  }
  return differ.empty() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_rerun(CLI::App& app, Action& action) {
  auto options = std::make_shared<RerunOptions>();
  CLI::App* command =
      app.add_subcommand("rerun", "Plays a run again into a new folder and says whether the hashes agree");
  add_limit_options(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("--out", options->out, "Folder of the new run (default runs/<scenario>-<seed>)");
  command->add_flag("--force", options->force, "Overwrites a folder that is in use");
  command->add_flag("--trust-rules", options->trust_rules,
                    "Rules that were trusted then may read, write and run anything again");
  add_trust_programs(*command, options->trust_programs);
  command->add_flag("--json", options->json, "The answer as JSON");
  command->add_flag("--quiet", options->quiet, "No progress and no log lines");
  command->callback([options, &action] { action = [options] { return rerun(*options); }; });
}

}  // namespace cxlab::app
