// The folder of a run, as somebody else may hand it over: the first byte chooses one of its files, the rest is its
// content.

#include <filesystem>

#include "cx/base/file.h"
#include "cx/base/scratch_folder.h"
#include "lab/replay.h"
#include "lab/session.h"
#include "lab/why_not.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/agent_text.h"

namespace fuzz_run_folder {
namespace {

using namespace cxlab;
namespace fs = std::filesystem;

/// A run of two ticks.
const fs::path& recorded() {
  static const std::unique_ptr<ScratchFolder> folder = *ScratchFolder::create();
  static const fs::path run = [] {
    const fs::path here = folder->path();
    fs::create_directories(here / "rules");
    fuzz::promise(
        write_file(here / "agent.yaml", agent_text("rules")).ok() &&
            write_file(here / "rules/rules.clp", "(defrule tick (time ?t) => (assert (seen ?t)))\n").ok() &&
            write_file(here / "game.yaml",
                       "schema: 1\nduration_s: 0.2\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
                .ok(),
        "the files are written");
    auto scenario = Scenario::load(here / "game.yaml", shipped());
    fuzz::promise(scenario.ok(), "the scenario is read");
    const auto played = lab::play_scenario({.out = (here / "run").string()}, *std::move(scenario));
    fuzz::promise(played.ok() && !played->failure, "the run is played");
    return here / "run";
  }();
  return run;
}

}  // namespace

FUZZ_TARGET(run_folder) {
  static constexpr const char* kFiles[] = {"manifest.json", "result.json", "files/index.jsonl", "inputs.bin",
                                           "journal.jsonl"};
  if (size == 0) return 0;
  const fs::path file = recorded() / kFiles[data[0] % std::size(kFiles)];
  const std::string whole = *read_file(file);
  // "..." stands for what was there before: so that a change may be small.
  std::string content = fuzz::text_of(data + 1, size - 1);
  if (const std::size_t rest = content.find("..."); rest != std::string::npos) content.replace(rest, 3, whole);
  fuzz::promise(write_file(file, content).ok(), "the file is written");
  if (const auto run = lab::Run::open(recorded())) {
    const auto answer = lab::why_not(*run, {.rule = "tick", .at = std::chrono::seconds(1)});
    fuzz::promise(answer.ok() || !answer.error().message.empty(), "an error says what it is");
    if (run->finished) {
      const auto replayed = lab::replay_rules(*run);
      fuzz::promise(replayed.ok() || !replayed.error().message.empty(), "an error says what it is");
      fuzz::promise(content != whole || (replayed.ok() && replayed->agrees()), "the run itself replays");
    }
  } else {
    fuzz::promise(!run.error().message.empty(), "an error says what it is");
  }
  fuzz::promise(write_file(file, whole).ok(), "the file is written back");
  return 0;
}

}  // namespace fuzz_run_folder
