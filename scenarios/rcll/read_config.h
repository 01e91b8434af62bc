#pragma once
// Reads `world:` of a scenario of kind rcll.

#include "cx/yaml/yaml.h"
#include "scenarios/rcll/config.h"

namespace cxlab::rcll {

/// Keys that are missing keep their defaults; errors go to the document. The caller finishes the map.
void read_config(yaml::Map& world, WorldConfig& config);

}  // namespace cxlab::rcll
