#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

/// The least that a plugin can be: says when its environments go; the manager says when they come.
class ExamplePlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard) override { return {}; }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    log(*environment, LogLevel::kInfo, "Destroying plugin for environment " + environment->name());
  }
};

}  // namespace

PluginType example_plugin() {
  return {"cx::ExamplePlugin", {}, [](PluginContext c) { return std::make_unique<ExamplePlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
