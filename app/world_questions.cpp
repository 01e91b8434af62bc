// Questions that worlds declare (scenarios/question.h): a command of `cxlab` for each, printed in one way.

#include <algorithm>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/table.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/run.h"
#include "scenarios/question.h"

namespace cxlab::app {

namespace {

struct WorldAsk {
  std::string name;  ///< of the question
  std::string run, about, sort;
  std::optional<double> at, from, to;
  bool json = false;
};

// --- The run

/// The names of the worlds that answer a question.
std::vector<std::string> worlds_with(const std::string& question) {
  std::vector<std::string> out;
  for (const WorldKind* world : catalogue().worlds)
    for (const WorldQuestion& one : world->questions)
      if (one.name == question) out.emplace_back(world->name);
  return out;
}

const WorldQuestion* find_question(const WorldKind& world, const std::string& name) {
  for (const WorldQuestion& one : world.questions)
    if (one.name == name) return &one;
  return nullptr;
}

struct Recorded {
  std::vector<JournalRecord> records;  ///< up to `to`
  SimTime from{}, to{};
  bool ended = false, cut_off = false;
};

Expected<Recorded> read_records(const lab::Run& run, const WorldAsk& ask) {
  auto records = run.records({.kinds = kRecordsOfQuestions});
  if (!records) return records.error();
  Recorded out;
  SimTime last{};
  for (const JournalRecord& record : *records) last = std::max(last, record.t);
  const bool whole = run.has_whole_journal();
  const SimTime end = whole ? run.sim_time : last;
  const char* option = ask.at ? "--at" : "--to";
  const std::optional<double> asked = ask.at ? ask.at : ask.to;
  out.to = asked ? from_seconds(*asked) : end;
  out.from = ask.from ? from_seconds(*ask.from) : SimTime{};
  if (run.finished && out.to > run.sim_time)
    return usage_error(std::string(option) + ": the run ended at " + general_text(to_seconds(run.sim_time), 9) + " s");
  out.cut_off = !whole && out.to >= end;
  out.to = std::min(out.to, end);
  if (out.from > out.to)
    return usage_error(std::string("--from is after the end of ") + (whole ? "the run, " : "the journal, ") +
                       time_text(out.to));
  out.ended = whole && out.to == end;
  for (JournalRecord& record : *records)
    if (record.t <= out.to) out.records.push_back(std::move(record));
  return out;
}

int answer(const WorldAsk& ask) {
  if (ask.from && ask.to && *ask.from > *ask.to) return fail(usage_error("--from is after --to"));
  auto run = lab::Run::open(ask.run, catalogue());
  if (!run) return fail(run.error());
  const auto scenario = run->scenario();
  if (!scenario) return fail(scenario.error());
  const WorldQuestion* question = find_question(*scenario->world.kind, ask.name);
  if (!question) {
    const std::vector<std::string> worlds = worlds_with(ask.name);
    return fail(input_error("the world of this run, " + std::string(scenario->world.kind->name) +
                                ", has no question '" + ask.name + "'; it is one of " + some_of(worlds, worlds.size()),
                            ask.run));
  }
  auto recorded = read_records(*run, ask);
  if (!recorded) return fail(recorded.error());
  auto given = question->ask(
      {run->folder, *scenario, recorded->records, recorded->from, recorded->to, recorded->ended, ask.about});
  if (!given) return fail(given.error());
  if (!ask.sort.empty() && !given->tables.empty())
    if (Status s = sort_table(given->tables.front(), ask.sort); !s) return fail(s.error());
  if (ask.json) {
    Json json{{"at_s", to_seconds(recorded->to)}};
    if (recorded->from > SimTime{}) json["from_s"] = to_seconds(recorded->from);
    if (recorded->cut_off) json["cut_off"] = true;
    for (const Table& table : given->tables) json[table.key] = table_json(table);
    json["notes"] = given->notes;
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  std::printf("up to %s%s:\n", time_text(recorded->to).c_str(),
              recorded->cut_off ? ", where the journal of the run is cut off" : "");
  for (std::size_t i = 0; i < given->tables.size(); ++i)
    std::printf("%s%s", i ? "\n" : "", table_text(given->tables[i]).c_str());
  for (std::size_t i = 0; i < given->notes.size(); ++i) std::printf("%s%s\n", i ? "" : "\n", given->notes[i].c_str());
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
      auto ask = std::make_shared<WorldAsk>();
      ask->name = name;
      CLI::App* command = app.add_subcommand(name, std::string(question.what));
      command->add_option("run", ask->run, "Folder of the run")->required();
      if (!question.argument.empty())
        command->add_option(std::string(question.argument), ask->about, std::string(question.argument_help));
      CLI::Option* at = time_option(
          command->add_option("--at", ask->at, "As it was then: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
      CLI::Option* from =
          time_option(command->add_option("--from", ask->from, "The stretch begins then (default: the start)"));
      CLI::Option* to =
          time_option(command->add_option("--to", ask->to, "The stretch ends then (default: the end of the run)"));
      from->excludes(at);
      to->excludes(at);
      command->add_option("--sort", ask->sort,
                          "Sorts the first table by the column of this key in JSON: numbers from the greatest");
      command->add_flag("--json", ask->json, "The answer as JSON");
      const std::vector<std::string> worlds = worlds_with(name);
      command->footer("Of runs of the world " + some_of(worlds, worlds.size()) + ".\nExamples:\n" +
                      std::string(question.examples));
      command->callback([ask, &action] { action = [ask] { return answer(*ask); }; });
    }
  return {};
}

}  // namespace cxlab::app
