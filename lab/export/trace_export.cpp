#include "lab/export/trace_export.h"

#include <algorithm>
#include <set>

#include "cx/journal/journal_reader.h"
#include "lab/export/story_channels.h"
#include "lab/versions.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 18;

double microseconds(SimTime t) { return static_cast<double>(t.count()) / 1e3; }

/// The fields of a record; what does not read as JSON is left out.
Json args_of(const RecordValue& data) {
  Json args = parse_json(to_json(data));
  return args.is_object() ? args : Json::object();
}

}  // namespace

TraceExport::TraceExport(const Run& run, const Stretch& stretch, AppendFile file)
    : stretch_(stretch), end_(std::min(stretch.to, run.sim_time)), file_(std::move(file)), trace_(text_) {}

Expected<std::unique_ptr<TraceExport>> TraceExport::create(const Run& run, const Stretch& stretch,
                                                           const std::filesystem::path& path) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<TraceExport>(new TraceExport(run, stretch, *std::move(file)));
}

bool TraceExport::wants(RecordKind kind) const {
  return kind == RecordKind::kFire || kind == RecordKind::kSkill || kind == RecordKind::kReferee ||
         kind == RecordKind::kDecision || kind == RecordKind::kControl || kind == RecordKind::kError;
}

Status TraceExport::flush() {
  if (text_.size() < kFlushBytes) return {};
  Status status = file_.append(text_);
  text_.clear();
  return status;
}

void TraceExport::put_span(const std::string& process, const std::string& thread, const Open& open,
                           const std::string& category, SimTime end) {
  const SimTime begin = std::max(open.begin, stretch_.from);
  end = std::min(end, stretch_.to);
  if (end < begin) return;
  trace_.span(trace_.thread(process, thread), open.name, category, microseconds(begin), microseconds(end - begin),
              open.args);
}

Status TraceExport::hear(const JournalRecord& record) {
  reaches(record.t);
  if (record.kind == RecordKind::kReferee) put_window(record);
  if (record.kind == RecordKind::kSkill) {
    hear_skill(record);
  } else if (stretch_.has(record.t)) {
    const double t = microseconds(record.t);
    const RecordValue& data = record.data;
    switch (record.kind) {
      case RecordKind::kFire: {
        const std::string module(data.text("module")), rule(data.text("rule"));
        const std::string name = module.empty() ? rule : module + "::" + rule;
        trace_.mark(trace_.thread(record.stream, name), name, "firing", t, {{"n", record.n}});
        break;
      }
      case RecordKind::kReferee: hear_referee(record); break;
      default: {
        const std::string kind(to_string(record.kind));
        trace_.mark(trace_.thread(record.stream, kind), event_of(data), kind, t, args_of(data));
      }
    }
  }
  return flush();
}

void TraceExport::end_phase(const std::string& stream, const std::string& robot, SimTime t) {
  const auto phase = phases_.find(stream);
  if (phase == phases_.end()) return;
  put_span("skills", robot, phase->second.second, "phase", t);
  phases_.erase(phase);
}

void TraceExport::hear_skill(const JournalRecord& record) {
  const RecordValue& data = record.data;
  const std::string robot(data.text("robot")), event(data.text("event"));
  end_phase(record.stream, robot, record.t);
  if (event == "start") {
    skills_[record.stream] = {robot,
                              {std::string(data.text("skill")) + ' ' + std::string(data.text("target")), record.t}};
  } else if (event == "phase") {
    phases_[record.stream] = {robot, {phase_of(data), record.t}};
  } else if (event == "end") {
    const auto skill = skills_.find(record.stream);
    if (skill == skills_.end()) return;
    skill->second.second.args = args_of(data);
    put_span("skills", robot, skill->second.second, "skill", record.t);
    skills_.erase(skill);
  } else if (stretch_.has(record.t)) {
    trace_.mark(trace_.thread("skills", robot), event, "skill", microseconds(record.t), args_of(data));
  }
}

void TraceExport::put_window(const JournalRecord& record) {
  const RecordValue& data = record.data;
  if (event_of(data) == "phase" && data.text("phase") == "PRODUCTION") production_ = record.t;
  if (!data.find("order") || !data.find("begin") || !data.find("end")) return;
  Open window{std::string(data.text("product")), production_ + from_seconds(data.real("begin")), args_of(data)};
  put_span("orders", "order " + std::to_string(data.integer("order")), window, "order",
           production_ + from_seconds(data.real("end")));
}

void TraceExport::hear_referee(const JournalRecord& record) {
  const RecordValue& data = record.data;
  const std::string event = event_of(data);
  if (data.find("order") && event == "delivery") {
    trace_.mark(trace_.thread("orders", "order " + std::to_string(data.integer("order"))), event, "order",
                microseconds(record.t), args_of(data));
  }
  if (data.find("team") && data.find("total"))
    trace_.figure(trace_.thread("points", "points"), std::string(data.text("team")), microseconds(record.t),
                  data.integer("total"));
  trace_.mark(trace_.thread(record.stream, event), event, "referee", microseconds(record.t), args_of(data));
}

Status TraceExport::see(const Scene& scene) {
  reaches(scene.t);
  std::set<EntityId> there;
  const auto end_of = [&](const State& state) { put_span(state.kind, state.name, state.open, "state", scene.t); };
  for (const Entity& entity : scene.entities) {
    if (entity.state.empty()) continue;
    there.insert(entity.id);
    const auto [known, is_new] = states_.try_emplace(entity.id);
    State& state = known->second;
    if (!is_new && state.open.name == entity.state) continue;
    if (!is_new) end_of(state);
    state = {entity.kind, entity.name, {entity.state, scene.t}};
  }
  for (auto at = states_.begin(); at != states_.end();) {
    if (there.contains(at->first)) {
      ++at;
      continue;
    }
    end_of(at->second);
    at = states_.erase(at);
  }
  return flush();
}

Status TraceExport::close() {
  for (const auto& [stream, phase] : phases_) put_span("skills", phase.first, phase.second, "phase", end_);
  for (const auto& [stream, skill] : skills_) put_span("skills", skill.first, skill.second, "skill", end_);
  for (const auto& [id, state] : states_) put_span(state.kind, state.name, state.open, "state", end_);
  trace_.end({{"displayTimeUnit", "ms"}, {"otherData", {{"clock", "simulated time"}, {"version", cxlab_version()}}}});
  if (Status s = file_.append(text_); !s) return s;
  return file_.close();
}

}  // namespace cxlab::lab
