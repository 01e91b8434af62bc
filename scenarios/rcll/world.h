#pragma once
// The world of a Logistics League game, `world: {kind: rcll, ...}` (docs/reference/rcll.md).

#include "scenarios/catalogue.h"
#include "scenarios/rcll/game/game.h"

namespace cxlab::rcll {

extern const WorldKind kWorld;

/// The game of a scenario whose world is of this kind.
Expected<Game> game_of(const Scenario& scenario);

}  // namespace cxlab::rcll
