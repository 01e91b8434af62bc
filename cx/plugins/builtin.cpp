#include "cx/plugins/builtin.h"

#include "cx/plugins/ament_index/ament_index_plugin.h"
#include "cx/plugins/config/config_plugin.h"
#include "cx/plugins/executive/executive_plugin.h"
#include "cx/plugins/file_load/file_load_plugin.h"
#include "cx/plugins/ros_msgs/ros_msgs_plugin.h"

namespace cxlab::cx {

std::vector<PluginType> builtin_plugins() {
  return {ament_index_plugin(), config_plugin(), executive_plugin(), file_load_plugin(), ros_msgs_plugin()};
}

}  // namespace cxlab::cx
