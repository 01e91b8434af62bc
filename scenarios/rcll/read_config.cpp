#include "scenarios/rcll/read_config.h"

namespace cxlab::rcll {

namespace {

PlacedMachine read_machine(const yaml::Value& value) {
  PlacedMachine placed;
  placed.line = value.line();
  yaml::Map map = value.as_map();
  placed.machine = map.require("machine").as_string();
  placed.zone = map.require("zone").as_string();
  map.read("rotation", placed.rotation);
  map.finish();
  return placed;
}

OrderConfig read_order(const yaml::Value& value) {
  OrderConfig order;
  yaml::Map map = value.as_map();
  map.read("complexity", order.complexity).read("base_color", order.base_color).read("ring_colors", order.ring_colors);
  map.read("cap_color", order.cap_color).read("activate_at", order.activate_at);
  map.read("delivery_begin", order.delivery_begin).read("delivery_end", order.delivery_end);
  map.read("delivery_gate", order.delivery_gate)
      .read("quantity", order.quantity)
      .read("competitive", order.competitive);
  map.finish();
  return order;
}

}  // namespace

void read_config(yaml::Map& world, WorldConfig& config) {
  world.read("team", config.team).read("robots", config.robots).read("rules", config.rules);
  if (const yaml::Value layout = world.get("layout"))
    for (const yaml::Value& item : layout.as_list()) config.layout.push_back(read_machine(item));
  if (const yaml::Value orders = world.get("orders"))
    for (const yaml::Value& item : orders.as_list()) config.orders.push_back(read_order(item));
  world.read("complexities", config.complexities).read("exploration", config.exploration);
  world.read("setup_s", config.setup_s).read("production_s", config.production_s);
  world.read("down", config.down).read("transforms", config.transforms).read("shelf_refill_s", config.shelf_refill_s);
  if (Status s = validate(config); !s) {
    // "world.robots: found ...": said where that key stands.
    const std::string text = s.error().message.substr(std::string_view("world.").size());
    const std::size_t end = text.find_first_of(".[:");
    world.get(text.substr(0, end)).fail(text.substr(text[end] == ':' ? end + 2 : end));
  }
}

}  // namespace cxlab::rcll
