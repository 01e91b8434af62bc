#include "lab/recorded_run.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/remedy.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/input_log.h"
#include "cx/journal/run_folder.h"
#include "lab/versions.h"
#include "lab/what_if_json.h"

namespace cxlab::lab {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

Expected<Json> read_json(const fs::path& file) {
  auto text = read_file(file);
  if (!text) return text.error();
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return input_error("expected an object in JSON", file.string());
  return json;
}

/// What the library says, without its code.
std::string without_code(const Json::exception& e) {
  const std::string text = e.what();
  const std::size_t end = text.find("] ");
  return end == text.npos ? text : text.substr(end + 2);
}

void read_manifest(const Json& json, RecordedRun& run) {
  run.scenario_file = fs::path(json.at("folder").get<std::string>()) / json.at("scenario").get<std::string>();
  run.recorded_folder = json.value("out", std::string());
  run.overrides = json.at("overrides").get<std::vector<std::string>>();
  run.world_files = json.value("world_files", run.world_files);
  if (!json.at("until").is_null()) run.options.until = json.at("until").get<double>();
  run.options.journal = json.at("journal").get<std::string>();
  run.options.keep_going = json.at("keep_going").get<bool>();
  run.options.strict = json.at("strict_cx").get<bool>();
  const auto release = std::ranges::find(cx::kRosReleases, json.value("release", std::string("kilted")));
  if (release == std::end(cx::kRosReleases)) throw Json::other_error::create(500, "unknown 'release'", &json);
  run.options.release = static_cast<cx::RosRelease>(release - std::begin(cx::kRosReleases));
  run.options.sockets = json.value("sockets", false);
  run.options.prefixes = json.at("prefixes").get<std::vector<std::string>>();
  for (const Json& change : json.value("what_if", Json::array())) run.options.what_if.push_back(what_if_from(change));
  run.versions = json.at("versions").get<std::map<std::string, std::string>>();
  run.machine = json.value("machine", std::map<std::string, std::string>());
  for (const Json& agent : json.at("agents"))
    run.shares.push_back(agent.at("packages").get<std::map<std::string, std::string>>());
}

Status read_result(const Json& json, RecordedRun& run) {
  run.tier = json.at("tier") == "timed" ? Tier::kTimed : Tier::kPhysics;
  run.status = json.at("status").get<std::string>();
  const double end = json.at("sim_time_s").get<double>();
  if (!(end >= 0 && end <= to_seconds(kLongestRun)))
    return input_error("not the result of a run: sim_time_s: found " + general_text(end, 9) +
                       ", expected s from 0 to 1e9");
  run.sim_time = from_seconds(end);
  run.ticks = json.at("ticks").get<std::int64_t>();
  run.stream_hashes = json.at("stream_hashes").get<std::map<std::string, std::string>>();
  if (!json.at("physics_hash").is_null()) run.physics_hash = json.at("physics_hash").get<std::string>();
  run.finished = !run.stream_hashes.empty();
  for (const Json& error : json.at("rule_errors"))
    if (error.at("side") == "load")
      run.not_loaded.try_emplace(std::string(without_module(error.at("rule").get_ref<const std::string&>())),
                                 input_error(error.at("message"), error.value("file", ""), error.value("line", 0)));
  return {};
}

bool has_first_tick(const fs::path& inputs) {
  auto log = InputLogReader::open(inputs);
  if (!log) return false;
  while (log->reached() < SimTime::zero())
    if (!log->next()) break;
  return log->reached() >= SimTime::zero();
}

}  // namespace

