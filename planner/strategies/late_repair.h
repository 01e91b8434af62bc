#pragma once
// Strategy: for problems with events. A sequence of whole actions is found without regard to when events end what it
// needs; then improvement moves its actions until it comes in time.

#include "planner/strategies/sequence_search.h"

namespace cxlab::planner {

/// Moves and replaces the actions of a list until none is late. True if a plan exists afterwards.
bool bring_in_time(PlanningContext& context, Sequence list, const Turn& turn);

/// One turn to find a sequence, and up to two more to bring it in time. True if a plan exists afterwards.
bool repair_late(PlanningContext& context, SequenceSearch& sequences, const Turn& turn);

}  // namespace cxlab::planner
