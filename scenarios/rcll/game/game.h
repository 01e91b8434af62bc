#pragma once
// Everything that is drawn for a game: places of machines, prices of rings, orders, and down times.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/rcll/rules/orders.h"

namespace cxlab::rcll {

struct Game {
  Layout layout;
  Schedule schedule;              ///< ring prices and the orders of production
  std::optional<Order> overtime;  ///< one more, published only there; its id follows those of the schedule
  std::vector<DownPeriodConfig> down;
};

/// The game of a scenario: what the configuration or the file that it names lists, the rest drawn from `seed`. Layout,
/// orders and down periods have a stream each ("layout", "orders", "machines"), so that listing one leaves the others
/// as they are.
Expected<Game> game_of(const WorldConfig& config, std::uint64_t seed);

/// The whole game as a file that `WorldConfig::game` can name (GameFile).
std::string to_yaml(const Game& game);

}  // namespace cxlab::rcll
