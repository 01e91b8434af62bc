#pragma once
// The field with its walls, stations, spots and robot starts, from a layout.

#include <vector>

#include "cx/base/random.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/layout.h"
#include "sim/world.h"

namespace cxlab::rcll {

/// The plan of a game: field 14 m x 8 m, origin in the middle of its lower edge, cyan's half x > 0. Walls as in the
/// rulebook's figure; stations in the order of the layout; robots robot1, robot2 ... of the playing teams in
/// their insertion areas, cyan's first.
sim::FloorPlan make_floor_plan(const Layout& layout, const std::vector<Team>& teams, int robots);

/// Spots that a round robot of `radius` (m) cannot serve. It cannot get from the team's insertion area to the pose
/// before the machine, or it does not fit at the working pose. In order of ids.
std::vector<sim::SpotId> unreachable_spots(const sim::FloorPlan& plan, double radius);

/// Draws a layout, again until every spot can be served; with the referee box's rules the first draw counts, and some
/// spots may be out of reach.
Layout draw_reachable_layout(RandomStream& random, const WorldConfig& config);

/// The plan of a scenario with that layout.
sim::FloorPlan floor_plan_of(const WorldConfig& config, const Layout& layout);

}  // namespace cxlab::rcll
