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
#include "lab/json_fields.h"
#include "lab/session.h"
#include "lab/versions.h"

namespace cxlab::lab {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

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

Expected<RecordedRun> RecordedRun::open(const fs::path& folder, const Catalogue& catalogue, bool trust_programs) {
  if (!is_folder(folder)) return input_error("there is no folder of a run", folder.string());
  if (!path_exists(folder / "manifest.json"))
    return input_error("is not the folder of a run: there is no manifest.json in it", folder.string());
  RecordedRun run;
  run.folder = folder;
  run.catalogue = &catalogue;
  auto manifest = Manifest::read(folder);
  if (!manifest) return manifest.error();
  run.manifest = *std::move(manifest);
  run.manifest.spec.programs = trust_programs;
  auto result = read_json(folder / "result.json");
  if (!result) return result.error();
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
  compare(manifest.versions, lab::versions());
  compare(manifest.machine, lab::machine());
  return out;
}

Expected<Scenario> RecordedRun::scenario() const {
  auto files = StoredFiles::open(folder);
  if (!files) return files.error();
  auto text = files->read("scenario.yaml");
  if (!text) return text.error();
  auto scenario = Scenario::parse(*text, manifest.scenario_file(), *catalogue,
                                  {manifest.overrides.begin(), manifest.overrides.end()});
  if (!scenario) return scenario.error();
  for (auto& [key, file] : scenario->world_files)
    if (const auto then = manifest.world_files.find(key); then != manifest.world_files.end()) file.path = then->second;
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
  EpisodeOptions options = shared_episode_options(host, run.manifest.spec);
  options.spec.journal = given.level;
  options.spec.sockets = false;
  options.run_folder = folder;
  options.log = given.log;
  options.control = given.control;
  options.count_activations = given.count_activations;
  options.replay =
      ReplaySource{run.folder / "inputs.bin", scratch->path() / "copies", run.manifest.shares(), run.manifest.out};
  auto loaded = Episode::load(*std::move(scenario), std::move(options));
  if (!loaded) return loaded.error();
  episode = *std::move(loaded);
  return {};
}

}  // namespace cxlab::lab
