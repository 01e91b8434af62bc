#pragma once
// The world of a Logistics League game, `world: {kind: rcll, ...}` (docs/rcll.md), and the node that plays with an
// outside referee box, `servers: [league_client]` (docs/rcll-protocol.md).

#include "scenarios/catalogue.h"
#include "scenarios/rcll/game/game.h"

namespace cxlab::rcll {

extern const WorldKind kWorld;
extern const NodeKind kLeagueClient;

/// The game of a scenario whose world is of this kind.
Expected<Game> game_of(const Scenario& scenario);

}  // namespace cxlab::rcll
