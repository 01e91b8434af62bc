#include "lab/shown_run.h"

#include "scenarios/catalogue.h"
#include "scenarios/share.h"

namespace cxlab::lab {

Expected<ShownRun> ShownRun::load(const Run& run) {
  ShownRun out;
  auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  out.scenario_ = std::make_unique<Scenario>(*std::move(scenario));
  const WorldKind& kind = *out.scenario_->world.kind;
  if (out.scenario_->tier != Tier::kTimed || !kind.show) {
    auto physics = PhysicsOfRun::load(run);
    if (!physics) return physics.error();
    out.log_status_ = physics->log_status();
    out.log_end_ = physics->log_end();
    out.physics_ = *std::move(physics);
    return out;
  }
  auto scenes = run.scenes();
  if (!scenes) return scenes.error();
  out.log_end_ = scenes->end();
  out.log_status_ = scenes->status();
  auto world = kind.show({*out.scenario_, find_share().models, *std::move(scenes), run.folder / "journal.jsonl"});
  if (!world) return world.error();
  out.scene_ = *std::move(world);
  return out;
}

}  // namespace cxlab::lab
