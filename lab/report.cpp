#include "lab/report.h"

#include <algorithm>
#include <cmath>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/journal_reader.h"
#include "cx/journal/run_folder.h"
#include "lab/page.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

namespace {

std::string base64(const std::filesystem::path& file) {
  static constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto read = read_file(file);
  const std::string bytes = read ? *read : std::string();
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k)
      value = value << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kAlphabet[value >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

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

/// The decisions of agents.
Json decisions_of(const std::vector<JournalRecord>& records) {
  Json out = Json::array();
  for (const JournalRecord& record : records)
    if (record.kind == RecordKind::kDecision && record.stream.starts_with("env/"))
      out.push_back({{"t", to_seconds(record.t)}, {"by", record.stream.substr(4)}, {"slots", slot_texts(record.data)}});
  return out;
}

// --- What the world shows

/// A whole number as one, so that it is shown without a fraction.
Json number(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return value;
}

std::string_view to_string(PageBar::Shape shape) {
  switch (shape) {
    case PageBar::Shape::kAlert: return "alert";
    case PageBar::Shape::kInset: return "inset";
    case PageBar::Shape::kStrip: return "strip";
    case PageBar::Shape::kBar: break;
  }
  return "bar";
}

Json json_of(const PageTable& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (const PageCell& cell : row) cells.push_back({{"text", cell.text}, {"bold", cell.bold}, {"kind", cell.kind}});
    rows.push_back(std::move(cells));
  }
  return {{"title", table.title}, {"columns", table.columns}, {"rows", std::move(rows)}, {"note", table.note}};
}

Json json_of(const PageChart& chart) {
  Json lines = Json::array();
  for (const PageLine& line : chart.lines) {
    Json steps = Json::array();
    for (const auto& [t, value] : line.steps) steps.push_back({t, number(value)});
    lines.push_back({{"kind", line.kind}, {"steps", std::move(steps)}});
  }
  return {{"title", chart.title}, {"lines", std::move(lines)}};
}

Json json_of(const PageLane& lane) {
  Json bars = Json::array(), marks = Json::array();
  for (const PageBar& bar : lane.bars)
    bars.push_back({{"shape", to_string(bar.shape)},
                    {"kind", bar.kind},
                    {"begin", bar.begin},
                    {"end", bar.end},
                    {"text", bar.text},
                    {"remark", bar.remark}});
  for (const PageMark& mark : lane.marks) marks.push_back({{"kind", mark.kind}, {"t", mark.t}, {"text", mark.text}});
  return {{"name", lane.name}, {"bars", std::move(bars)}, {"marks", std::move(marks)}};
}

Json json_of(const PageLanes& lanes) {
  Json key = Json::array(), all = Json::array();
  for (const PageLanes::Key& one : lanes.key) key.push_back({{"kind", one.kind}, {"text", one.text}});
  for (const PageLane& lane : lanes.lanes) all.push_back(json_of(lane));
  return {{"title", lanes.title}, {"key", std::move(key)}, {"lanes", std::move(all)}};
}

Json json_of(const RunPage& page) {
  Json kinds = Json::array(), shades = Json::array(), parts = Json::array();
  for (const PageKind& kind : page.kinds)
    kinds.push_back({{"name", kind.name}, {"fill", kind.fill}, {"ink", kind.ink}});
  for (const PageShade& shade : page.shades)
    shades.push_back({{"kind", shade.kind}, {"begin", shade.begin}, {"end", shade.end}, {"text", shade.text}});
  for (const auto& part : page.parts) parts.push_back(std::visit([](const auto& one) { return json_of(one); }, part));
  return {{"kinds", std::move(kinds)}, {"shades", std::move(shades)}, {"parts", std::move(parts)}};
}

Expected<RunPage> page_of_world(const Played& played, const std::vector<JournalRecord>& records) {
  const WorldKind& world = *played.scenario.world.kind;
  if (!world.page) return RunPage();
  const Result& result = played.result;
  const bool ended = result.status == RunStatus::kCompleted;
  return world.page({played.folder, played.scenario, records, {}, result.sim_time, ended, {}}, result);
}

}  // namespace

Status write_report(const Played& played) {
  const std::filesystem::path& folder = played.folder;
  if (folder.empty() || played.result.journal_hash.empty()) return {};
  Json report;
  report["result"] = parse_json(played.result.to_json());
  report["reason"] = played.result.reason ? played.result.reason->text() : "";
  const auto records = read_journal(folder / "journal.jsonl", {.kinds = kRecordsOfQuestions});
  if (!records) return records.error();
  const auto of_world = page_of_world(played, *records);
  if (!of_world) return of_world.error();
  for (const Result::Section& section : of_world->data) report[section.key] = parse_json(section.json);
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
  const auto text = [&](int indent) { return json_text(report, indent); };
  if (Status s = replace_file(folder / "report.json", text(1) + '\n'); !s) return s;
  report["page"] = json_of(*of_world);
  // The page is whole without its folder.
  for (std::size_t i = 0; i < played.pictures.size(); ++i)
    report["pictures"][i]["png"] = base64(played.pictures[i].file);
  auto page = render_page("run.html", text(-1));
  if (!page) return page.error();
  return replace_file(folder / "index.html", *page);
}

}  // namespace cxlab::lab
