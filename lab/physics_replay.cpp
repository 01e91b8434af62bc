#include "lab/physics_replay.h"

#include "cx/journal/input_log.h"
#include "scenarios/catalogue.h"
#include "scenarios/kept_files.h"

namespace cxlab::lab {

Expected<PhysicsOfRun> PhysicsOfRun::load(const Run& run) {
  const Error none =
      input_error("the run has no physics: it was played in the timed tier or in an empty world", run.folder.string());
  if (run.finished && !run.physics_hash) return none;
  PhysicsOfRun out;
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  out.scenario_ = std::make_unique<Scenario>(*std::move(scenario));
  const WorldKind& kind = *out.scenario_->world.kind;
  if (!kind.replay) return none;
  auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  auto reader = InputLogReader::open(run.folder / "inputs.bin");
  if (!reader) return reader.error();
  out.log_ = std::make_unique<std::string>();
  while (auto entry = reader->next())
    if (const auto* world = std::get_if<LoggedWorld>(&*entry)) {
      *out.log_ += world->bytes;
      out.log_end_ = world->t;
    }
  out.log_status_ = reader->status();
  if (out.log_status_) out.log_status_ = run.whole(reader->reached());
  if (!run.finished && out.log_->empty()) return none;

  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  out.scratch_ = *std::move(scratch);
  if (Status s = files->materialise(out.scratch_->path()); !s) return s.error();
  read_from_copies(out.scratch_->path(), *out.scenario_);
  auto world = kind.replay({*out.scenario_, out.scratch_->path() / "models", *out.log_, run.folder / "journal.jsonl"});
  if (!world) return world.error();
  out.world_ = *std::move(world);
  return out;
}

}  // namespace cxlab::lab
