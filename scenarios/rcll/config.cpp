#include "scenarios/rcll/config.h"

namespace cxlab::rcll {
namespace {

Error bad_value(const std::string& key, const std::string& found, const std::string& expected) {
  return input_error("world." + key + ": found " + found + ", expected " + expected);
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
  const auto text = [](double v) {
    std::string digits = std::to_string(v);
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.ends_with('.')) digits.pop_back();
    return digits;
  };
  if (value >= low && value <= high) return {};
  return bad_value(key, text(value), text(low) + " to " + text(high));
}

Status check_order(const std::string& key, const OrderConfig& order) {
  if (Status s = check_word<Complexity>(key + ".complexity", order.complexity); !s) return s;
  const auto base = named<BaseColor>(order.base_color);
  if (!base || *base == BaseColor::kClear)
    return bad_word(key + ".base_color", order.base_color, {"BASE_RED", "BASE_BLACK", "BASE_SILVER"});
  for (const std::string& ring : order.ring_colors)
    if (Status s = check_word<RingColor>(key + ".ring_colors", ring); !s) return s;
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
    return bad_value(key + ".delivery_end", std::to_string(order.delivery_end), "a time after delivery_begin");
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
          .storage_serves_one = rulebook};
}

Status validate(const WorldConfig& config) {
  if (Status s = check_word<Team>("team", config.team); !s) return s;
  if (Status s = check_word<Rules>("rules", config.rules); !s) return s;
  if (Status s = check_range("robots", config.robots, 0, 3); !s) return s;
  if (Status s = check_range("setup_s", config.setup_s, 0, 1e6); !s) return s;
  if (Status s = check_range("production_s", config.production_s, 1, 1e6); !s) return s;
  if (Status s = check_range("overtime_s", config.overtime_s, 0, 1e6); !s) return s;
  if (Status s = check_range("shelf_refill_s", config.shelf_refill_s, 0, 1e6); !s) return s;
  if (config.exploration) return bad_value("exploration", "true", "false: not supported in this release");
  for (const std::string& complexity : config.complexities)
    if (Status s = check_word<Complexity>("complexities", complexity); !s) return s;
  if (!config.orders.empty() && !config.complexities.empty())
    return bad_value("complexities", "a list beside world.orders", "only one of the two");
  for (std::size_t i = 0; i < config.orders.size(); ++i)
    if (Status s = check_order("orders[" + std::to_string(i) + "]", config.orders[i]); !s) return s;
  return {};
}

}  // namespace cxlab::rcll
