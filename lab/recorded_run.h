#pragma once
// A run's folder, opened again: what it played, how it ended, and its copies of files.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/scratch_folder.h"
#include "cx/journal/file_store.h"
#include "lab/host.h"
#include "lab/manifest.h"
#include "scenarios/episode.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::lab {

struct RecordedRun {
  std::filesystem::path folder;
  const Catalogue* catalogue = nullptr;
  Manifest
      manifest;  ///< its files need not be there any more; `spec.programs` is false until the caller trusts the run

  // How it ended
  bool finished = false;  ///< else it was killed, and what follows is not known
  Tier tier{};
  SimTime sim_time{};
  std::int64_t ticks = 0;
  std::string status;
  std::map<std::string, std::string> stream_hashes;
  std::optional<std::string> physics_hash;
  std::map<std::string, Error> not_loaded;  ///< by name of the rule, without module: why

  /// Reads manifest.json and result.json. The catalogue has the worlds and nodes of the scenario. Without
  /// `trust_programs` nothing that plays the run again opens a library of a package or starts a program.
  static Expected<RecordedRun> open(const std::filesystem::path& folder, const Catalogue& catalogue = shipped(),
                                    bool trust_programs = false);
  /// What of versions and machine is another now, which explains other hashes: "C library: glibc 2.36, now glibc 2.41".
  std::vector<std::string> changed_surroundings() const;
  /// As it was read then; from the run's copy.
  Expected<Scenario> scenario() const;
  /// Whether a log that reaches that far is the whole of it: one may be cut off between two of its chunks.
  Status whole(SimTime reached) const;
  /// The error where it would start a program or open a native plugin, and nobody has said that it may.
  std::optional<Error> untrusted(const Status& played) const;
};

/// The environments of a run alone, ready to be started: `episode` reads and writes below `scratch` only.
struct RulesReplay {
  std::unique_ptr<ScratchFolder> scratch;
  std::unique_ptr<Episode> episode;
  int plays = 0;  ///< how often an episode was made; each writes into a folder of its own in `written`
  std::filesystem::path written() const { return scratch->path() / "plays"; }
  std::filesystem::path journal() const { return written() / std::to_string(plays) / "journal.jsonl"; }

  struct Options {
    SimTime end{};  ///< of the episode
    JournalLevel level = JournalLevel::kNone;
    cx::LogSink* log = nullptr;
    cx::RunControl* control = nullptr;
    bool count_activations = false;
  };
  static Expected<RulesReplay> load(const RecordedRun& run, const Host& host, const Options& options);
  /// Makes the episode anew, to be played from its start.
  Status load_again(const RecordedRun& run, const Host& host, const Options& options);
};

}  // namespace cxlab::lab
