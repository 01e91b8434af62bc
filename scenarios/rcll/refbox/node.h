#pragma once
// The node that plays with an outside referee box, `servers: [league_client]` (docs/reference/rcll-protocol.md).

#include "scenarios/catalogue.h"

namespace cxlab::rcll {

extern const NodeKind kLeagueClient;

}  // namespace cxlab::rcll
