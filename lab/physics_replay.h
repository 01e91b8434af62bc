#pragma once
// The physics of a recorded run, again.

#include <memory>
#include <string>

#include "lab/recorded_run.h"
#include "lab/view.h"
#include "sim/box2d/turtle_world.h"
#include "sim/mujoco/physics_gate.h"

namespace cxlab::lab {

class PhysicsOfRun {
 public:
  /// The world at the start, from the run's own models. kInput if the run has no physics.
  static Expected<PhysicsOfRun> load(const RecordedRun& run);

  /// How reading the log ended, and where.
  const Status& log_status() const { return log_status_; }
  SimTime log_end() const { return log_end_; }

  /// To the first tick not before `t` (a canvas), or the last step before it (a factory).
  Status advance_to(SimTime t);
  /// As in result.json.
  std::string hash() const;
  Expected<std::unique_ptr<View>> view(int width, int height) const;

 private:
  PhysicsOfRun() = default;
  Status load_factory(const Scenario& scenario, const StoredFiles& files);

  std::unique_ptr<ScratchFolder> scratch_;
  std::unique_ptr<std::string> log_;  // at a fixed place: the replay views it
  Status log_status_;
  SimTime log_end_{};
  SimTime step_{}, tick_{};
  sim::FloorPlan plan_;
  std::optional<sim::PhysicsReplay> factory_;  // either of the two
  std::unique_ptr<sim::TurtleReplay> turtles_;
};

}  // namespace cxlab::lab
