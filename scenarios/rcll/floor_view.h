#pragma once
// Pictures of a game, the same for both tiers: the factory's bodies as physics has them or as a scene shows them, and
// the board above and below.

#include <functional>
#include <memory>

#include "scenarios/rcll/story/board.h"
#include "scenarios/scene.h"
#include "scenarios/view.h"
#include "sim/mujoco/physics_gate.h"

namespace cxlab::rcll {

/// The board at a time; empty: pictures have none.
using BoardAt = std::function<Board(SimTime)>;

/// `plan` and `floor` outlive the view.
Expected<std::unique_ptr<View>> view_of_physics(const sim::FloorPlan& plan, const sim::PhysicsGate& floor,
                                                BoardAt board, int width, int height);
/// `scene` says what there is to see at a time; `plan` outlives the view.
Expected<std::unique_ptr<View>> view_of_scene(const sim::FloorPlan& plan, const sim::ModelOptions& options,
                                              std::function<Scene(SimTime)> scene, BoardAt board, int width,
                                              int height);

}  // namespace cxlab::rcll
