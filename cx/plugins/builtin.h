#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// The plugins that come with cxlab, under the names of the ROS 2 CX.
std::vector<PluginType> builtin_plugins();

/// Ordered facts that plugins and the environment manager assert, and what the journal reads of all rules.
std::span<const std::string_view> builtin_facts();

// Each of them, from the folder of its name; docs/plugins/NAME.md describes it.
PluginType ament_index_plugin();
PluginType bindings_plugin();
PluginType config_plugin();
PluginType example_plugin();
PluginType executive_plugin();
PluginType file_load_plugin();
PluginType linked_protobuf_plugin();  ///< of packages with their own messages
PluginType protobuf_plugin();
PluginType ros_msgs_plugin();
PluginType ros_param_plugin();
PluginType tf2_pose_tracker_plugin();

}  // namespace cxlab::cx
