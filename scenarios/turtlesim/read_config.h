#pragma once
// Reads the keys of a turtlesim node from `world:` or from an item of `servers:`.

#include "cx/yaml/yaml.h"
#include "scenarios/turtlesim/config.h"

namespace cxlab::turtlesim {

/// Keys that are missing keep their defaults; errors go to the document. The caller finishes the map.
void read_config(yaml::Map& map, Config& config);

}  // namespace cxlab::turtlesim
