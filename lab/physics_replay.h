#pragma once
// The physics of a recorded run, again.

#include <memory>
#include <string>

#include "cx/base/scratch_folder.h"
#include "lab/run.h"
#include "scenarios/stage.h"

namespace cxlab::lab {

class PhysicsOfRun {
 public:
  /// The world at the start, from the run's own models. kInput if the run has no physics.
  static Expected<PhysicsOfRun> load(const Run& run);

  /// How reading the log ended, and where.
  const Status& log_status() const { return log_status_; }
  SimTime log_end() const { return log_end_; }

  /// As far as the physics had come at `t`.
  Status advance_to(SimTime t) { return world_->advance_to(t); }
  /// As in result.json.
  std::string hash() const { return world_->hash(); }
  Expected<std::unique_ptr<View>> view(int width, int height) const { return world_->view(width, height); }

 private:
  PhysicsOfRun() = default;

  std::unique_ptr<ScratchFolder> scratch_;
  // At fixed places: the replay views them.
  std::unique_ptr<Scenario> scenario_;
  std::unique_ptr<std::string> log_;
  Status log_status_;
  SimTime log_end_{};
  std::unique_ptr<WorldReplay> world_;
};

}  // namespace cxlab::lab
