#include "scenarios/rcll/game/game.h"

#include <chrono>

#include "cx/base/random.h"
#include "cx/base/time.h"
#include "cx/yaml/writer.h"
#include "cx/yaml/yaml.h"
#include "scenarios/rcll/game/floor_plan.h"

namespace cxlab::rcll {
namespace {

Expected<GameFile> read_file_of_game(const WorldConfig& config) {
  GameFile file;
  if (config.game.empty()) return file;
  auto document = yaml::Document::load(config.game);
  if (!document) return document.error();
  yaml::Map map = document->root().as_map();
  map.read(file);
  if (const Status s = check_times(file, config); !s) map.fail(s.error());
  map.finish();
  if (Status s = document->status(); !s) return s.error();
  return file;
}

std::vector<Order> read_orders(const std::vector<OrderConfig>& listed) {
  std::vector<Order> orders;
  for (const OrderConfig& order : listed) orders.push_back(read_order(order, static_cast<int>(orders.size()) + 1));
  return orders;
}

/// Ring prices, the ten orders and the one of overtime are drawn in this order, those that are listed too.
void set_orders(const WorldConfig& config, const GameFile& file, std::uint64_t seed, Game& game) {
  std::vector<Complexity> allowed;
  for (const std::string& name : config.complexities) allowed.push_back(*named<Complexity>(name));
  RandomStream random(seed, "orders");
  game.schedule = draw_schedule(random, allowed);
  const Order overtime = draw_overtime_order(random, config.production_s, config.production_s + config.overtime_s);

  if (file.ring_prices) game.schedule.ring_prices = file.ring_prices->prices;
  if (file.orders || !config.orders.empty())
    game.schedule.orders = read_orders(file.orders ? *file.orders : config.orders);
  if (config.overtime_s == 0) return;
  const int id = static_cast<int>(game.schedule.orders.size()) + 1;
  game.overtime = file.overtime ? read_order(*file.overtime, id) : overtime;
  game.overtime->id = id;
  game.overtime->overtime = true;
}

Expected<Layout> layout_of(const WorldConfig& config, const GameFile& file, std::uint64_t seed) {
  if (file.layout) return read_layout(*file.layout, "layout");
  if (!config.layout.empty()) return read_layout(config.layout);
  RandomStream random(seed, "layout");
  return draw_reachable_layout(random, config);
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
  const auto file = read_file_of_game(config);
  if (!file) return file.error();
  Game game;
  auto layout = layout_of(config, *file, seed);
  if (!layout) return layout.error();
  game.layout = *std::move(layout);

  set_orders(config, *file, seed, game);
  if (config.down) {
    RandomStream random(seed, "machines");
    game.down = file->down ? *file->down : draw_down_periods(random, config.production_s);
  }
  return game;
}

std::string to_yaml(const Game& game) {
  GameFile file;
  file.layout = listed(game.layout);
  if (!check_mirrored(*file.layout, game.layout, "layout")) file.mirrored = false;
  file.ring_prices = RingPriceConfig{game.schedule.ring_prices};
  file.orders.emplace();
  for (const Order& order : game.schedule.orders) file.orders->push_back(listed(order));
  if (game.overtime) file.overtime = listed(*game.overtime);
  file.down = game.down;
  yaml::Writer out = yaml::Writer::of(file);
  if (file.down->empty()) out.put_yaml("down", "[]");
  return out.text();
}

}  // namespace cxlab::rcll
