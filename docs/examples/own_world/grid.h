#pragma once
// A world of one's own: a robot that steps from cell to cell of a grid, bumps into walls, and looks for the goal.

#include <scenarios/catalogue.h>

namespace grid {

/// `world: {kind: grid, ...}`. The robot serves /grid/move (srv/Move.srv); the game ends when it is at the goal.
extern const cxlab::WorldKind kWorld;

}  // namespace grid
