#pragma once
// The rules of a run, played again from its input log, without world and servers.

#include <filesystem>
#include <memory>

#include "cx/base/expected.h"
#include "cx/base/scratch_folder.h"
#include "lab/host.h"
#include "lab/run.h"
#include "scenarios/episode.h"

namespace cxlab::lab {

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
    Counting counting = Counting::kNothing;
    std::function<void(const cx::Environment&)> on_environment_end = {};
  };
  static Expected<RulesReplay> load(const Run& run, const Host& host, const Options& options);
  /// Makes a new episode, to be played from its start.
  Status load_again(const Run& run, const Host& host, const Options& options);
};

}  // namespace cxlab::lab
