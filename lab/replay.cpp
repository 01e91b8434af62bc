#include "lab/replay.h"

#include <algorithm>
#include <cstdio>

#include "cx/journal/journal_reader.h"
#include "lab/confine.h"
#include "lab/journal_difference.h"
#include "lab/physics_replay.h"
#include "lab/rules_replay.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// The records of one stream by number, from an exported journal; none if there is no journal.
Expected<std::map<std::uint64_t, JournalRecord>> records_of(const std::string& stream, const fs::path& journal) {
  std::map<std::uint64_t, JournalRecord> records;
  if (std::error_code ignored; !fs::exists(journal, ignored)) return records;
  auto all = read_journal(journal, {.stream = stream});
  if (!all) return all.error();
  for (JournalRecord& record : *all) records.emplace(record.n, std::move(record));
  return records;
}

bool same(const JournalRecord& a, const JournalRecord& b) {
  return a.t == b.t && a.kind == b.kind && a.data == b.data && a.causes == b.causes;
}

Status play_to_end(Episode& episode, const Run& run, SimTime end, const Host& host) {
  if (Status s = episode.start(); !s) return s;
  while (run.ticks > 0 && !episode.over() && !host.stopped()) {
    if (Status s = episode.tick(); !s) return s;
    host.show(to_seconds(episode.now()), to_seconds(end));
  }
  return {};
}

}  // namespace

std::string first_difference(const std::string& stream, const fs::path& recorded, const fs::path& replayed) {
  const auto then = records_of(stream, recorded), now = records_of(stream, replayed);
  if (!then || !now) return stream + ": " + (then ? now : then).error().text();
  for (const auto& [n, record] : *then) {
    const auto again = now->find(n);
    if (again != now->end() && same(again->second, record)) continue;
    char time[32];
    std::snprintf(time, sizeof time, "%.3f", to_seconds(record.t));
    return stream + ':' + std::to_string(n) + " at " + time + " s: then " + shown(record) + ", now " +
           (again == now->end() ? "nothing like it" : shown(again->second));
  }
  return stream + ": all " + std::to_string(then->size()) +
         " records that were exported agree; the difference is in records that the run did not export (--journal full "
         "of cxlab run does)";
}

Expected<ReplayOutcome> replay_rules(const Run& run, const Host& host) {
  SimTime end = run.sim_time;
  auto replay = RulesReplay::load(run, host, {.end = end, .level = JournalLevel::kFull});
  if (!replay) return replay.error();
  ReplayOutcome out;
  Status whole = replay->episode->replay_log_status();
  if (whole) whole = run.whole(replay->episode->replay_end());
  if (!whole) {
    out.broken = whole.error();
    end = replay->episode->replay_end();
    replay = RulesReplay::load(run, host, {.end = end, .level = JournalLevel::kFull});
    if (!replay) return replay.error();
  }
  Wall recorded;
  recorded.read = {run.folder};
  confine(*replay->episode, host, recorded);
  const Status played = play_to_end(*replay->episode, run, end, host);
  if (auto error = run.untrusted(played)) return *error;
  const Result result =
      replay->episode->close(RunStatus::kStopped, played ? std::nullopt : std::optional<Error>(played.error()));
  out.end = result.sim_time;
  if ((out.stopped = host.stopped())) return out;
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

Expected<ReplayOutcome> replay_physics(const Run& run, const Host& host) {
  if (!run.physics_hash)
    return input_error("the run has no physics: it was played in the timed tier or in an empty world",
                       run.folder.string());
  auto replay = PhysicsOfRun::load(run);
  if (!replay) return replay.error();
  ReplayOutcome out;
  if (!replay->log_status()) out.broken = replay->log_status().error();
  out.end = out.broken ? replay->log_end() : run.sim_time;
  constexpr SimTime kStretch = std::chrono::seconds(1);  // between looks at the host
  for (SimTime t{}; t < out.end;) {
    t = std::min(t + kStretch, out.end);
    if (Status s = replay->advance_to(t); !s) {
      if (run.status != "failed") return s.error();
      break;
    }
    host.show(to_seconds(t), to_seconds(out.end));
    if ((out.stopped = host.stopped())) return out;
  }
  (replay->hash() == *run.physics_hash ? out.same : out.differ).push_back("physics");
  if (!out.differ.empty() && !out.broken)
    out.first_difference = "physics: then " + *run.physics_hash + ", now " + replay->hash();
  return out;
}

}  // namespace cxlab::lab
