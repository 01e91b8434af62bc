#pragma once
// What a game adds to result.json and to the score board (docs/reference/contracts.md 4).

#include <span>
#include <string>
#include <vector>

#include "scenarios/catalogue.h"
#include "scenarios/rcll/game/factory.h"
#include "scenarios/result.h"
#include "sim/skills/fleet.h"

namespace cxlab::rcll {

/// Points: the section `teams`.
void report_teams(const Factory& factory, Result& result);
/// The sections `orders` and `deliveries`.
void report_orders(const Factory& factory, Result& result);
/// The section `robots`; contacts are counted by the floor.
void report_robots(std::span<const sim::RobotStats> robots, std::span<const Maintenance::Robot> duties,
                   const sim::World& floor, Result& result);
// One of everything.
std::string sample_teams();
std::string sample_orders();
std::string sample_deliveries();
std::string sample_robots();

inline constexpr ResultSection kSections[]{
    {.key = "teams", .what = "points of each team", .initial = "{}", .sample = sample_teams},
    {.key = "orders", .what = "what was ordered, and when it was delivered", .initial = "[]", .sample = sample_orders},
    {.key = "deliveries", .what = "what was brought to a gate", .initial = "[]", .sample = sample_deliveries},
    {.key = "robots", .what = "the work of each robot", .initial = "[]", .sample = sample_robots},
};

}  // namespace cxlab::rcll
