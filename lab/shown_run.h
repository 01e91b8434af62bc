#pragma once
// A recorded run to look at, whatever its tier: its physics is played again, or its scene shows it.

#include <memory>
#include <optional>

#include "lab/physics_replay.h"
#include "lab/run.h"
#include "scenarios/stage.h"

namespace cxlab::lab {

class ShownRun {
 public:
  /// The world at the start. kInput where there is nothing to look at.
  static Expected<ShownRun> load(const Run& run);

  /// How reading the log or the scene ended, and where.
  const Status& log_status() const { return log_status_; }
  SimTime log_end() const { return log_end_; }
  const Scenario& scenario() const { return *scenario_; }

  /// The world as it was at `t`; times come in order.
  Status advance_to(SimTime t) { return physics_ ? physics_->advance_to(t) : scene_->advance_to(t); }
  Expected<std::unique_ptr<View>> view(int width, int height) const {
    return physics_ ? physics_->view(width, height) : scene_->view(width, height);
  }

 private:
  ShownRun() = default;

  std::unique_ptr<Scenario> scenario_;  // at a fixed place: the world views it
  Status log_status_;
  SimTime log_end_{};
  std::optional<PhysicsOfRun> physics_;
  std::unique_ptr<RecordedWorld> scene_;
};

}  // namespace cxlab::lab
