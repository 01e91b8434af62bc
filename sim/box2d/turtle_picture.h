#pragma once
// Pictures of a canvas of turtles: background, ink, turtles on top. Software only; moves nothing.

#include "sim/box2d/turtle_world.h"
#include "sim/picture.h"

namespace cxlab::sim {

/// `side` x `side` pixels, 16 or more; the canvas has 500.
Picture draw_turtles(const TurtleWorld& world, int side = Canvas::kSize);

}  // namespace cxlab::sim
