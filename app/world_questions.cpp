// Questions that worlds declare (scenarios/question.h): a command of `cxlab` for each, printed in one way.

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/json_text.h"
#include "cx/base/number_text.h"
#include "lab/run.h"
#include "scenarios/question.h"

namespace cxlab::app {

namespace {

using Json = nlohmann::ordered_json;
using CellKind = Column::Kind;

struct WorldAsk {
  std::string name;  ///< of the question
  std::string run, about, sort;
  std::optional<double> at, from, to;
  bool json = false;
};

// --- Tables

std::string shown(const TableCell& cell, CellKind kind) {
  if (!cell.shown.empty()) return cell.shown;
  const auto number = [kind](double value) {
    switch (kind) {
      case CellKind::kTime: return time_text(value);
      case CellKind::kSeconds: return length_text(value);
      case CellKind::kShare: return fixed_text(100 * value, 1) + " %";
      default: return shortest_text(value);
    }
  };
  if (const auto* text = std::get_if<std::string>(&cell.value)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return std::to_string(*whole);
  if (const auto* value = std::get_if<double>(&cell.value)) return number(*value);
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value))
    return number(stretch->first) + '-' + number(stretch->second);
  return "-";
}

Json json_of(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell.value)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return *whole;
  if (const auto* value = std::get_if<double>(&cell.value)) return *value;
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value)) return {stretch->first, stretch->second};
  return nullptr;
}

/// How many columns a text takes on a terminal, of characters that take one each.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Lines of at most so many characters, broken at blanks.
std::vector<std::string> broken_at(const std::string& text, std::size_t width) {
  std::vector<std::string> out;
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find(' ', i), text.size());
    const std::string word = text.substr(i, end - i);
    if (!line.empty() && width_of(line) + 1 + width_of(word) > width) out.push_back(std::exchange(line, {}));
    line += (line.empty() ? "" : " ") + word;
    i = end + 1;
  }
  out.push_back(line);
  return out;
}

/// Columns of a terminal; otherwise the same everywhere.
std::size_t line_width() {
  constexpr std::size_t kLine = 180;
  winsize size{};
  if (isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return kLine;
}

constexpr std::size_t kBetween = 2;  ///< blanks between columns

/// How wide each column is drawn: as its longest text, but the last one gets what is left of the line, and other texts
/// are broken where that is less than a sentence needs.
std::vector<std::size_t> widths_of(const Table& table, std::size_t room) {
  constexpr std::size_t kSentence = 72, kNarrowest = 36, kNarrowCell = 16;
  const std::size_t columns = table.columns.size();
  std::vector<std::size_t> widths, least;
  for (const Column& column : table.columns) {
    widths.push_back(width_of(column.title));
    least.push_back(std::max(width_of(column.title), kNarrowCell));
  }
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::string text = shown(row[i], table.columns[i].kind);
      widths[i] = std::max(widths[i], width_of(text));
      for (const std::string& word : broken_at(text, 0)) least[i] = std::max(least[i], width_of(word));
    }
  if (table.columns.back().kind != CellKind::kText) return widths;
  const std::size_t wanted = std::min(widths.back(), kSentence);
  std::size_t before_last = 0;
  for (std::size_t i = 0; i + 1 < columns; ++i) before_last += widths[i] + kBetween;
  while (before_last + wanted > room) {
    std::size_t widest = columns;
    for (std::size_t i = 0; i + 1 < columns; ++i)
      if (table.columns[i].kind == CellKind::kText && widths[i] > least[i] &&
          (widest == columns || widths[i] > widths[widest]))
        widest = i;
    if (widest == columns) break;
    --widths[widest];
    --before_last;
  }
  widths.back() = before_last + kNarrowest < room ? room - before_last : kNarrowest;
  return widths;
}

std::string text_of(const Table& table) {
  const std::size_t columns = table.columns.size();
  const std::vector<std::size_t> widths = widths_of(table, line_width());
  std::string out;
  const auto add_row = [&](const auto& text_at) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t i = 0; i < columns; ++i) {
      cells.push_back(table.columns[i].kind == CellKind::kText ? broken_at(text_at(i), widths[i])
                                                               : std::vector<std::string>{text_at(i)});
      height = std::max(height, cells.back().size());
    }
    for (std::size_t k = 0; k < height; ++k) {
      for (std::size_t i = 0; i < columns; ++i) {
        const std::string text = k < cells[i].size() ? cells[i][k] : std::string();
        const std::string fill(widths[i] - std::min(widths[i], width_of(text)), ' ');
        out += table.columns[i].kind == CellKind::kText ? text + fill : fill + text;
        out += std::string(kBetween, ' ');
      }
      out.erase(out.find_last_not_of(' ') + 1);
      out += '\n';
    }
  };
  if (!table.title.empty()) out += table.title + ":\n";
  add_row([&](std::size_t i) { return table.columns[i].title; });
  for (const auto& row : table.rows) add_row([&](std::size_t i) { return shown(row[i], table.columns[i].kind); });
  if (table.rows.empty()) out += "none\n";
  return out;
}

Json json_of(const Table& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json one = Json::object();
    for (std::size_t i = 0; i < table.columns.size(); ++i) one[table.columns[i].key] = json_of(row[i]);
    rows.push_back(std::move(one));
  }
  return rows;
}

/// Orders the rows by that column: numbers from the greatest, texts from the first letter.
Status sort_by(const std::string& key, Table& table) {
  std::vector<std::string> keys;
  for (const Column& column : table.columns) keys.push_back(column.key);
  const auto found = std::ranges::find(keys, key);
  if (found == keys.end())
    return usage_error("--sort: there is no column '" + key + "'" + did_you_mean(key, keys) + "; there are " +
                       some_of(keys, keys.size()));
  const auto at = static_cast<std::size_t>(found - keys.begin());
  const bool text = table.columns[at].kind == CellKind::kText;
  std::ranges::stable_sort(table.rows, [&](const auto& a, const auto& b) {
    return text ? a[at].value < b[at].value : b[at].value < a[at].value;
  });
  return {};
}

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
    if (Status s = sort_by(ask.sort, given->tables.front()); !s) return fail(s.error());
  if (ask.json) {
    Json json{{"at_s", to_seconds(recorded->to)}};
    if (recorded->from > SimTime{}) json["from_s"] = to_seconds(recorded->from);
    if (recorded->cut_off) json["cut_off"] = true;
    for (const Table& table : given->tables) json[table.key] = json_of(table);
    json["notes"] = given->notes;
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  std::printf("up to %s%s:\n", time_text(recorded->to).c_str(),
              recorded->cut_off ? ", where the journal of the run is cut off" : "");
  for (std::size_t i = 0; i < given->tables.size(); ++i)
    std::printf("%s%s", i ? "\n" : "", text_of(given->tables[i]).c_str());
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
