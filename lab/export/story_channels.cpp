#include "lab/export/story_channels.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

// Of rcl_interfaces/msg/Log.
constexpr std::uint8_t kDebug = 10, kInfo = 20, kWarn = 30, kError = 40;

std::uint8_t level_of(std::string_view word) {
  if (word == "debug") return kDebug;
  if (word == "warn" || word == "warning") return kWarn;
  return word == "error" || word == "critical" ? kError : kInfo;
}

/// The text in brackets at the front of `rest`, which is taken away with a blank behind it.
std::optional<std::string_view> bracket(std::string_view& rest) {
  const std::size_t end = rest.find(']');
  if (!rest.starts_with('[') || end == rest.npos) return std::nullopt;
  const std::string_view inside = rest.substr(1, end - 1);
  rest.remove_prefix(end + 1);
  if (rest.starts_with(' ')) rest.remove_prefix(1);
  return inside;
}

/// Adds a word behind a blank, unless there is none.
void add_word(std::string& text, std::string_view word) {
  if (!word.empty()) (text.empty() ? text : text += ' ') += word;
}

}  // namespace

std::string phase_of(const RecordValue& skill) {
  std::string out(skill.text("phase"));
  if (const std::string_view who = skill.text("for"); !who.empty()) (out += " for ") += who;
  return out;
}

std::string state_after(const RecordValue& skill) {
  const std::string_view event = skill.text("event");
  if (event == "end" || event == "refused") return "idle";
  std::string out(skill.text("skill"));
  add_word(out, phase_of(skill));
  add_word(out, skill.text("target"));
  return out;
}

std::string event_of(const RecordValue& data) {
  for (const char* const key : {"event", "fault", "what", "op", "template", "rule"})
    if (const std::string_view word = data.text(key); !word.empty()) return std::string(word);
  return "";
}

Expected<StoryChannels> StoryChannels::create(RosBag& bag, const Run& run, const Stretch& stretch) {
  StoryChannels out(bag, stretch);
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(run.folder / "logs", none))
    if (entry.path().extension() == ".log" && !entry.is_symlink() && is_file(entry.path()))
      files.push_back(entry.path());
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    const auto text = read_file(file);
    if (!text) return text.error();
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) {
      std::string_view rest = line;
      const auto time = bracket(rest);
      const auto seconds = time ? read_number<double>(*time) : std::nullopt;
      const auto logger = seconds ? bracket(rest) : std::nullopt;
      const auto level = logger ? bracket(rest) : std::nullopt;
      if (level)
        out.lines_.push_back({from_seconds(*seconds), std::string(*logger), std::string(rest), level_of(*level)});
      else if (!out.lines_.empty())  // a line of a text that has several
        out.lines_.back().text += '\n' + line;
    }
  }
  std::ranges::stable_sort(out.lines_, {}, &Line::t);
  return out;
}

bool StoryChannels::wants(RecordKind kind) const {
  return kind == RecordKind::kSkill || kind == RecordKind::kReferee || kind == RecordKind::kDecision ||
         kind == RecordKind::kControl || kind == RecordKind::kError;
}

Status StoryChannels::hear(const JournalRecord& record) {
  put_lines_before(record.t);
  if (!stretch_.has(record.t)) return {};
  if (record.kind == RecordKind::kSkill)
    put_skill(record);
  else
    put_event(record);
  return {};
}

void StoryChannels::put_skill(const JournalRecord& record) {
  const RecordValue& data = record.data;
  bus::Message message = bag_.make("cxlab_msgs/msg/Skill");
  set_stamp(message->nested("stamp"), record.t);
  for (const char* const key : {"robot", "skill", "target", "event", "phase"}) message->set(key, data.text(key));
  message->set("waits_for", data.text("for"));
  message->set("state", state_after(data)).set("code", data.integer("code"));
  message->set("error", data.text(data.text("event") == "refused" ? "reason" : "error"));
  message->set("cancelled", data.flag("cancelled")).set("duration_s", data.real("duration_s"));
  bag_.put("/cxlab/skills/" + topic_part(data.text("robot")), record.t, message);
}

void StoryChannels::put_event(const JournalRecord& record) {
  const RecordValue& data = record.data;
  bus::Message message = bag_.make("cxlab_msgs/msg/Event");
  set_stamp(message->nested("stamp"), record.t);
  message->set("stream", record.stream).set("n", static_cast<std::int64_t>(record.n));
  message->set("kind", to_string(record.kind)).set("event", event_of(data)).set("data", to_json(data));
  for (const JournalRecord::Cause& cause : record.causes)
    message->append_text("causes", cause.stream + ':' + std::to_string(cause.n));
  bag_.put("/cxlab/events", record.t, message);

  if (record.kind == RecordKind::kReferee && data.find("team") && data.find("total")) {
    bus::Message points = bag_.make("cxlab_msgs/msg/Points");
    set_stamp(points->nested("stamp"), record.t);
    points->set("team", data.text("team")).set("kind", data.text("kind"));
    for (const char* const key : {"points", "total", "order"}) points->set(key, data.integer(key));
    bag_.put("/cxlab/points/" + topic_part(data.text("team")), record.t, points);
  } else if (record.kind == RecordKind::kDecision && data.find("slots")) {
    std::string text;
    for (const std::string& slot : slot_texts(data)) text += (text.empty() ? "" : ": ") + slot;
    put_log({record.t, record.stream, text, kInfo});
  } else if (record.kind == RecordKind::kError) {
    put_log({record.t, record.stream, std::string(data.text("message")), kError}, &data);
  }
}

void StoryChannels::put_lines_before(SimTime t) {
  for (; next_line_ < lines_.size() && lines_[next_line_].t < t; ++next_line_)
    if (stretch_.has(lines_[next_line_].t)) put_log(lines_[next_line_]);
}

void StoryChannels::put_log(const Line& line, const RecordValue* place) {
  bus::Message message = bag_.make("rcl_interfaces/msg/Log");
  set_stamp(message->nested("stamp"), line.t);
  message->set("level", static_cast<std::int64_t>(line.level)).set("name", line.logger).set("msg", line.text);
  if (place)
    message->set("file", place->text("file"))
        .set("function", place->text("rule"))
        .set("line", std::clamp<std::int64_t>(place->integer("line"), 0, INT32_MAX));
  bag_.put("/rosout", line.t, message);
}

}  // namespace cxlab::lab
