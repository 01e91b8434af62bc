#pragma once
// A run's folder, opened again: what it played, how it ended, and its copies of files.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/journal/journal_reader.h"
#include "lab/manifest.h"
#include "scenarios/scenario.h"
#include "scenarios/scene_log.h"
#include "scenarios/seat.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::lab {

struct Run {
  std::filesystem::path folder;
  const Catalogue* catalogue = nullptr;
  /// Its files need not be there any more; `spec.programs` is false until the caller trusts the run.
  Manifest manifest;

  std::string result;  ///< result.json

  // How it ended
  bool finished = false;  ///< else it was killed, and what follows is not known
  Tier tier{};
  SimTime sim_time{};
  std::int64_t ticks = 0;
  std::string status;
  bool unfinished = false;       ///< it is still being played, or its process was killed
  std::optional<Error> failure;  ///< why a run that failed did so
  std::map<std::string, std::string> stream_hashes;
  std::optional<std::string> physics_hash;
  std::map<std::string, Error> not_loaded;  ///< by name of the rule, without module: why

  /// Reads manifest.json and result.json. The catalogue has the worlds and nodes of the scenario. Without
  /// `trust_programs` nothing that plays the run again opens a library of a package or starts a program.
  static Expected<Run> open(const std::filesystem::path& folder, const Catalogue& catalogue = shipped(),
                            bool trust_programs = false);
  /// What of versions and machine is another now, which explains other hashes: "C library: glibc 2.36, now glibc 2.41".
  std::vector<std::string> changed_surroundings() const;
  /// Where a file of the run is now: where it was, or beside the run, where both were moved together.
  std::filesystem::path found(const std::filesystem::path& then) const;
  /// The scenario as it was read then, from the run's copy. Its files are named where they are `found`.
  Expected<Scenario> scenario() const;
  /// Its journal, from the start; an error that says why if it recorded none.
  Expected<JournalReader> journal() const;
  /// The records of the journal that the filter takes.
  Expected<std::vector<JournalRecord>> records(const RecordFilter& filter = {}) const;
  struct RecordsUpTo {
    std::vector<JournalRecord> records;
    SimTime t{};           ///< the time that was asked for, or the end
    bool ended = false;    ///< `t` is the end of a run that was played to its end
    bool cut_off = false;  ///< the journal ends before `t`
  };
  /// Those up to a time, without it up to the end. A time after the end of the run is an error (`about_option`).
  Expected<RecordsUpTo> records_up_to(std::optional<SimTime> t, const RecordFilter& filter = {}) const;
  /// What there was to see in its world, at any time.
  Expected<SceneReader> scenes() const;
  struct SceneAt {
    Scene scene;
    bool cut_off = false;  ///< the recording ends before the time that was asked for
  };
  /// The same at one time, without it at the end. A time after the end of the run is an error (`about_option`).
  Expected<SceneAt> scene(std::optional<SimTime> t = {}) const;
  /// An error if `t` is after the end of the run, or of the log of a run that was killed or is still being played
  /// (`about_option`). `recorded`: to where another recording goes, if that is further.
  Status reaches(SimTime t, SimTime recorded = {}) const;
  /// That error, for what ends there.
  Error ends_at(SimTime end) const;
  /// What to say behind a time at which a recording, "log" or "journal", ends before the run does.
  std::string cut_off_text(const std::string& recording) const;
  /// Whether a log that reaches that far is the whole of it: one may be cut off between two of its chunks.
  Status whole(SimTime reached) const;
  /// The seats of the run, which send the recorded messages again.
  Expected<std::vector<Seat>> seats() const;
  /// Whether journal.jsonl is there to its end: that of a run that was killed is not, nor is one that was shortened.
  bool has_whole_journal() const;
  /// The error where it would start a program or open a native plugin, and nobody has said that it may.
  std::optional<Error> untrusted(const Status& played) const;
};

/// The error of a run that ended before a time, with the option that gave the time; any other error as it is.
Error about_option(Error error, const std::string& option);

}  // namespace cxlab::lab
