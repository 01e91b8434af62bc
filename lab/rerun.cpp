#include "lab/rerun.h"

#include <algorithm>
#include <fstream>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/scratch_folder.h"
#include "cx/executive/reach.h"
#include "cx/journal/input_log.h"
#include "lab/replay.h"
#include "scenarios/inputs.h"

namespace cxlab::lab {

namespace {

/// Streams (and "physics") whose hashes differ, in order of names.
std::vector<std::string> differences(const Run& then, const Result& now) {
  std::map<std::string, std::string> hashes(now.stream_hashes.begin(), now.stream_hashes.end());
  std::vector<std::string> out;
  for (const auto& [stream, hash] : then.stream_hashes)
    if (!hashes.contains(stream) || hashes[stream] != hash) out.push_back(stream);
  for (const auto& [stream, hash] : hashes)
    if (!then.stream_hashes.contains(stream)) out.push_back(stream);
  if (then.physics_hash.value_or("") != now.physics_hash) out.push_back("physics");
  return out;
}

/// Files that the two runs read with another content, or that only one of them read; a build with other rules of its
/// own explains a difference no less than a changed scenario.
std::vector<std::string> changed_files(const std::map<std::string, std::string>& before,
                                       const std::map<std::string, std::string>& after) {
  std::vector<std::string> out;
  for (const auto& [name, hash] : before)
    if (const auto again = after.find(name); again == after.end() || again->second != hash) out.push_back(name);
  for (const auto& [name, hash] : after)
    if (!before.contains(name) && !name.starts_with("what_if/")) out.push_back(name);
  return out;
}

std::map<std::string, std::string> hashes_of_files(const std::filesystem::path& run) {
  const auto files = StoredFiles::open(run);
  return files ? files->hashes() : std::map<std::string, std::string>();
}

/// The bag, where the two runs played another one.
void add_changed_bag(const Run& run, const std::filesystem::path& again, std::vector<std::string>& changed) {
  const auto manifest = Manifest::read(again);
  const auto digest = [](const std::map<std::string, std::string>& bag) {
    const auto known = bag.find("digest");
    return known == bag.end() ? std::string() : known->second;
  };
  if (manifest && digest(manifest->bag) != digest(run.manifest.bag))
    changed.push_back("the bag " + run.manifest.bag.at("file"));
}

Error not_there(const Run& run, const std::string& what, const std::filesystem::path& path) {
  return input_error(what + " is missing: " + path.string() +
                         "; bring it back to rerun, or play the rules alone "
                         "from the run's own copies: cxlab replay " +
                         run.folder.string(),
                     run.folder.string());
}

/// The first file or folder of the scenario that is not there any more.
Status still_there(const Run& run, const Scenario& scenario) {
  const auto missing = [&](const std::string& what, const std::filesystem::path& path) {
    return not_there(run, what, path);
  };
  for (const AgentSpec& agent : scenario.agents) {
    if (const auto config = scenario.resolve(agent.config); !path_exists(config))
      return missing("the configuration", config);
    for (const auto& [name, folder] : scenario.shares(agent))
      if (!is_folder(folder)) return missing("package " + name, folder);
  }
  for (const auto& [key, file] : scenario.world_files)
    if (!path_exists(file.path)) return missing("world." + key, file.path);
  return {};
}

/// The run may be that of a stranger: a package in a hidden folder, as that of keys, is none that its rules may read.
/// The run itself may lie in one.
Status no_hidden_packages(const Run& run, const Scenario& scenario) {
  namespace fs = std::filesystem;
  const fs::path here = fs::absolute(run.folder).lexically_normal();
  for (const AgentSpec& agent : scenario.agents)
    for (const auto& [name, folder] : scenario.shares(agent)) {
      const fs::path package = fs::path(folder).lexically_normal();
      const auto apart = std::ranges::mismatch(package, here);
      fs::path own;
      for (auto part = apart.in1; part != package.end(); ++part) own /= *part;
      if (cx::is_hidden(own))
        return usage_error("package " + name + " of this run is the hidden folder " + folder +
                               ", which its rules would read; if they may: cxlab rerun --trust-rules " +
                               run.folder.string(),
                           run.folder.string());
    }
  return {};
}

/// Whether the run read files of no package: those are not laid out below a folder that it could be played from.
bool read_outside(const StoredFiles& files) {
  const auto names = files.names();
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return name.starts_with("agents/") && name.find("/outside/") != name.npos;
  });
}

