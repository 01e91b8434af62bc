#include "lab/run.h"
#include "cx/base/json.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/remedy.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/input_log.h"
#include "cx/journal/run_folder.h"
#include "lab/json_fields.h"
#include "lab/session.h"
#include "lab/versions.h"
#include "scenarios/seated_agent.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

constexpr const char* kAfterTheEnd = "after_the_end";

SimTime end_of_log(const fs::path& inputs) {
  auto log = InputLogReader::open(inputs);
  if (!log) return {};
  while (log->next()) {
  }
  return std::max(SimTime::zero(), log->reached());
}

Status read_result(const Json& json, Run& run) {
  run.tier = json.at("tier") == "timed" ? Tier::kTimed : Tier::kPhysics;
  run.status = json.at("status").get<std::string>();
  const double end = json.at("sim_time_s").get<double>();
  if (!(end >= 0 && end <= to_seconds(kLongestRun)))
    return input_error("not the result of a run: sim_time_s: " +
                       found_expected(general_text(end, 9), "s from 0 to 1e9"));
  run.sim_time = from_seconds(end);
  run.ticks = json.at("ticks").get<std::int64_t>();
  run.stream_hashes = json.at("stream_hashes").get<std::map<std::string, std::string>>();
  if (!json.at("physics_hash").is_null()) run.physics_hash = json.at("physics_hash").get<std::string>();
  run.finished = !run.stream_hashes.empty();
  const Json& reason = json.at("reason");
  run.unfinished = reason.is_object() && reason.value("code", "") == "unfinished";  // of unfinished_result
  if (run.status == "failed" && reason.is_object() && !run.unfinished) {
    const auto text = [&](const char* key) {
      return reason.contains(key) && reason[key].is_string() ? reason[key].get<std::string>() : std::string();
    };
    const bool has_line = reason.contains("line") && reason["line"].is_number_integer();
    run.failure =
        Error{ErrorKind::kRun, text("message"), text("file"), has_line ? reason["line"].get<int>() : 0, text("code")};
  }
  for (const Json& error : json.at("rule_errors"))
    if (error.at("side") == "load")
      run.not_loaded.try_emplace(std::string(without_module(error.at("rule").get_ref<const std::string&>())),
                                 input_error(error.at("message"), error.value("file", ""), error.value("line", 0)));
  return {};
}

}  // namespace

Expected<Run> Run::open(const fs::path& folder, const Catalogue& catalogue, bool trust_programs) {
  if (!is_folder(folder)) return input_error("there is no folder of a run", folder.string());
  if (!path_exists(folder / "manifest.json"))
    return input_error("is not the folder of a run: there is no manifest.json in it", folder.string());
  Run run;
  run.folder = folder;
  run.catalogue = &catalogue;
  auto manifest = Manifest::read(folder);
  if (!manifest) return manifest.error();
  run.manifest = *std::move(manifest);
  run.manifest.spec.programs = trust_programs;
  for (std::string& prefix : run.manifest.spec.prefixes) prefix = run.found(prefix).string();
  const fs::path file = folder / "result.json";
  auto text = read_file(file);
  if (!text) return text.error();
  run.result = *std::move(text);
  const auto result = parse_object(run.result, file);
  if (!result) return result.error();
  try {
    if (Status s = read_result(*result, run); !s) return input_error(s.error().message, file.string());
  } catch (const Json::exception& e) {
    return input_error(std::string("not the result of a run: ") + without_code(e), file.string());
  }
  return run;
}

std::vector<std::string> Run::changed_surroundings() const {
  std::vector<std::string> out;
  const auto compare = [&out](const std::map<std::string, std::string>& then, const auto& now) {
    for (const auto& [name, value] : now)
      if (const auto old = then.find(name); old == then.end() || old->second != value)
        out.push_back(name + ": " + (old == then.end() ? "not known" : old->second) + ", now " + value);
  };
  compare(manifest.versions, lab::versions());
  compare(manifest.machine, lab::machine());
  return out;
}

fs::path Run::found(const fs::path& then) const {
  if (!then.is_absolute() || manifest.out.empty() || path_exists(then)) return then;
  const fs::path here = fs::absolute(folder).lexically_normal();
  const fs::path moved = (here / then.lexically_relative(manifest.out)).lexically_normal();
  return path_exists(moved) ? moved : then;
}

Expected<Scenario> Run::scenario() const {
  auto files = StoredFiles::open(folder);
  if (!files) return files.error();
  auto text = files->read("scenario.yaml");
  if (!text) return text.error();
  auto scenario = Scenario::parse(*text, found(manifest.scenario_file()), *catalogue,
                                  {manifest.overrides.begin(), manifest.overrides.end()});
  if (!scenario) return scenario.error();
  for (auto& [key, file] : scenario->world_files)
    if (const auto then = manifest.world_files.find(key); then != manifest.world_files.end())
      file.path = found(then->second);
  if (const auto then = manifest.bag.find("file"); then != manifest.bag.end())
    scenario->bag.file = found(then->second).string();
  const auto find = [this](auto& name) { name = found(name).string(); };
  const auto find_packages = [&](std::map<std::string, PackageSpec>& packages) {
    for (auto& [name, package] : packages) find(package.folder);
  };
  find_packages(scenario->packages);
  for (AgentSpec& agent : scenario->agents) {
    find(agent.config);
    find_packages(agent.packages);
  }
  return scenario;
}

