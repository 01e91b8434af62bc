#pragma once
// What a game adds to result.json and to the score board (docs/contracts.md 4).

#include <span>
#include <string>
#include <vector>

#include "scenarios/rcll/factory.h"
#include "scenarios/result.h"
#include "sim/skills/fleet.h"

namespace cxlab::rcll {

/// Points, orders and deliveries.
void report_game(const Factory& factory, Result& result);
/// The robots, after the game's sections; contacts are counted by the floor.
void report_robots(std::span<const sim::RobotStats> robots, std::span<const Maintenance::Robot> duties,
                   const sim::World& floor, Result& result);
/// One of everything.
void add_sample(Result& sample);

}  // namespace cxlab::rcll
