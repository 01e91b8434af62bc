#pragma once
// Looks at a world, whatever its kind.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/stage.h"
#include "sim/box2d/turtle_world.h"
#include "sim/mujoco/physics_gate.h"
#include "sim/picture.h"
#include "sim/world.h"

namespace cxlab::lab {

class View {
 public:
  virtual ~View() = default;
  /// The world as it is now. The picture is the view's own and lasts until the next call.
  virtual Expected<const sim::Picture*> draw(std::string_view camera) = 0;
  /// The first is the one to choose where nothing is said.
  virtual std::vector<std::string> cameras() const = 0;
};

/// Worlds must outlive their view. A factory's needs OpenGL; a canvas is as large a square as fits in.
Expected<std::unique_ptr<View>> view_of_factory(const sim::FloorPlan& plan, const sim::PhysicsGate& world, int width,
                                                int height);
std::unique_ptr<View> view_of_turtles(const sim::TurtleWorld& world, int width, int height);
/// Of an episode's world. kInput where there is nothing to look at.
Expected<std::unique_ptr<View>> view_of(const Stage& stage, int width, int height);

}  // namespace cxlab::lab
