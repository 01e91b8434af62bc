#include "lab/report.h"

#include <algorithm>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/journal_reader.h"
#include "cx/journal/run_folder.h"
#include "lab/base64.h"
#include "lab/happenings.h"
#include "lab/run_page.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

namespace {

/// The decisions of agents.
Json decisions_of(const std::vector<JournalRecord>& records) {
  Json out = Json::array();
  for (const JournalRecord& record : records)
    if (record.kind == RecordKind::kDecision && record.stream.starts_with("env/"))
      out.push_back({{"t", to_seconds(record.t)}, {"by", record.stream.substr(4)}, {"slots", slot_texts(record.data)}});
  return out;
}

// --- What the page adds to that of the world

constexpr std::size_t kMostEvents = 20'000;  ///< of each kind

std::string joined(const std::vector<std::string>& texts, std::size_t from) {
  std::string out;
  for (std::size_t i = from; i < texts.size(); ++i) (out += i > from ? ", " : "") += texts[i];
  return out;
}

/// Kinds that each page has.
void add_kinds(RunPage& page) {
  page.kinds.push_back({"decision", "#8a6fc0", "#6a4fa3"});
  page.kinds.push_back({"error", "#a50f15", "#a50f15"});
  page.kinds.push_back({"warning", "#c27c00", "#8f5b00"});
}

/// What happened, what agents decided, and warnings of the run, which have no time.
void add_events(const Scenario& scenario, const std::vector<JournalRecord>& records, const Result& result,
                RunPage& page) {
  std::size_t decisions = 0, errors = 0;
  for (const JournalRecord& record : records) {
    if (record.kind == RecordKind::kError && ++errors > kMostEvents) continue;
    tell(scenario, record, page.events);
    if (record.kind != RecordKind::kDecision || !record.stream.starts_with("env/")) continue;
    if (++decisions > kMostEvents) continue;
    const std::vector<std::string> slots = slot_texts(record.data);
    page.events.push_back({to_seconds(record.t), "decision", record.stream.substr(4),
                           slots.empty() ? "" : slots.front(), joined(slots, 1)});
  }
  for (const auto& [all, what] : {std::pair(decisions, " more decisions"), {errors, " more errors"}})
    if (all > kMostEvents)
      page.events.push_back(
          {-1, "warning", "", std::to_string(all - kMostEvents) + std::string(what) + ", in journal.jsonl"});
  for (const std::string& warning : result.all_warnings()) page.events.push_back({-1, "warning", "", warning});
  if (result.reason) page.events.push_back({to_seconds(result.sim_time), "error", "", result.reason->text()});
  std::ranges::stable_sort(page.events, {}, &PageEvent::t);
}

/// The fields of a report that the page shows without its scripts, and the tables of its world.
Json head_of(const RunPage& page, const Json& report) {
  Json head;
  for (const char* key : {"result", "reason", "files", "film", "pictures"}) head[key] = report[key];
  head["tables"] = tables_of(page);
  head["kinds"] = Json::array();
  for (const PageKind& kind : page.kinds) head["kinds"].push_back({{"name", kind.name}, {"ink", kind.ink}});
  return head;
}

Expected<RunPage> page_of_world(const Scenario& scenario, const AskedRun& asked, const Result& result) {
  return scenario.world.kind->page ? scenario.world.kind->page(asked, result) : RunPage();
}

Status write_page(const Played& played, const std::vector<JournalRecord>& records, RunPage page, const Json& report) {
  const std::filesystem::path& folder = played.folder;
  Json head = head_of(page, report);
  // The page is whole without its folder.
  for (std::size_t i = 0; i < played.pictures.size(); ++i)
    if (const auto bytes = read_file(played.pictures[i].file)) head["pictures"][i]["png"] = base64(*bytes);
  add_kinds(page);
  add_events(played.scenario, records, played.result, page);
  const auto scene = read_file(folder / "scene.bin");
  const auto html =
      run_page(head, {run_data(page, to_seconds(played.result.sim_time)), scene ? *scene : std::string()});
  if (!html) return html.error();
  return replace_file(folder / "index.html", *html);
}

/// result.json of a recorded run, as far as pages of worlds and their events read it.
Result result_of(const Run& run, const Scenario& scenario, const Json& json) {
  Result result = initial_result(scenario);
  const Json common = parse_json(Result().to_json());
  for (const auto& [key, value] : json.items())
    if (!common.contains(key)) result.set(key, json_text(value));
  result.sim_time = run.sim_time;
  result.reason = run.failure;
  if (const auto warnings = json.find("warnings"); warnings != json.end() && warnings->is_array())
    for (const Json& warning : *warnings)
      if (warning.is_string()) result.warnings.push_back(warning);
  return result;
}

}  // namespace

