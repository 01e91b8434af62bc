// cxlab replay: plays one half of a run again, rules or physics, without the other, and compares the hashes.

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/console.h"
#include "cx/journal/input_log.h"
#include "lab/physics_replay.h"
#include "lab/recorded_run.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
  std::string run;
  bool rules = false, physics = false, json = false;
};

/// The outcome of one half. `broken` is what was wrong with the log itself.
struct Outcome {
  std::vector<std::string> same, differ;
  std::string first_difference;
  SimTime end{};
  std::optional<Error> broken;
};

/// The lines of one stream by number, from an exported journal.
std::map<std::uint64_t, Json> records_of(const std::string& stream, const fs::path& journal) {
  std::map<std::uint64_t, Json> records;
  std::ifstream in(journal);
  for (std::string line; std::getline(in, line);) {
    Json record = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (record.is_object() && record.value("stream", "") == stream)
      records.emplace(record.value("n", std::uint64_t{0}), std::move(record));
  }
  return records;
}

std::string shown(const Json& record) { return record["kind"].get<std::string>() + ' ' + record["data"].dump(); }

/// Where two journals of a stream part, as far as the recorded one was exported.
std::string first_difference(const std::string& stream, const fs::path& recorded, const fs::path& replayed) {
  const auto then = records_of(stream, recorded), now = records_of(stream, replayed);
  for (const auto& [n, record] : then) {
    const auto again = now.find(n);
    if (again != now.end() && again->second == record) continue;
    char time[32];
    std::snprintf(time, sizeof time, "%.3f", record.value("t", std::int64_t{0}) / 1e9);
    return stream + ':' + std::to_string(n) + " at " + time + " s: then " + shown(record) + ", now " +
           (again == now.end() ? "nothing like it" : shown(again->second));
  }
  return stream + ": all " + std::to_string(then.size()) +
         " records that were exported agree; the difference is in records that the run did not export (--journal full)";
}

Status play_to_end(Episode& episode, const lab::RecordedRun& run, const lab::Host& host) {
  if (Status s = episode.start(); !s) return s;
  while (run.ticks > 0 && !episode.over() && !host.stopped())
    if (Status s = episode.tick(); !s) return s;
  return {};
}

Expected<Outcome> replay_rules(const lab::RecordedRun& run, const lab::Host& host) {
  SimTime end = run.sim_time;
  auto replay = lab::RulesReplay::load(run, end, JournalLevel::kFull);
  if (!replay) return replay.error();
  Outcome out;
  if (Status whole = replay->episode->replay_log_status(); !whole) {
    out.broken = whole.error();
    end = replay->episode->replay_end();
    replay = lab::RulesReplay::load(run, end, JournalLevel::kFull);
    if (!replay) return replay.error();
  }
  const Status played = play_to_end(*replay->episode, run, host);
  const Result result =
      replay->episode->close(RunStatus::kStopped, played ? std::nullopt : std::optional<Error>(played.error()));
  out.end = result.sim_time;
  if (result.reason && (result.reason->kind == ErrorKind::kNo || run.status != "failed"))
    out.first_difference = result.reason->text();
  const std::map<std::string, std::string> hashes(result.stream_hashes.begin(), result.stream_hashes.end());
  for (const auto& [stream, hash] : run.stream_hashes) {
    if (!stream.starts_with("env/")) continue;
    const auto again = hashes.find(stream);
    (again != hashes.end() && again->second == hash ? out.same : out.differ).push_back(stream);
  }
  if (!out.differ.empty() && !out.broken && out.first_difference.empty())
    out.first_difference = first_difference(out.differ.front(), run.folder / "journal.jsonl", replay->journal());
  return out;
}

Expected<Outcome> replay_physics(const lab::RecordedRun& run) {
  auto replay = lab::PhysicsOfRun::load(run);
  if (!replay) return replay.error();
  Outcome out;
  if (!replay->log_status()) out.broken = replay->log_status().error();
  out.end = out.broken ? replay->log_end() : run.sim_time;
  if (Status s = replay->advance_to(out.end); !s && run.status != "failed") return s.error();
  (replay->hash() == *run.physics_hash ? out.same : out.differ).push_back("physics");
  if (!out.differ.empty() && !out.broken)
    out.first_difference = "physics: then " + *run.physics_hash + ", now " + replay->hash();
  return out;
}

Json to_json(const Outcome& outcome) {
  Json out;
  out["same"] = outcome.differ.empty() && !outcome.broken;
  out["sim_time_s"] = to_seconds(outcome.end);
  out["agree"] = outcome.same;
  out["differ"] = outcome.broken ? std::vector<std::string>() : outcome.differ;
  out["first_difference"] = outcome.first_difference.empty() ? Json(nullptr) : Json(outcome.first_difference);
  out["broken"] = outcome.broken ? Json(outcome.broken->text()) : Json(nullptr);
  return out;
}

void print(const char* half, const Outcome& outcome) {
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

int replay(const Options& options) {
  auto run = lab::RecordedRun::open(options.run);
  if (!run) return fail(run.error());
  if (!run->finished)
    return fail(input_error("the run was cut off before its end: there are no hashes to compare with", options.run));
  if (options.physics && !run->physics_hash)
    return fail(
        input_error("the run has no physics: it was played in the timed tier or in an empty world", options.run));
  Console console(true);
  const lab::Host host = console.host();
  Json json = Json::object();
  int code = 0;
  const auto half = [&](const char* name, Expected<Outcome> outcome) {
    if (!outcome) {
      code = fail(outcome.error());
      return false;
    }
    if (options.json)
      json[name] = to_json(*outcome);
    else
      print(name, *outcome);
    if (outcome->broken)
      code = fail(*outcome->broken);
    else if (code == 0 && (!outcome->differ.empty() || !outcome->first_difference.empty()))
      code = static_cast<int>(ErrorKind::kNo);
    return true;
  };
  const bool both = options.rules == options.physics;
  if (both || options.rules)
    if (!half("rules", replay_rules(*run, host))) return code;
  if (run->physics_hash && (both || options.physics))
    if (!half("physics", replay_physics(*run))) return code;
  if (options.json) std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  return signal_that_came() ? 128 + signal_that_came() : code;
}

}  // namespace

void add_replay(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("replay", "Plays a run again from its input log and says whether the hashes agree");
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_flag("--rules", options->rules, "Only the rules, without world and servers");
  command->add_flag("--physics", options->physics, "Only the physics, without rules and servers");
  command->add_flag("--json", options->json, "The answer as JSON");
  command->footer("It reads nothing but the run's folder: the files of the run may be gone or changed.");
  command->callback([options, &action] { action = [options] { return replay(*options); }; });
}

}  // namespace cxlab::app
