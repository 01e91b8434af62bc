#include "lab/physics_replay.h"

#include <cstdio>

#include "cx/journal/input_log.h"
#include "scenarios/rcll/floor_plan.h"
#include "scenarios/rcll/stage.h"
#include "scenarios/turtlesim/stage.h"

namespace cxlab::lab {

Expected<PhysicsOfRun> PhysicsOfRun::load(const RecordedRun& run) {
  const Error none =
      input_error("the run has no physics: it was played in the timed tier or in an empty world", run.folder.string());
  if (run.finished && !run.physics_hash) return none;
  PhysicsOfRun out;
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
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

  out.tick_ = scenario->tick;
  if (scenario->world_kind == Scenario::WorldKind::kTurtlesim)
    out.turtles_ = std::make_unique<sim::TurtleReplay>(
        turtlesim::world_options(scenario->turtlesim, scenario->physics_step), *out.log_);
  else if (Status s = out.load_factory(*scenario, *files); !s)
    return s.error();
  return out;
}

Status PhysicsOfRun::load_factory(const Scenario& scenario, const StoredFiles& files) {
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  scratch_ = *std::move(scratch);
  if (Status s = files.materialise(scratch_->path()); !s) return s;
  auto plan = rcll::floor_plan_of(scenario.rcll, scenario.seed);
  if (!plan) return plan.error();
  plan_ = *std::move(plan);
  auto options = rcll::model_options(scenario, scratch_->path() / "models");
  if (!options) return options.error();
  auto replay = sim::PhysicsReplay::load(plan_, *options, *log_);
  if (!replay) return replay.error();
  factory_.emplace(*std::move(replay));
  step_ = scenario.physics_step;
  return {};
}

Status PhysicsOfRun::advance_to(SimTime t) {
  return turtles_ ? turtles_->advance_to(tick_not_before(t, tick_)) : factory_->advance_to(t / step_);
}

Expected<std::unique_ptr<View>> PhysicsOfRun::view(int width, int height) const {
  if (turtles_) return view_of_turtles(turtles_->world(), width, height);
  return view_of_factory(plan_, factory_->gate(), width, height);
}

std::string PhysicsOfRun::hash() const {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx",
                static_cast<unsigned long long>(turtles_ ? turtles_->world().hash() : factory_->hash()));
  return text;
}

}  // namespace cxlab::lab
