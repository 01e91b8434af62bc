#pragma once
// The physics of a recorded run, again.

#include <memory>
#include <string>

#include "app/recorded_run.h"
#include "sim/mujoco/physics_gate.h"

namespace cxlab::app {

class PhysicsOfRun {
 public:
  /// The world at the start, from the run's own models. kInput if the run has no physics.
  static Expected<PhysicsOfRun> load(const RecordedRun& run);

  /// How reading the log ended, and where.
  const Status& log_status() const { return log_status_; }
  SimTime log_end() const { return log_end_; }

  Status advance_to(SimTime t);
  /// As in result.json.
  std::string hash() const;
  const sim::PhysicsGate& world() const { return replay_->gate(); }
  const sim::FloorPlan& plan() const { return plan_; }

 private:
  PhysicsOfRun() = default;

  std::unique_ptr<ScratchFolder> scratch_;
  std::unique_ptr<std::string> log_;  // at a fixed place: the replay views it
  Status log_status_;
  SimTime log_end_{};
  SimTime step_{};
  sim::FloorPlan plan_;
  std::optional<sim::PhysicsReplay> replay_;
};

}  // namespace cxlab::app
