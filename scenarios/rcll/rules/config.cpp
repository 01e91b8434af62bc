#include "scenarios/rcll/rules/config.h"

#include <algorithm>

#include "cx/base/number_text.h"
#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {
namespace {

Error bad_value(const std::string& key, const std::string& found, const std::string& expected) {
  return input_error(key + ": " + found_expected(found, expected));
}

Error bad_word(const std::string& key, const std::string& found, const std::vector<std::string>& words) {
  std::string expected;
  for (const std::string& word : words) expected += (expected.empty() ? "" : ", ") + word;
  const std::string near = nearest_word(found, words);
  return bad_value(key, "'" + found + "'",
                   "one of " + expected + (near.empty() ? "" : " (did you mean " + near + "?)"));
}

template <class Enum>
Status check_word(const std::string& key, const std::string& found) {
  if (named<Enum>(found)) return {};
  std::vector<std::string> words(kNames<Enum>.begin(), kNames<Enum>.end());
  std::erase(words, "");
  return bad_word(key, found, words);
}

Status check_range(const std::string& key, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return bad_value(key, general_text(value, 10), general_text(low, 10) + " to " + general_text(high, 10));
}

Status check_order(const std::string& key, const OrderConfig& order) {
  if (Status s = check_word<Complexity>(key + ".complexity", order.complexity); !s) return s;
  const auto base = named<BaseColor>(order.base_color);
  if (!base || *base == BaseColor::kClear)
    return bad_word(key + ".base_color", order.base_color, {"BASE_RED", "BASE_BLACK", "BASE_SILVER"});
  for (const std::string& ring : order.ring_colors)
    if (Status s = check_word<RingColor>(key + ".ring_colors", ring); !s) return s;
  if (const auto same = std::ranges::adjacent_find(order.ring_colors); same != order.ring_colors.end())
    return bad_value(key + ".ring_colors", *same + " on " + *same, "another colour than that of the ring below");
  if (Status s = check_word<CapColor>(key + ".cap_color", order.cap_color); !s) return s;
  const auto rings = static_cast<std::size_t>(*named<Complexity>(order.complexity));
  if (order.ring_colors.size() != rings)
    return bad_value(key + ".ring_colors", std::to_string(order.ring_colors.size()) + " rings",
                     std::to_string(rings) + " for a " + order.complexity);
  if (Status s = check_range(key + ".activate_at", order.activate_at, 0, 1e6); !s) return s;
  if (Status s = check_range(key + ".delivery_begin", order.delivery_begin, 0, 1e6); !s) return s;
  if (Status s = check_range(key + ".delivery_gate", order.delivery_gate, 1, 3); !s) return s;
  if (Status s = check_range(key + ".quantity", order.quantity, 1, 1000); !s) return s;
  if (!(order.delivery_end > order.delivery_begin))
    return bad_value(key + ".delivery_end", general_text(order.delivery_end, 10), "a time after delivery_begin");
  if (!(order.activate_at < order.delivery_end))
    return bad_value(key + ".activate_at", general_text(order.activate_at, 10), "a time before delivery_end");
  return check_range(key + ".delivery_end", order.delivery_end, 0, 1e7);
}

Status check_down(const std::string& key, const DownPeriodConfig& period) {
  const auto known = [](std::string_view machine) { return std::ranges::find(kMachines, machine) != kMachines.end(); };
  if (const std::string type = period.machine.substr(period.machine.find('-') + 1);
      !known(period.machine) && known(type))
    return bad_value(key + ".machine", "'" + period.machine + "'", type + ": it is down for both teams");
  if (!known(period.machine)) return bad_word(key + ".machine", period.machine, {kMachines.begin(), kMachines.end()});
  if (Status s = check_range(key + ".begin_s", period.begin_s, 0, 1e6); !s) return s;
  if (!(period.end_s > period.begin_s))
    return bad_value(key + ".end_s", general_text(period.end_s, 10), "a time after begin_s");
  return check_range(key + ".end_s", period.end_s, 0, 1e7);
}

/// A time that lies in the game.
Status check_in_game(const std::string& key, double time, double end) {
  if (time < end) return {};
  return bad_value(key, general_text(time, 10), "a time before the end of the game at " + general_text(end, 10));
}

Status check_window(const std::string& key, const OrderConfig& order, double end) {
  if (Status s = check_in_game(key + ".activate_at", order.activate_at, end); !s) return s;
  return check_in_game(key + ".delivery_begin", order.delivery_begin, end);
}

// A game of the league that is cut short keeps its orders.
constexpr double kProductionS = 1200, kOvertimeS = 300;
double latest_order(const WorldConfig& config) { return std::max(config.production_s, kProductionS); }
double latest_end(const WorldConfig& config) { return latest_order(config) + std::max(config.overtime_s, kOvertimeS); }

Status check_windows(const std::string& key, const std::vector<OrderConfig>& orders, double end) {
  for (std::size_t i = 0; i < orders.size(); ++i)
    if (Status s = check_window(key + "[" + std::to_string(i) + "]", orders[i], end); !s) return s;
  return {};
}

/// A machine is not down twice at a time.
Status check_apart(const std::vector<DownPeriodConfig>& periods) {
  for (std::size_t i = 0; i < periods.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (periods[i].machine == periods[k].machine && periods[i].begin_s < periods[k].end_s &&
          periods[k].begin_s < periods[i].end_s)
        return bad_value("down[" + std::to_string(i) + "].begin_s", general_text(periods[i].begin_s, 10),
                         "a time at which " + periods[i].machine + " is not down: down[" + std::to_string(k) +
                             "] is from " + general_text(periods[k].begin_s, 10) + " to " +
                             general_text(periods[k].end_s, 10));
  return {};
}

Status check_pauses(const WorldConfig& config) {
  for (std::size_t i = 0; i < config.pauses.size(); ++i) {
    const PauseConfig& pause = config.pauses[i];
    const std::string key = "world.pauses[" + std::to_string(i) + "]";
    const double end = config.production_s + config.overtime_s;
    if (!(pause.at >= 0 && pause.at < end))
      return bad_value(key + ".at", general_text(pause.at, 10),
                       "s of production, from 0 to before " + general_text(end, 10));
    if (!(pause.seconds > 0 && pause.seconds <= 1e6))
      return bad_value(key + ".for", general_text(pause.seconds, 10), "s, more than 0 and at most 1000000");
    for (std::size_t k = 0; k < i; ++k)
      if (config.pauses[k].at == pause.at)
        return bad_value(key + ".at", general_text(pause.at, 10),
                         "another time than that of pauses[" + std::to_string(k) + "]: the game's time stands in it");
  }
  return {};
}

}  // namespace

RuleChoices choices_of(Rules rules) {
  const bool rulebook = rules == Rules::kRulebook;
  return {.shelf_faces_wall = rules == Rules::kRefbox,
          .late_in_fifths = rulebook,
          .second_prepare_breaks = rulebook,
          .delivery_may_wait = rulebook,
          .down_stops_work = rulebook,
          .second_keeps_points = rulebook,
          .by_hand = rulebook,
          .overtime_at_nil = !rulebook,
          .sudden_death = rulebook,
          .storage_serves_one = rulebook,
          .down_hides_broken = !rulebook,
          .unpaid_again_waits = !rulebook,
          .reports_by_type = !rulebook,
          .surplus_cap_counts = !rulebook,
          .report_hides_broken = !rulebook};
}

std::vector<Team> teams_of(const WorldConfig& config) {
  if (const auto team = named<Team>(config.team)) return {*team};
  return {kTeams.begin(), kTeams.end()};
}

Status validate(const WorldConfig& config) {
  if (config.team != "BOTH" && !named<Team>(config.team))
    return bad_word("world.team", config.team, {"CYAN", "MAGENTA", "BOTH"});
  if (Status s = check_word<Information>("world.information", config.information); !s) return s;
  if (Status s = check_word<Rules>("world.rules", config.rules); !s) return s;
  if (Status s = check_range("world.robots", config.robots, 0, 3); !s) return s;
  if (Status s = check_range("world.setup_s", config.setup_s, 0, 1e6); !s) return s;
  if (Status s = check_range("world.production_s", config.production_s, 1, 1e6); !s) return s;
  if (Status s = check_range("world.overtime_s", config.overtime_s, 0, 1e6); !s) return s;
  if (Status s = check_range("world.post_game_s", config.post_game_s, 0, 1e6); !s) return s;
  if (Status s = check_range("world.shelf_refill_s", config.shelf_refill_s, 0, 1e6); !s) return s;
  if (Status s = check_range("world.repair_s", config.repair_s, 0, 1e6); !s) return s;
  if (Status s = check_range("world.refbox.port_shift", config.refbox.port_shift, -1000, 60000); !s) return s;
  if (Status s = check_pauses(config); !s) return s;
  for (const std::string& complexity : config.complexities)
    if (Status s = check_word<Complexity>("world.complexities", complexity); !s) return s;
  if (!config.orders.empty() && !config.complexities.empty())
    return bad_value("world.complexities", "a list beside world.orders", "only one of the two");
  if (!config.game.empty() && !config.orders.empty())
    return bad_value("world.orders", "a list beside world.game", "only one of the two: list them in the file");
  if (!config.game.empty() && !config.layout.empty())
    return bad_value("world.layout", "a list beside world.game", "only one of the two: list it in the file");
  for (std::size_t i = 0; i < config.orders.size(); ++i)
    if (Status s = check_order("world.orders[" + std::to_string(i) + "]", config.orders[i]); !s) return s;
  return check_windows("world.orders", config.orders, latest_order(config));
}

Status validate(const GameFile& file) {
  if (file.layout) {
    const auto layout = read_layout(*file.layout, "layout");
    if (!layout) return layout.error();
    if (file.mirrored.value_or(true))
      if (Status s = check_mirrored(*file.layout, *layout, "layout"); !s) return s;
  }
  if (file.ring_prices)
    for (const RingColor color : kRingColors)
      if (Status s = check_range("ring_prices." + std::string(to_string(color)),
                                 file.ring_prices->prices[static_cast<std::size_t>(color) - 1], 0, 2);
          !s)
        return s;
  if (file.orders && file.orders->empty())
    return bad_value("orders", "an empty list", "an order at least; without this key they are drawn");
  if (file.orders)
    for (std::size_t i = 0; i < file.orders->size(); ++i)
      if (Status s = check_order("orders[" + std::to_string(i) + "]", (*file.orders)[i]); !s) return s;
  if (file.overtime)
    if (Status s = check_order("overtime", *file.overtime); !s) return s;
  if (file.down)
    for (std::size_t i = 0; i < file.down->size(); ++i)
      if (Status s = check_down("down[" + std::to_string(i) + "]", (*file.down)[i]); !s) return s;
  return file.down ? check_apart(*file.down) : Status();
}

Status check_times(const GameFile& file, const WorldConfig& config) {
  if (file.orders)
    if (Status s = check_windows("orders", *file.orders, latest_order(config)); !s) return s;
  if (file.overtime)
    if (Status s = check_window("overtime", *file.overtime, latest_end(config)); !s) return s;
  for (std::size_t i = 0; file.down && i < file.down->size(); ++i)
    if (Status s =
            check_in_game("down[" + std::to_string(i) + "].begin_s", (*file.down)[i].begin_s, latest_end(config));
        !s)
      return s;
  return {};
}

}  // namespace cxlab::rcll
