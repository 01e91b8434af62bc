#include "cx/plugins/builtin.h"

#include "cx/plugins/ament_index/ament_index_plugin.h"
#include "cx/plugins/bindings/bindings_plugin.h"
#include "cx/plugins/config/config_plugin.h"
#include "cx/plugins/example/example_plugin.h"
#include "cx/plugins/executive/executive_plugin.h"
#include "cx/plugins/file_load/file_load_plugin.h"
#include "cx/plugins/ros_msgs/ros_msgs_plugin.h"
#include "cx/plugins/ros_param/ros_param_plugin.h"
#include "cx/plugins/tf2_pose_tracker/tf2_pose_tracker_plugin.h"

namespace cxlab::cx {

std::vector<PluginType> builtin_plugins() {
  return {ament_index_plugin(), bindings_plugin(), config_plugin(),    example_plugin(),         executive_plugin(),
          file_load_plugin(),   ros_msgs_plugin(), ros_param_plugin(), tf2_pose_tracker_plugin()};
}

}  // namespace cxlab::cx
