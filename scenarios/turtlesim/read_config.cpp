#include "scenarios/turtlesim/read_config.h"

namespace cxlab::turtlesim {

namespace {

StartTurtle read_turtle(const yaml::Value& value) {
  StartTurtle turtle;
  yaml::Map map = value.as_map();
  turtle.name = map.require("name").as_string();
  map.read("x", turtle.x).read("y", turtle.y).read("theta", turtle.theta);
  map.finish();
  return turtle;
}

}  // namespace

void read_config(yaml::Map& map, Config& config) {
  map.read("namespace", config.name_space).read_seconds("start_s", config.start);
  if (const yaml::Value remap = map.get("remap"))
    for (const auto& [from, to] : remap.as_map().entries()) config.remaps.emplace_back(from, to.as_string());
  map.read("collisions", config.collisions).read("transforms", config.transforms);
  map.read("background_r", config.background_r)
      .read("background_g", config.background_g)
      .read("background_b", config.background_b);
  if (const yaml::Value turtles = map.get("turtles")) {
    config.turtles.clear();
    for (const yaml::Value& turtle : turtles.as_list()) config.turtles.push_back(read_turtle(turtle));
  }
  if (Status s = validate(config); !s) {
    // "turtles: found ...": said where that key stands.
    const std::string& text = s.error().message;
    const std::size_t end = text.find(':');
    map.get(text.substr(0, end)).fail(text.substr(end + 2));
  }
}

}  // namespace cxlab::turtlesim
