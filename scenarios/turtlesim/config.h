#pragma once
// A turtlesim node as a scenario describes it: `world: {kind: turtlesim, ...}` or `{node: turtlesim, ...}` under
// `servers:`.

#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::turtlesim {

/// A turtle that is there when the node starts.
struct StartTurtle {
  std::string name = "turtle1";
  double x = 5.544445, y = 5.544445, theta = 0;  ///< m, m, rad

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("name", name);
    keys("x", x);
    keys("y", y);
    keys("theta", theta);
  }
};

struct Config {
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO
  SimTime start{};                                          ///< the node, its topics and services are not there before
  bool collisions = false;                                  ///< turtles push each other; in ROS they do not
  bool transforms = false;  ///< /tf has where each turtle is in "world"; in ROS another node's job
  int background_r = 69, background_g = 86, background_b = 255;
  std::vector<StartTurtle> turtles{{}};

  template <class Keys>
  void fields(Keys& keys) {
    keys("namespace", name_space);
    keys("remap", remaps);
    keys("start_s", start);
    keys("collisions", collisions);
    keys("transforms", transforms);
    keys("background_r", background_r);
    keys("background_g", background_g);
    keys("background_b", background_b);
    keys("turtles", turtles);
  }
};

/// The fault of the values, if they have one.
Status validate(const Config& config);
/// Whether a turtle can have that name: parts of letters, digits and '_' that begin with no digit, with '/' between
/// them.
bool is_turtle_name(const std::string& name);

}  // namespace cxlab::turtlesim
