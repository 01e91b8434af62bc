#include "scenarios/turtlesim/config.h"

#include <cmath>
#include <set>

#include "cx/bus/names.h"

namespace cxlab::turtlesim {

bool is_turtle_name(const std::string& name) {
  bool part_begins = true;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    const bool digit = c >= '0' && c <= '9';
    if (part_begins ? !letter : !(letter || digit || c == '/')) return false;
    part_begins = c == '/';
  }
  return !part_begins;
}

Status validate(const Config& config) {
  for (const auto& [name, value] : {std::pair("background_r", config.background_r),
                                    {"background_g", config.background_g},
                                    {"background_b", config.background_b}})
    if (value < 0 || value > 255)
      return input_error(std::string(name) + ": " + found_expected(std::to_string(value), "0 to 255"));
  if (Status s = bus::check_node(config.name_space, config.remaps); !s) return s;
  std::set<std::string> names;
  for (const StartTurtle& turtle : config.turtles) {
    if (!is_turtle_name(turtle.name))
      return input_error("turtles: " + found_expected("the name '" + turtle.name + "'", "letters, digits and '_'"));
    if (!names.insert(turtle.name).second) return input_error("turtles: two turtles are named '" + turtle.name + "'");
    if (!std::isfinite(turtle.x) || !std::isfinite(turtle.y) || !std::isfinite(turtle.theta))
      return input_error("turtles: the place of '" + turtle.name + "' is no number");
  }
  return {};
}

}  // namespace cxlab::turtlesim
