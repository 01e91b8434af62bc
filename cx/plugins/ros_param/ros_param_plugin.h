#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::RosParamPlugin: docs/plugins/ros_param.md.
PluginType ros_param_plugin();

}  // namespace cxlab::cx
