#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::RosMsgsPlugin: docs/plugins/ros_msgs.md.
PluginType ros_msgs_plugin();

}  // namespace cxlab::cx
