#include "lab/physics_replay.h"

#include "cx/journal/input_log.h"
#include "scenarios/catalogue.h"
#include "scenarios/kept_files.h"

namespace cxlab::lab {

Expected<PhysicsOfRun> PhysicsOfRun::load(const RecordedRun& run) {
  const Error none =
      input_error("the run has no physics: it was played in the timed tier or in an empty world", run.folder.string());
  if (run.finished && !run.physics_hash) return none;
  PhysicsOfRun out;
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  const WorldKind& kind = *scenario->world.kind;
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
  if (!run.finished && out.log_->empty()) return none;

  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  out.scratch_ = *std::move(scratch);
  if (Status s = files->materialise(out.scratch_->path()); !s) return s.error();
  read_from_copies(out.scratch_->path(), *scenario);
  auto world = kind.replay(*scenario, out.scratch_->path() / "models", *out.log_);
  if (!world) return world.error();
  out.world_ = *std::move(world);
  return out;
}

}  // namespace cxlab::lab