/// Lets the scenario play from the run's copies, laid out below `root`: each agent's configuration, and its packages
/// with what was read of them and their definitions.
Status play_from_copies(const Run& run, const StoredFiles& files, const std::filesystem::path& root,
                        Scenario& scenario) {
  namespace fs = std::filesystem;
  if (run.manifest.agents.size() != scenario.agents.size())
    return input_error("the run's manifest has another number of agents", run.folder.string());
  if (Status s = files.materialise(root); !s) return s;
  read_from_copies(root, scenario);
  scenario.packages.clear();
  std::error_code error;
  for (std::size_t i = 0; i < scenario.agents.size(); ++i) {
    AgentSpec& agent = scenario.agents[i];
    const fs::path copies = root / "agents" / std::to_string(i);
    agent.config = (copies / "config" / scenario.resolve(agent.config).filename()).string();
    agent.packages.clear();
    for (const auto& [name, share] : run.manifest.agents[i].packages) {
      const fs::path folder = copies / "packages" / name;
      fs::create_directories(folder, error);
      if (const fs::path definitions = root / "interfaces" / name; !error && is_folder(definitions))
        fs::copy(definitions, folder, fs::copy_options::recursive | fs::copy_options::skip_existing, error);
      if (error) return resource_error(error.message(), folder.string());
      agent.packages[name] = {folder.string()};
    }
  }
  return {};
}

bool is_of_program(const PastAct& past) { return past.act.place.is_between_ticks(); }

/// Whether a person did it with cxlab attach. Planned acts, and acts of the program that played the run, are done
/// again.
bool is_of_person(const PastAct& past) { return !is_of_program(past) && !cx::is_planned(past.act.verb); }

/// The changes of the run in order of their time, with their files and the new one.
Expected<std::vector<WhatIf>> changes_of(const Run& run, const std::optional<WhatIf>& more, const Scenario& scenario) {
  std::vector<WhatIf> changes = run.manifest.spec.what_if;
  if (!changes.empty()) {
    const auto files = StoredFiles::open(run.folder);
    if (!files) return files.error();
    for (WhatIf& change : changes) {
      if (change.file.empty()) continue;
      auto text = files->read(change.copy);
      if (!text) return text.error();
      change.text = *std::move(text);
    }
  }
  if (more) {
    WhatIf change = *more;
    if (Status s = prepare(change, run, scenario); !s) return s.error();
    if (!change.changes_nothing()) changes.push_back(std::move(change));
  }
  std::ranges::stable_sort(changes, {}, &WhatIf::at);
  return changes;
}

/// Compares a run that went on otherwise with the recorded one.
Status compare(const Run& run, const WorldKind& world, SimTime since, Rerun& again) {
  again.results = compare_results(world, run.result, again.played.result.to_json());
  if (again.played.folder.empty()) return {};
  auto before = difference_before(since, run.folder, again.played.folder, run.finished);
  if (!before) return before.error();
  again.before = *std::move(before);
  // If a run is shorter, the comparison leaves out its last tick, in which the agents are deactivated.
  SimTime end = again.played.result.sim_time;
  end = !run.finished || end == run.sim_time ? kNever : std::min(end, run.sim_time) - SimTime(1);
  auto after = first_differences(run.folder, again.played.folder, end);
  if (!after) return after.error();
  again.after = *std::move(after);
  return {};
}

}  // namespace

