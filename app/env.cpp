// cxlab env: an unchanged configuration of the CX, with an empty world or the nodes named.

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/play.h"
#include "app/suggestions.h"
#include "cx/base/number_text.h"
#include "lab/env_scenario.h"

namespace cxlab::app {

namespace {

struct EnvOptions {
  lab::EnvOptions env;
  PlayCommand run;
};

std::vector<std::string> companion_names() {
  std::vector<std::string> names;
  for (const lab::Companion& companion : lab::companions(catalogue())) names.emplace_back(companion.name);
  return names;
}

int env(const EnvOptions& options) {
  lab::EnvOptions env = options.env;
  env.until = options.run.play.spec.until;
  if (options.run.seed) env.seed = options.run.seed;
  auto scenario = lab::env_scenario(env, catalogue());
  if (!scenario) return fail(scenario.error());
  PlayCommand run = options.run;
  run.lives = true;
  if (!run.play.spec.until && !run.quiet)
    std::fprintf(stderr, "ends at %s s of simulated time; --until T for another\n",
                 general_text(to_seconds(scenario->duration), 9).c_str());
  run.play.spec.until.reset();  // it is the scenario's duration
  const auto [code, played] = play(run, *std::move(scenario));
  if (played.result.journal_hash.empty()) return code;
  if (run.json) {
    std::fputs(played.result.to_json().c_str(), stdout);
    return code;
  }
  std::printf("%s after %s of simulated time, %zu rule errors\n", to_string(played.result.status),
              seconds_text(played.result.sim_time).c_str(), played.result.rule_errors.size());
  if (!played.folder.empty()) std::printf("%s\n", played.folder.c_str());
  return code;
}

void declare(CLI::App& command, EnvOptions& options) {
  command
      .add_option("config", options.env.configs,
                  "Configurations of the CLIPS-Executive (YAML), one environment manager each")
      ->required();
  once_each(command.add_option("--package", options.env.packages,
                               "NAME=DIR: folder of a package (default: the packages around the configuration)"));
  suggest(once_each(command.add_option("--with", options.env.with,
                                       "Plays in a world, or starts a node: " + lab::known_companions(catalogue()))),
          companion_names);
  once_each(command.add_option("--param", options.env.params, "NODE.NAME=VALUE: changes a parameter"));
  command.add_option("--namespace", options.env.name_space, "Namespace of the nodes")->capture_default_str();
  once_each(command.add_option("--remap", options.env.remaps, "FROM:=TO: renames a topic, service or action"));
  declare_bag(command, options.env.bag);
  command.add_option("--stimuli", options.env.stimuli,
                     "File of stimuli from outside (YAML list, docs/reference/scenario.md)");
  command.add_flag("!--no-activate", options.env.activate,
                   "Managers without autostart_node stay unconfigured until a request");
  once_each(command.add_option("--transition", options.env.transitions,
                               "SECONDS:NAME[@NODE]: configure, activate, deactivate, cleanup or shutdown of a manager "
                               "(docs/reference/plugins/manager.md)"));
  options.run.play.spec.keep_going = true;
  command.add_flag("--keep-going,!--no-keep-going", options.run.play.spec.keep_going,
                   "Reports errors in rule files and continues (default); the run then ends with exit code 3");
  command.add_flag("--stop-on-rule-error", options.env.stop_on_rule_error,
                   "An error in a rule ends the run with exit code 4 (default: the run continues, and the exit code "
                   "does not change)");
  whole_number(command.add_option(
                   "--max-firings", options.env.max_firings,
                   "Firings of an environment in one tick that end the run as a loop (default 100000, 0 = no limit)"),
               0, std::int64_t{1} << 62);
  command.add_flag("--trust-rules", options.env.trust_rules, "Lets rules read, write and run anything");
  declare_play(command, options.run);
  command.get_option("--until")->description(
      "End, s of simulated time (default 60; with --bag a second after its end)");
}

}  // namespace

void add_env(CLI::App& app, Action& action) {
  auto options = std::make_shared<EnvOptions>();
  CLI::App* command = app.add_subcommand(
      "env", "Run a configuration of the CLIPS-Executive as it is, in an empty world or with the nodes of --with");
  command->footer(
      "Examples:\n  cxlab env docs/examples/hello/hello.yaml\n  cxlab env my_agent/params/agent.yaml --until 30 "
      "--stimuli tests/stimuli.yaml\n  cxlab env my_agent/params/agent.yaml --bag floor.mcap --out runs/floor\n  cxlab "
      "env scenarios/turtlesim/agents/params/boundary.yaml --with turtlesim");
  declare(*command, *options);
  command->callback([options, &action] { action = [options] { return env(*options); }; });
}

}  // namespace cxlab::app
