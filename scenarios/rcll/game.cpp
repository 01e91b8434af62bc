#include "scenarios/rcll/game.h"

#include <chrono>

#include "cx/base/random.h"
#include "cx/base/time.h"
#include "scenarios/rcll/floor_plan.h"

namespace cxlab::rcll {
namespace {

Expected<Layout> layout_of(const WorldConfig& config, std::uint64_t seed) {
  if (!config.layout.empty()) return read_layout(config.layout);
  RandomStream random(seed, "layout");
  return draw_reachable_layout(random, config);
}

/// Ring prices, the ten orders and the one of overtime, in this order.
void draw_orders(const WorldConfig& config, std::uint64_t seed, Game& game) {
  std::vector<Complexity> allowed;
  for (const std::string& name : config.complexities) allowed.push_back(*named<Complexity>(name));
  RandomStream random(seed, "orders");
  game.schedule = draw_schedule(random, allowed);
  game.overtime = draw_overtime_order(random);
  game.overtime.overtime = true;
  game.overtime.activate_at = game.overtime.delivery_begin = config.production_s;
  game.overtime.delivery_end = config.production_s + config.overtime_s;
}

std::vector<Order> read_orders(const std::vector<OrderConfig>& listed) {
  std::vector<Order> orders;
  for (const OrderConfig& order : listed) orders.push_back(read_order(order, static_cast<int>(orders.size()) + 1));
  return orders;
}

/// One ring and one cap station, the same of both teams, are down once in production: 30 to 60 s, not before 180 s.
/// Too short a game for that has no down periods.
std::vector<DownPeriodConfig> draw_down_periods(RandomStream& random, double production_s) {
  constexpr std::int64_t kEarliest = 180, kShortest = 30, kLongest = 60;
  const std::int64_t production = std::chrono::duration_cast<std::chrono::seconds>(from_seconds(production_s)).count();
  std::vector<DownPeriodConfig> periods;
  if (production < kEarliest + kLongest) return periods;
  for (const std::string kind : {"RS", "CS"}) {
    const std::string machine = kind + (random.chance(0.5) ? "1" : "2");
    const std::int64_t duration = random.between(kShortest, kLongest);
    const std::int64_t begin = random.between(kEarliest, production - duration);
    periods.push_back({machine, static_cast<double>(begin), static_cast<double>(begin + duration)});
  }
  return periods;
}

}  // namespace

Expected<Game> game_of(const WorldConfig& config, std::uint64_t seed) {
  if (Status s = validate(config); !s) return s.error();
  Game game;
  auto layout = layout_of(config, seed);
  if (!layout) return layout.error();
  game.layout = *std::move(layout);
  draw_orders(config, seed, game);
  if (!config.orders.empty()) game.schedule.orders = read_orders(config.orders);
  game.overtime.id = static_cast<int>(game.schedule.orders.size()) + 1;
  if (config.down) {
    RandomStream random(seed, "machines");
    game.down = draw_down_periods(random, config.production_s);
  }
  return game;
}

}  // namespace cxlab::rcll