Expected<JournalReader> Run::journal() const {
  if (manifest.spec.journal == JournalLevel::kNone)
    return input_error("the run was recorded without a journal (--journal none), which this question reads",
                       folder.string());
  const fs::path file = folder / "journal.jsonl";
  if (!is_file(file)) return input_error("there is no journal.jsonl in the folder of the run", folder.string());
  return JournalReader::open(file);
}

Expected<std::vector<JournalRecord>> Run::records(const RecordFilter& filter) const {
  auto reader = journal();
  if (!reader) return reader.error();
  return reader->all(filter);
}

Expected<Run::RecordsUpTo> Run::records_up_to(std::optional<SimTime> t, const RecordFilter& filter) const {
  auto all = records(filter);
  if (!all) return all.error();
  RecordsUpTo out;
  SimTime last{};
  for (const JournalRecord& record : *all) last = std::max(last, record.t);
  if (t)
    if (Status s = reaches(*t, finished ? SimTime{} : last); !s) return s.error();
  const bool whole = has_whole_journal();
  const SimTime end = whole ? sim_time : last;
  out.cut_off = !whole && t.value_or(end) >= end;
  out.t = std::min(t.value_or(end), end);
  out.ended = whole && out.t == end;
  for (JournalRecord& record : *all)
    if (record.t <= out.t) out.records.push_back(std::move(record));
  return out;
}

Expected<std::vector<Seat>> Run::seats() const {
  if (manifest.seats.empty()) return std::vector<Seat>();
  return recorded_seats(folder / "inputs.bin");
}

Expected<SceneReader> Run::scenes() const {
  const fs::path file = folder / "scene.bin";
  if (!is_file(file) && manifest.spec.journal == JournalLevel::kNone)
    return input_error("the run was recorded without a journal (--journal none), and thus without a scene",
                       folder.string());
  if (!is_file(file))
    return input_error("there is no scene.bin in the folder of the run, as in an empty world", folder.string());
  return SceneReader::open(file);
}

Expected<Run::SceneAt> Run::scene(std::optional<SimTime> t) const {
  auto reader = scenes();
  if (!reader) return reader.error();
  const SimTime last = reader->end(), end = finished ? std::max(sim_time, last) : last;
  if (t)
    if (Status s = reaches(*t, last); !s) return s.error();
  SceneAt out;
  out.cut_off = t.value_or(end) > last || (!finished && t.value_or(end) == end);
  if (finished && out.cut_off && !reader->status()) return reader->status().error();
  auto scene = reader->at(std::min(t.value_or(end), last));
  if (!scene) return scene.error();
  out.scene = *std::move(scene);
  return out;
}

Status Run::reaches(SimTime t, SimTime recorded) const {
  if (t <= recorded) return {};
  const SimTime end = finished ? sim_time : std::max(recorded, end_of_log(folder / "inputs.bin"));
  return t <= end ? Status() : ends_at(end);
}

Error Run::ends_at(SimTime end) const {
  const bool is_cut_off = !finished || end < sim_time;
  return {ErrorKind::kUsage,
          "the run ends at " + seconds_text(to_seconds(end)) + (is_cut_off ? cut_off_text("log") : ""),
          {},
          0,
          kAfterTheEnd};
}

std::string Run::cut_off_text(const std::string& recording) const {
  return ", where the " + recording + " of the run is cut off" +
         (unfinished ? " (it is still being played, or was killed)" : "");
}

Status Run::whole(SimTime reached) const {
  if (!finished || ticks == 0 || reached >= sim_time) return {};
  return input_error(
      "cut off " +
          (reached < SimTime::zero() ? "before the first tick" : "after " + seconds_text(to_seconds(reached))) +
          ", before the end of the run at " + general_text(to_seconds(sim_time), 9) + " s; what comes before is whole",
      (folder / "inputs.bin").string());
}

bool Run::has_whole_journal() const {
  const fs::path journal = folder / "journal.jsonl";
  std::error_code unknown;
  const std::uintmax_t bytes = fs::file_size(journal, unknown);
  if (!finished || unknown) return false;
  if (const auto report = read_json(folder / "report.json"); report && report->is_object())
    if (const auto known = report->find("journal_bytes"); known != report->end() && known->is_number_unsigned())
      return bytes >= known->get<std::uintmax_t>();
  // How long it was is not known: what can be seen is that its last line is not whole.
  std::ifstream file(journal, std::ios::binary);
  return bytes > 0 && file.seekg(-1, std::ios::end) && file.get() == '\n';
}

std::optional<Error> Run::untrusted(const Status& played) const {
  if (played || played.error().code != kUntrusted) return std::nullopt;
  Error error = played.error();
  error.file = folder.string();
  error.line = 0;
  return error;
}

Error about_option(Error error, const std::string& option) {
  if (error.code == kAfterTheEnd) error.message = option + ": " + error.message;
  return error;
}

}  // namespace cxlab::lab
