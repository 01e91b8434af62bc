#include "lab/world_answer.h"

#include <algorithm>
#include <utility>

namespace cxlab::lab {

namespace {

Error unknown_question(const Run& run, const WorldKind& world, const std::string& name) {
  const std::string of_world = "the world of this run, " + std::string(world.name) + ", has no question '" + name + "'";
  const std::vector<std::string> worlds = worlds_with(*run.catalogue, name);
  if (!worlds.empty()) return input_error(of_world + "; it is one of " + some_of(worlds), run.folder.string());
  std::vector<std::string> known;
  for (const WorldQuestion& one : world.questions) known.emplace_back(one.name);
  return input_error(of_world + (known.empty() ? "" : "; it answers " + some_of_and_nearest(name, known)),
                     run.folder.string());
}

}  // namespace

std::vector<std::string> worlds_with(const Catalogue& catalogue, const std::string& question) {
  std::vector<std::string> out;
  for (const WorldKind* world : catalogue.worlds)
    for (const WorldQuestion& one : world->questions)
      if (one.name == question) out.emplace_back(world->name);
  return out;
}

Expected<WorldAnswered> ask_world(const Run& run, const WorldAsk& ask) {
  if (ask.from && ask.to && *ask.from > *ask.to) return usage_error("--from is after --to");
  const auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  const WorldKind& world = *scenario->world.kind;
  const auto question = std::ranges::find(world.questions, ask.question, &WorldQuestion::name);
  if (question == world.questions.end()) return unknown_question(run, world, ask.question);
  const auto recorded = run.records_up_to(ask.at ? ask.at : ask.to, {.kinds = kRecordsOfQuestions});
  if (!recorded) return about_option(recorded.error(), ask.at ? "--at" : "--to");
  const SimTime from = ask.from.value_or(SimTime{});
  if (from > recorded->t)
    return usage_error(std::string("--from is after the end of ") +
                       (recorded->cut_off ? "the journal, " : "the run, ") + time_text(recorded->t));
  auto answer =
      question->ask({run.folder, *scenario, recorded->records, from, recorded->t, recorded->ended, ask.about});
  if (!answer) return answer.error();
  return WorldAnswered{*std::move(answer), from, recorded->t, recorded->cut_off ? run.cut_off_text("journal") : ""};
}

bool WorldRecords::wants(std::string_view, RecordKind kind) const {
  return std::ranges::find(kRecordsOfQuestions, kind) != kRecordsOfQuestions.end();
}

std::string world_text(const WorldAnswered& answered, std::size_t width) {
  const auto& [tables, notes] = answered.answer;
  std::string text = "up to " + time_text(answered.to) + answered.cut_off + ":\n";
  for (std::size_t i = 0; i < tables.size(); ++i) text += (i ? "\n" : "") + table_text(tables[i], width);
  for (std::size_t i = 0; i < notes.size(); ++i) text += (i ? "" : "\n") + notes[i] + '\n';
  return text;
}

Json world_json(const WorldAnswered& answered) {
  Json json{{"at_s", to_seconds(answered.to)}};
  if (answered.from > SimTime{}) json["from_s"] = to_seconds(answered.from);
  if (!answered.cut_off.empty()) json["cut_off"] = true;
  for (const Table& table : answered.answer.tables) json[table.key] = table_json(table);
  json["notes"] = answered.answer.notes;
  return json;
}

}  // namespace cxlab::lab
