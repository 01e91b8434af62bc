#include "lab/report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "cx/base/file.h"
#include "cx/base/json_text.h"
#include "cx/journal/journal_reader.h"
#include "cx/journal/run_folder.h"
#include "lab/page.h"

namespace cxlab::lab {

namespace {

using Json = nlohmann::ordered_json;

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

/// What has begun and not ended yet, by robot.
using Open = std::map<std::string, Json, std::less<>>;

void end(Open& open, std::string_view robot, double t, const char* state, Json& out) {
  const auto found = open.find(robot);
  if (found == open.end()) return;
  found->second["end"] = t;
  if (state) found->second["state"] = state;
  out.push_back(std::move(found->second));
  open.erase(found);
}

/// How a robot left the field, came back, or did not.
void note_duty(Open& away, const RecordValue& data, double t, Json& out) {
  const std::string robot(data.text("robot"));
  const std::string_view state = data.text("state");
  if (state == "begin")
    away[robot] = {{"robot", robot}, {"cause", data.text("cause")}, {"state", "maintenance"}, {"begin", t}};
  else if (state == "end")
    end(away, robot, t, nullptr, out);
  else if (state == "disqualified") {
    end(away, robot, t, nullptr, out);
    away[robot] = {{"robot", robot}, {"cause", data.text("cause")}, {"state", "disqualified"}, {"begin", t}};
  }
}

/// Adds what the journal says: decisions of agents, skills, pieces in grippers, points, robots off the field, faults,
/// pauses.
Status read_story(const std::filesystem::path& journal, double last, Json& report) {
  const auto records = read_journal(
      journal, {.kinds = {RecordKind::kSkill, RecordKind::kReferee, RecordKind::kControl, RecordKind::kDecision}});
  if (!records) return records.error();
  Json skills = Json::array(), holds = Json::array(), scores = Json::array();
  Json off_field = Json::array(), faults = Json::array(), pauses = Json::array();
  Json decisions = Json::array();
  std::optional<double> paused;
  Open working, holding, away;
  for (const JournalRecord& record : *records) {
    const std::string_view event = record.data.text("event");
    const std::string robot(record.data.text("robot"));
    const double t = to_seconds(record.t);
    if (record.kind == RecordKind::kDecision) {
      if (record.stream.starts_with("env/"))
        decisions.push_back({{"t", t}, {"by", record.stream.substr(4)}, {"slots", slot_texts(record.data)}});
    } else if (record.kind == RecordKind::kControl) {
      if (!record.data.text("fault").empty())
        faults.push_back({{"t", t},
                          {"kind", record.data.text("fault")},
                          {"at", robot.empty() ? record.data.text("machine") : std::string_view(robot)}});
    } else if (record.kind == RecordKind::kSkill) {
      if (event == "start")
        working[robot] = {{"robot", robot},
                          {"skill", record.data.text("skill")},
                          {"target", record.data.text("target")},
                          {"begin", t}};
      else if (event == "end")
        end(working, robot, t, record.data.integer("code") == 0 ? "succeeded" : "failed", skills);
    } else if (event == "maintenance") {
      note_duty(away, record.data, t, off_field);
    } else if (event == "state") {
      if (record.data.text("state") == "PAUSED")
        paused = t;
      else if (paused)
        pauses.push_back({{"begin", *std::exchange(paused, std::nullopt)}, {"end", t}});
    } else if (event == "score") {
      scores.push_back({{"team", record.data.text("team")},
                        {"kind", record.data.text("kind")},
                        {"t", t},
                        {"points", record.data.integer("points")}});
    } else if (event == "piece") {
      if (record.data.text("from") == "gripper") end(holding, record.data.text("from_name"), t, nullptr, holds);
      const std::string to(record.data.text("to_name"));
      if (record.data.text("to") == "gripper") holding[to] = {{"robot", to}, {"begin", t}};
    }
  }
  while (!working.empty()) end(working, std::string(working.begin()->first), last, "running", skills);
  while (!holding.empty()) end(holding, std::string(holding.begin()->first), last, nullptr, holds);
  while (!away.empty()) end(away, std::string(away.begin()->first), last, nullptr, off_field);
  if (paused) pauses.push_back({{"begin", *paused}, {"end", last}});
  report["skills"] = std::move(skills);
  report["holds"] = std::move(holds);
  report["scores"] = std::move(scores);
  report["off_field"] = std::move(off_field);
  report["faults"] = std::move(faults);
  report["pauses"] = std::move(pauses);
  report["decisions"] = std::move(decisions);
  return {};
}

}  // namespace

Status write_report(const Played& played) {
  const std::filesystem::path& folder = played.folder;
  if (folder.empty() || played.result.journal_hash.empty()) return {};
  Json report;
  report["result"] = Json::parse(played.result.to_json());
  report["reason"] = played.result.reason ? played.result.reason->text() : "";
  if (Status s = read_story(folder / "journal.jsonl", to_seconds(played.result.sim_time), report); !s) return s;
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
  // The page is whole without its folder.
  for (std::size_t i = 0; i < played.pictures.size(); ++i)
    report["pictures"][i]["png"] = base64(played.pictures[i].file);
  auto page = render_page("run.html", text(-1));
  if (!page) return page.error();
  return replace_file(folder / "index.html", *page);
}

}  // namespace cxlab::lab
