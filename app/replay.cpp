// cxlab replay: plays one half of a run again, rules or physics, without the other, and compares the hashes.

#include <cstdio>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/json.h"
#include "lab/replay.h"

namespace cxlab::app {

namespace {

struct ReplayOptions {
  std::string run;
  bool rules = false, physics = false, trust_programs = false, json = false;
};

Json to_json(const lab::ReplayOutcome& outcome) {
  Json out;
  out["same"] = outcome.differ.empty() && !outcome.broken;
  out["sim_time_s"] = to_seconds(outcome.end);
  out["agree"] = outcome.same;
  out["differ"] = outcome.broken ? std::vector<std::string>() : outcome.differ;
  out["first_difference"] = outcome.first_difference.empty() ? Json(nullptr) : Json(outcome.first_difference);
  out["broken"] = outcome.broken ? Json(outcome.broken->text()) : Json(nullptr);
  return out;
}

void print(const char* half, const lab::ReplayOutcome& outcome) {
  std::string agree, differ;
  for (const std::string& name : outcome.same) agree += ' ' + name;
  for (const std::string& name : outcome.differ) differ += ' ' + name;
  const double end = to_seconds(outcome.end);
  if (outcome.broken) {
    std::printf("%s: replayed up to %.3f s, where the log ends\n", half, end);
  } else if (outcome.differ.empty() && outcome.first_difference.empty()) {
    std::printf("%s: the same up to %.3f s:%s\n", half, end, agree.c_str());
  } else {
    std::printf("%s: different:%s\n", half, differ.c_str());
    if (!agree.empty()) std::printf("  the same:%s\n", agree.c_str());
  }
  if (!outcome.first_difference.empty()) std::printf("  first difference: %s\n", outcome.first_difference.c_str());
}

int replay(const ReplayOptions& options) {
  auto run = lab::Run::open(options.run, catalogue(), options.trust_programs);
  if (!run) return fail(run.error());
  if (!run->finished)
    return fail(input_error("the run was cut off before its end: there are no hashes to compare with", options.run));
  Console console(options.json);
  const lab::Host host = console.host();
  Json json = Json::object();
  int code = 0;
  const auto half = [&](const char* name, Expected<lab::ReplayOutcome> outcome) {
    console.clear();
    if (!outcome) code = fail(outcome.error());
    if (!outcome || outcome->stopped) return false;
    if (options.json)
      json[name] = to_json(*outcome);
    else
      print(name, *outcome);
    if (!options.json && !outcome->agrees())
      for (const std::string& what : run->changed_surroundings())
        std::printf("  not as in the run: %s\n", what.c_str());
    if (outcome->broken)
      code = fail(*outcome->broken);
    else if (code == 0 && !outcome->agrees())
      code = static_cast<int>(ErrorKind::kNo);
    return true;
  };
  const bool both = options.rules == options.physics;
  bool go_on = true;
  // The physics come first: once rules have run, this process reads no further files (lab/confine.h).
  std::optional<Expected<lab::ReplayOutcome>> physics;
  if ((options.physics || run->physics_hash) && (both || options.physics)) physics = lab::replay_physics(*run, host);
  if (both || options.rules) go_on = half("rules", lab::replay_rules(*run, host));
  if (go_on && physics) go_on = half("physics", *std::move(physics));
  if (const int stopped = interrupted("the run was not replayed to its end")) return stopped;
  if (!go_on) return code;
  if (options.json && code == static_cast<int>(ErrorKind::kNo))
    json["changed_surroundings"] = run->changed_surroundings();
  if (options.json) std::printf("%s\n", json_text(json, 2).c_str());
  return code;
}

}  // namespace

void add_replay(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Play a run again from its input log and compare the hashes");
  add_limit_options(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_flag("--rules", options->rules, "Only the rules, without world and servers");
  command->add_flag("--physics", options->physics, "Only the physics, without rules and servers");
  add_trust_programs(*command, options->trust_programs);
  command->add_flag("--json", options->json, "Prints the answer as JSON");
  command->footer(
      "It reads only the run's folder, so the files that the run was played from may be missing or changed.");
  command->callback([options, &action] { action = [options] { return replay(*options); }; });
}

}  // namespace cxlab::app
