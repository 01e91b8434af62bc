#pragma once

#include <vector>

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// The plugins that come with cxlab, under the names of the ROS 2 CX.
std::vector<PluginType> builtin_plugins();

}  // namespace cxlab::cx
