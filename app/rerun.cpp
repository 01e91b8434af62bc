// cxlab rerun: plays a run again from its manifest, and compares the hashes.

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/recorded_run.h"

namespace cxlab::app {

namespace {

struct Options {
  std::string run, out;
  bool json = false, quiet = false;
};

/// Streams (and "physics") whose hashes differ, in order of names.
std::vector<std::string> differences(const RecordedRun& then, const Result& now) {
  std::map<std::string, std::string> hashes(now.stream_hashes.begin(), now.stream_hashes.end());
  std::vector<std::string> out;
  for (const auto& [stream, hash] : then.stream_hashes)
    if (!hashes.contains(stream) || hashes[stream] != hash) out.push_back(stream);
  for (const auto& [stream, hash] : hashes)
    if (!then.stream_hashes.contains(stream)) out.push_back(stream);
  if (then.physics_hash.value_or("") != now.physics_hash) out.push_back("physics");
  return out;
}

/// The first file or folder of the scenario that is not there any more.
Status still_there(const RecordedRun& run, const Scenario& scenario) {
  const auto missing = [&](const std::string& what, const std::filesystem::path& path) {
    return input_error(what + " is not there any more: " + path.string() + "; bring it back to rerun, or play the rules alone "
                       "from the run's own copies: cxlab replay " + run.folder.string(), run.folder.string());
  };
  for (const AgentSpec& agent : scenario.agents) {
    if (const auto config = scenario.resolve(agent.config); !std::filesystem::exists(config)) return missing("the configuration", config);
    for (const auto& [name, folder] : scenario.shares(agent))
      if (!std::filesystem::is_directory(folder)) return missing("package " + name, folder);
  }
  return {};
}

int rerun(const Options& options) {
  auto run = RecordedRun::open(options.run);
  if (!run) return fail(run.error());
  if (!run->finished) return fail(input_error("the run was cut off before its end: there is nothing to compare with", options.run));
  auto scenario = run->scenario();
  if (!scenario) return fail(scenario.error());
  if (Status s = still_there(*run, *scenario); !s) return fail(s.error());
  RunOptions play = run->options;
  play.out = options.out;
  play.quiet = options.quiet;
  play.silent = true;
  if (run->status == "interrupted") play.until = to_seconds(run->sim_time);
  const Played played = play_scenario(play, *std::move(scenario));
  if (const int number = signal_that_came()) return 128 + number;
  if (played.result.stream_hashes.empty()) return played.exit_code;
  const std::vector<std::string> differ = differences(*run, played.result);
  if (options.json) {
    const nlohmann::ordered_json out{{"same", differ.empty()}, {"run", options.run}, {"again", played.folder.string()}, {"differ", differ}};
    std::printf("%s\n", out.dump(2).c_str());
  } else if (differ.empty()) {
    std::printf("the same: %zu streams%s; %s\n", run->stream_hashes.size(), run->physics_hash ? " and the physics" : "", played.folder.c_str());
  } else {
    std::string list;
    for (const std::string& name : differ) list += (list.empty() ? "" : ", ") + name;
    std::printf("different: %s; %s\n", list.c_str(), played.folder.c_str());
  }
  return differ.empty() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_rerun(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("rerun", "Plays a run again into a new folder and says whether the hashes agree");
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("--out", options->out, "Folder of the new run (default runs/<scenario>-<seed>)");
  command->add_flag("--json", options->json, "The answer as JSON");
  command->add_flag("--quiet", options->quiet, "No progress and no log lines");
  command->callback([options, &action] { action = [options] { return rerun(*options); }; });
}

}  // namespace cxlab::app