Expected<RecordedRun> RecordedRun::open(const fs::path& folder, const Catalogue& catalogue) {
  if (!is_folder(folder)) return input_error("there is no folder of a run", folder.string());
  if (!path_exists(folder / "manifest.json"))
    return input_error("is not the folder of a run: there is no manifest.json in it", folder.string());
  RecordedRun run;
  run.folder = folder;
  run.options.programs = false;
  run.catalogue = &catalogue;
  auto manifest = read_json(folder / "manifest.json");
  if (!manifest) return manifest.error();
  auto result = read_json(folder / "result.json");
  if (!result) return result.error();
  try {
    read_manifest(*manifest, run);
  } catch (const Json::exception& e) {
    return input_error(std::string("not the manifest of a run: ") + without_code(e),
                       (folder / "manifest.json").string());
  }
  try {
    if (Status s = read_result(*result, run); !s)
      return input_error(s.error().message, (folder / "result.json").string());
  } catch (const Json::exception& e) {
    return input_error(std::string("not the result of a run: ") + without_code(e), (folder / "result.json").string());
  }
  return run;
}

std::vector<std::string> RecordedRun::changed_surroundings() const {
  std::vector<std::string> out;
  const auto compare = [&out](const std::map<std::string, std::string>& then, const auto& now) {
    for (const auto& [name, value] : now)
      if (const auto old = then.find(name); old == then.end() || old->second != value)
        out.push_back(name + ": " + (old == then.end() ? "not known" : old->second) + ", now " + value);
  };
  compare(versions, lab::versions());
  compare(machine, lab::machine());
  return out;
}

Expected<Scenario> RecordedRun::scenario() const {
  auto files = StoredFiles::open(folder);
  if (!files) return files.error();
  auto text = files->read("scenario.yaml");
  if (!text) return text.error();
  auto scenario = Scenario::parse(*text, scenario_file, *catalogue, {overrides.begin(), overrides.end()});
  if (!scenario) return scenario.error();
  for (auto& [key, file] : scenario->world_files)
    if (const auto then = world_files.find(key); then != world_files.end()) file.path = then->second;
  return scenario;
}

Status RecordedRun::whole(SimTime reached) const {
  if (!finished || ticks == 0 || reached >= sim_time) return {};
  return input_error("cut off " +
                         (reached < SimTime::zero() ? "before the first tick"
                                                    : "after " + general_text(to_seconds(reached), 9) + " s") +
                         ", before the end of the run at " + general_text(to_seconds(sim_time), 9) +
                         " s; what comes before is whole",
                     (folder / "inputs.bin").string());
}

std::optional<Error> RecordedRun::untrusted(const Status& played) const {
  if (played || played.error().code != kUntrusted) return std::nullopt;
  Error error = played.error();
  error.file = folder.string();
  error.line = 0;
  return error;
}

Expected<RulesReplay> RulesReplay::load(const RecordedRun& run, const Host& host, const Options& given) {
  RulesReplay replay;
  if ((!run.finished || run.ticks > 0) && !has_first_tick(run.folder / "inputs.bin"))
    return input_error(run.finished ? "the log of its inputs is cut off before the first tick"
                                    : "the run ended before the log of its inputs had the first tick",
                       run.folder.string());
  auto scratch = ScratchFolder::create(RemovedBy::kServant);
  if (!scratch) return scratch.error();
  replay.scratch = *std::move(scratch);
  auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  if (Status s = files->materialise(replay.scratch->path() / "copies"); !s) return s.error();
  if (Status s = replay.load_again(run, host, given); !s) return s.error();
  return replay;
}

Status RulesReplay::load_again(const RecordedRun& run, const Host& host, const Options& given) {
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  scenario->duration = given.end;
  episode.reset();
  const fs::path folder = written() / std::to_string(++plays);
  if (Status s = make_folder(folder); !s) return s;
  EpisodeOptions options = shared_episode_options(host);
  options.run_folder = folder;
  options.journal = given.level;
  options.log = given.log;
  options.control = given.control;
  options.count_activations = given.count_activations;
  options.replay = ReplaySource{run.folder / "inputs.bin", scratch->path() / "copies", run.shares, run.recorded_folder};
  options.keep_going = run.options.keep_going;
  options.strict = run.options.strict;
  options.release = run.options.release;
  options.programs = run.options.programs;
  auto loaded = Episode::load(*std::move(scenario), std::move(options));
  if (!loaded) return loaded.error();
  episode = *std::move(loaded);
  return {};
}

}  // namespace cxlab::lab
