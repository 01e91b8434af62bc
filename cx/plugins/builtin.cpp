#include "cx/plugins/builtin.h"

namespace cxlab::cx {

std::vector<PluginType> builtin_plugins() {
  return {ament_index_plugin(), bindings_plugin(),  config_plugin(),          example_plugin(),
          executive_plugin(),   file_load_plugin(), protobuf_plugin(),        linked_protobuf_plugin(),
          ros_msgs_plugin(),    ros_param_plugin(), tf2_pose_tracker_plugin()};
}

std::span<const std::string_view> builtin_facts() {
  static constexpr std::string_view kFacts[] = {"time",
                                                "executive-finalize",
                                                "protobuf-client-connected",
                                                "protobuf-client-disconnected",
                                                "protobuf-server-client-connected",
                                                "protobuf-server-client-disconnected",
                                                "decision"};
  return kFacts;
}

}  // namespace cxlab::cx
