#include "app/physics_replay.h"

#include <cstdio>

#include "cx/journal/input_log.h"
#include "scenarios/rcll/floor_plan.h"
#include "scenarios/rcll/stage.h"

namespace cxlab::app {

Expected<PhysicsOfRun> PhysicsOfRun::load(const RecordedRun& run) {
  if (!run.physics_hash) return input_error("the run has no physics: it was played in the timed tier or in an empty world", run.folder.string());
  PhysicsOfRun out;
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  out.scratch_ = *std::move(scratch);
  auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  if (Status s = files->materialise(out.scratch_->path()); !s) return s.error();

  auto reader = InputLogReader::open(run.folder / "inputs.bin");
  if (!reader) return reader.error();
  out.log_ = std::make_unique<std::string>();
  while (auto entry = reader->next())
    if (const auto* world = std::get_if<LoggedWorld>(&*entry)) {
      *out.log_ += world->bytes;
      out.log_end_ = world->t;
    }
  out.log_status_ = reader->status();

  auto plan = rcll::floor_plan_of(scenario->rcll, scenario->seed);
  if (!plan) return plan.error();
  out.plan_ = *std::move(plan);
  auto options = rcll::model_options(*scenario, out.scratch_->path() / "models");
  if (!options) return options.error();
  auto replay = sim::PhysicsReplay::load(out.plan_, *options, *out.log_);
  if (!replay) return replay.error();
  out.replay_.emplace(*std::move(replay));
  out.step_ = scenario->physics_step;
  return out;
}

Status PhysicsOfRun::advance_to(SimTime t) { return replay_->advance_to(t / step_); }

std::string PhysicsOfRun::hash() const {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(replay_->hash()));
  return text;
}

}  // namespace cxlab::app
