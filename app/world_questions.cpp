// Questions that worlds declare (scenarios/question.h): a command of `cxlab` for each, printed in one way.

#include <algorithm>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/table_text.h"
#include "lab/world_answer.h"
#include "scenarios/question.h"

namespace cxlab::app {

namespace {

struct AskedWorld {
  std::string name;  ///< of the question
  std::string run, about, sort;
  std::optional<double> at, from, to;
  bool json = false;
};

int answer(const AskedWorld& ask) {
  const auto run = open_run(ask.run);
  if (!run) return fail(run.error());
  const auto time = [](const std::optional<double>& t) { return t ? std::optional(from_seconds(*t)) : std::nullopt; };
  auto answered = lab::ask_world(*run, {ask.name, ask.about, time(ask.at), time(ask.from), time(ask.to)});
  if (!answered) return fail(answered.error());
  std::vector<Table>& tables = answered->answer.tables;
  if (!ask.sort.empty() && !tables.empty())
    if (Status s = lab::sort_table(tables.front(), ask.sort); !s) return fail(s.error());
  const std::string text =
      ask.json ? json_text(lab::world_json(*answered), 2) + '\n' : lab::world_text(*answered, line_width());
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

Status add_world_questions(CLI::App& app, Action& action) {
  std::vector<std::string> commands, added;
  for (const CLI::App* command : app.get_subcommands(nullptr)) commands.push_back(command->get_name());
  for (const WorldKind* world : catalogue().worlds)
    for (const WorldQuestion& question : world->questions) {
      const std::string name(question.name);
      if (std::ranges::find(added, name) != added.end()) continue;
      if (std::ranges::find(commands, name) != commands.end())
        return bug_error("the world " + std::string(world->name) + " declares a question '" + name +
                         "', which is a command of cxlab");
      added.push_back(name);
      auto ask = std::make_shared<AskedWorld>();
      ask->name = name;
      CLI::App* command = app.add_subcommand(name, std::string(question.what));
      command->add_option("run", ask->run, "Folder of the run")->required();
      if (!question.argument.empty())
        command->add_option(std::string(question.argument), ask->about, std::string(question.argument_help));
      CLI::Option* at = time_option(
          command->add_option("--at", ask->at, "Time: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
      CLI::Option* from = time_option(
          command->add_option("--from", ask->from, "Beginning of the stretch (default: the start of the run)"));
      CLI::Option* to =
          time_option(command->add_option("--to", ask->to, "End of the stretch (default: the end of the run)"));
      from->excludes(at);
      to->excludes(at);
      command->add_option("--sort", ask->sort,
                          "Sorts the first table by the column of this key in JSON: numbers from the greatest");
      command->add_flag("--json", ask->json, "Prints the answer as JSON");
      const std::vector<std::string> worlds = lab::worlds_with(catalogue(), name);
      command->footer("For runs of the world " + some_of(worlds) + ".\nExamples:\n" + std::string(question.examples));
      command->callback([ask, &action] { action = [ask] { return answer(*ask); }; });
    }
  return {};
}

}  // namespace cxlab::app
