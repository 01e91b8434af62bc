#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::Tf2PoseTrackerPlugin: docs/plugins/tf2_pose_tracker.md.
PluginType tf2_pose_tracker_plugin();

}  // namespace cxlab::cx