/// Files that a person reads, relative to the run's folder.
Json readable_files(const std::filesystem::path& folder) {
  std::error_code ignored;
  std::vector<std::string> logs;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "logs", ignored))
    if (!entry.is_symlink()) logs.push_back("logs/" + entry.path().filename().string());
  std::ranges::sort(logs);
  Json out = {"result.json", "report.json", "manifest.json", "journal.jsonl"};
  for (std::string& log : logs) out.push_back(std::move(log));
  return out;
}

Expected<PageParts> page_of_recorded(const Run& run) {
  const auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  Json report{{"result", parse_json(run.result)},
              {"reason", run.failure ? run.failure->text() : ""},
              {"files", readable_files(run.folder)},
              {"film", ""},
              {"pictures", Json::array()}};
  const Result result = result_of(run, *scenario, report["result"]);
  auto recorded = run.records_up_to(std::nullopt, {.kinds = kRecordsOfQuestions});
  // A run without a journal has a page without its events.
  if (!recorded) recorded = Run::RecordsUpTo{{}, run.sim_time, run.finished, true};
  auto page = page_of_world(*scenario, {run.folder, *scenario, recorded->records, {}, recorded->t, recorded->ended, {}},
                            result);
  if (!page) return page.error();
  PageParts parts;
  parts.head = head_of(*page, report);
  add_kinds(*page);
  add_events(*scenario, recorded->records, result, *page);
  SimTime end = std::max(recorded->t, run.sim_time);
  if (const auto scenes = run.scenes(); scenes && !run.finished) end = std::max(end, scenes->end());
  if (run.unfinished) parts.head["unfinished"] = to_seconds(end);
  parts.run = run_data(*page, to_seconds(end));
  return parts;
}

Status write_report(const Played& played) {
  const std::filesystem::path& folder = played.folder;
  if (folder.empty() || played.result.journal_hash.empty()) return {};
  Json report;
  report["result"] = parse_json(played.result.to_json());
  report["reason"] = played.result.reason ? played.result.reason->text() : "";
  const auto records = read_journal(folder / "journal.jsonl", {.kinds = kRecordsOfQuestions});
  if (!records) return records.error();
  constexpr bool kEnded = true;  // by itself or not: no record follows
  auto page = page_of_world(played.scenario,
                            {folder, played.scenario, *records, {}, played.result.sim_time, kEnded, {}}, played.result);
  if (!page) return page.error();
  for (const Result::Section& section : page->data) report[section.key] = parse_json(section.json);
  report["decisions"] = decisions_of(*records);
  if (std::error_code none; is_file(folder / "journal.jsonl"))
    report["journal_bytes"] = std::filesystem::file_size(folder / "journal.jsonl", none);
  report["files"] = readable_files(folder);
  report["film"] = played.film.empty() ? ""
                                       : std::filesystem::proximate(std::filesystem::absolute(played.film),
                                                                    std::filesystem::absolute(folder))
                                             .generic_string();
  report["pictures"] = Json::array();
  for (const Picture& picture : played.pictures)
    report["pictures"].push_back({{"caption", picture.caption}, {"file", picture.file.lexically_relative(folder)}});
  if (Status s = replace_file(folder / "report.json", json_text(report, 1) + '\n'); !s) return s;
  return write_page(played, *records, *std::move(page), report);
}

}  // namespace cxlab::lab
