#pragma once
// The bodies of a floor that no physics moves: they are posed for each picture. Pictures of both tiers so have the same
// bodies and the same renderer.

#include <memory>

#include "cx/base/expected.h"
#include "sim/floor_pose.h"
#include "sim/mujoco/physics_gate.h"

namespace cxlab::sim {

class PosedFloor {
 public:
  static constexpr int kMostPieces = 120;  ///< those beyond are not shown

  /// Fails as `build_factory` does. `options.pieces` is not used.
  static Expected<std::unique_ptr<PosedFloor>> create(const FloorPlan& plan, ModelOptions options);

  /// At that time (s), which says whether a light that blinks is lit.
  void pose(const FloorPose& pose, double time);
  /// What a `Renderer` draws.
  const PhysicsGate& gate() const { return gate_; }

 private:
  PosedFloor(FactoryModel factory, const FloorPlan& plan) : gate_(std::move(factory), plan) {}

  PhysicsGate gate_;
  std::vector<Stack> shown_;  ///< by body of the pool
};

}  // namespace cxlab::sim
