#include "cx/plugins/ros_msgs/ros_msgs_plugin.h"

#include "cx/plugins/ros_msgs/ros_interface.h"

namespace cxlab::cx {

namespace {

/// The bus for rules, with any message type.
class RosMsgsPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard environment) override {
    const Status installed = interfaces_.add(*environment, *environment, name()).install();
    if (!installed) interfaces_.remove(*environment);
    return installed;
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    interfaces_.find(*environment)->close(left_);
    interfaces_.remove(*environment);
  }

  void finalize() override {
    for (const std::string& line : left_.lines()) log(LogLevel::kWarn, line);
  }

 private:
  PerEnvironment<RosInterface> interfaces_;
  Leftovers left_;
};

}  // namespace

PluginType ros_msgs_plugin() {
  return {"cx::RosMsgsPlugin", {}, [](PluginContext c) { return std::make_unique<RosMsgsPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
