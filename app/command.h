#pragma once
// The subcommands of `cxlab`, one file each. A command declares its options and says what to do when it is chosen.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/catalogue.h"

namespace cxlab::app {

/// Set by the chosen command; gives the exit code.
using Action = std::function<int()>;

void add_run(CLI::App& app, Action& action);
void add_attach(CLI::App& app, Action& action);
void add_ask(CLI::App& app, Action& action);
void add_view(CLI::App& app, Action& action);
void add_replay(CLI::App& app, Action& action);
void add_rerun(CLI::App& app, Action& action);
void add_env(CLI::App& app, Action& action);
void add_render(CLI::App& app, Action& action);
void add_facts(CLI::App& app, Action& action);
void add_agenda(CLI::App& app, Action& action);
void add_globals(CLI::App& app, Action& action);
void add_firings(CLI::App& app, Action& action);
void add_why(CLI::App& app, Action& action);
void add_why_not(CLI::App& app, Action& action);
void add_rules(CLI::App& app, Action& action);
void add_scene(CLI::App& app, Action& action);
void add_diff(CLI::App& app, Action& action);
void add_check(CLI::App& app, Action& action);
void add_coverage(CLI::App& app, Action& action);
void add_profile(CLI::App& app, Action& action);
void add_export(CLI::App& app, Action& action);
/// Adds a command for each question of a world in the catalogue; fails where one has the name of another command.
Status add_world_questions(CLI::App& app, Action& action);
void add_validate(CLI::App& app, Action& action);
void add_list(CLI::App& app, Action& action);
void add_doc(CLI::App& app, Action& action);
void add_test(CLI::App& app, Action& action);
void add_mutate(CLI::App& app, Action& action);
void add_bench(CLI::App& app, Action& action);
/// Adds the commands of `bench` that play nothing.
void add_bench_tables(CLI::App& bench, Action& action);
void add_plan(CLI::App& app, Action& action);
void add_new(CLI::App& app, Action& action);
void add_doctor(CLI::App& app, Action& action);
void add_help(CLI::App& app, Action& action);
void add_completion(CLI::App& app, Action& action);
void add_man(CLI::App& app, Action& action);

/// Prints `error: file:line: message` on stderr and gives the exit code of its kind.
int fail(const Error& error);
/// Declares the commands of a program, and the last lines of its help.
using Commands = Status (*)(CLI::App& app, Action& action);
/// Carries out the command line; returns the exit code.
int run_commands(int argc, char** argv, const Catalogue& catalogue, Commands declare);
/// The worlds and nodes that this program knows (app/program.h).
const Catalogue& catalogue();
/// The arguments of this process, for the manifest.
const std::vector<std::string>& command_line();

}  // namespace cxlab::app
