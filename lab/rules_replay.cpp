#include "lab/rules_replay.h"

#include "cx/base/file.h"
#include "cx/journal/file_store.h"
#include "cx/journal/input_log.h"
#include "cx/journal/run_folder.h"
#include "lab/session.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

Expected<bool> has_first_tick(const fs::path& inputs) {
  auto log = InputLogReader::open(inputs);
  if (!log) return log.error();
  while (log->reached() < SimTime::zero())
    if (!log->next()) break;
  return log->reached() >= SimTime::zero();
}

}  // namespace

Expected<RulesReplay> RulesReplay::load(const Run& run, const Host& host, const Options& given) {
  RulesReplay replay;
  if (!run.finished || run.ticks > 0) {
    const auto begun = has_first_tick(run.folder / "inputs.bin");
    if (!begun && run.finished) return begun.error();
    if (!begun || !*begun)
      return input_error(run.finished ? "the log of its inputs is cut off before the first tick"
                                      : "the run ended before the log of its inputs had the first tick",
                         run.folder.string());
  }
  auto scratch = ScratchFolder::create(RemovedBy::kServant);
  if (!scratch) return scratch.error();
  replay.scratch = *std::move(scratch);
  auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  if (Status s = files->materialise(replay.scratch->path() / "copies"); !s) return s.error();
  if (Status s = replay.load_again(run, host, given); !s) return s.error();
  return replay;
}

Status RulesReplay::load_again(const Run& run, const Host& host, const Options& given) {
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
  options.counting = given.counting;
  options.on_environment_end = given.on_environment_end;
  options.replay =
      ReplaySource{run.folder / "inputs.bin", scratch->path() / "copies", run.manifest.shares(), run.manifest.out};
  auto loaded = Episode::load(*std::move(scenario), std::move(options));
  if (!loaded) return loaded.error();
  episode = *std::move(loaded);
  return {};
}

}  // namespace cxlab::lab