Expected<Rerun> rerun(const Run& run, const RerunOptions& given, const Host& host) {
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  if (scenario->bag && !path_exists(scenario->resolve(scenario->bag.file)))  // too large for a copy
    return not_there(run, "the bag", scenario->resolve(scenario->bag.file));
  std::unique_ptr<ScratchFolder> copies;
  if (Status there = still_there(run, *scenario); !there) {
    auto files = StoredFiles::open(run.folder);
    if (!files) return files.error();
    if (!given.from_copies || read_outside(*files)) return there.error();
    auto scratch = ScratchFolder::create(RemovedBy::kServant);
    if (!scratch) return scratch.error();
    copies = *std::move(scratch);
    if (Status s = play_from_copies(run, *files, copies->path(), *scenario); !s) return s.error();
    host.note("note: files of the scenario are missing; cxlab uses the run's own copies of all files: " +
              run.folder.string());
  }
  if (scenario->trust_rules && !given.trust_rules)
    return usage_error(
        "the rules of this run were trusted: they may read, write and run anything. If they may do so "
        "again: cxlab rerun --trust-rules " +
            run.folder.string() + "; cxlab replay plays them without touching anything",
        run.folder.string());
  if (Status s = no_hidden_packages(run, *scenario); !s && !copies && !given.trust_rules) return s.error();
  auto acts = recorded_acts(run.folder / "inputs.bin");
  if (!acts)
    acts = std::vector<PastAct>();  // a run without a log is played again, and its hashes tell whether it differs
  const char* took_part = run.manifest.spec.sockets                  ? "programs outside (--sockets)"
                          : std::ranges::any_of(*acts, is_of_person) ? "a person (cxlab attach)"
                                                                     : nullptr;
  std::erase_if(*acts, std::not_fn(is_of_program));
  if (took_part)
    return usage_error(std::string(took_part) +
                           " took part in this run, and would not do the same again; its rules alone: cxlab replay " +
                           run.folder.string(),
                       run.folder.string());
  if (given.until && given.what_if && *given.until < given.what_if->at)
    return usage_error("--until: " + found_expected(general_text(*given.until, 9), "a time after that of --at"));
  if (std::error_code none; given.what_if && std::filesystem::equivalent(given.out, run.folder, none))
    return usage_error("--out: " + found_expected("the folder of the run itself", "another one, to compare them"),
                       given.out);
  auto changes = changes_of(run, given.what_if, *scenario);
  if (!changes) return changes.error();
  if (given.what_if && !run.manifest.seats.empty())
    return usage_error("the program at seat " + run.manifest.seats.front() +
                           " took part in this run; it sends what it sent then, and would not answer to another course",
                       run.folder.string());
  if (given.what_if && !acts->empty())
    return usage_error(
        "the program that played this run acted in its environments, and would not do the same on another course",
        run.folder.string());
  auto seats = run.seats();
  if (!seats) return seats.error();
  PlayOptions options{.spec = run.manifest.spec};
  options.seats = *std::move(seats);
  options.acts = *std::move(acts);
  options.spec.what_if = *std::move(changes);
  options.also_read = {run.folder};
  if (copies) options.spec.prefixes.clear();
  options.out = given.out;
  options.force = given.force;
  options.command = given.command;
  if (given.until)
    options.spec.until = given.until;
  else if (run.status == "interrupted")
    options.spec.until = to_seconds(run.sim_time);
  const auto files_then = hashes_of_files(run.folder);
  const WorldKind& world = *scenario->world.kind;
  auto played = play_scenario(options, *std::move(scenario), host);
  if (!played) return played.error();
  if (played->failure)
    if (auto error = run.untrusted(*played->failure)) return *error;
  Rerun again;
  again.played = *std::move(played);
  if (given.what_if) {
    if (host.stopped() || again.played.result.stream_hashes.empty()) return again;
    if (Status s = compare(run, world, from_seconds(given.what_if->at), again); !s) return s.error();
    if (again.before) again.changed_files = changed_files(files_then, hashes_of_files(again.played.folder));
    if (again.before && run.manifest.bag.contains("file"))
      add_changed_bag(run, again.played.folder, again.changed_files);
    return again;
  }
  if (again.played.result.stream_hashes.empty() || host.stopped()) return again;
  again.differ = differences(run, again.played.result);
  for (const std::string& stream : again.differ)
    if (stream != "physics")
      again.first.push_back(
          first_difference(stream, run.folder / "journal.jsonl", again.played.folder / "journal.jsonl"));
  again.changed_files = changed_files(files_then, hashes_of_files(again.played.folder));
  if (run.manifest.bag.contains("file")) add_changed_bag(run, again.played.folder, again.changed_files);
  return again;
}

}  // namespace cxlab::lab
