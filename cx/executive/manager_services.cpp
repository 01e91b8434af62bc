// The services of the environment manager: list, create and destroy environments; list, load and unload plugins.

#include "cx/executive/environment_manager.h"

namespace cxlab::cx {

Status EnvironmentManager::serve_environments() {
  if (!environment_services_.empty()) return {};
  auto made = serve(bus_, node_, "~/list_envs", "cx_msgs/srv/ListClipsEnvs", [this](const auto&, const auto& response) {
    for (const std::string& name : environment_names()) response.append_text("envs", name);
    response.set("success", true);
  });
  if (!made) return made.error();
  environment_services_.push_back(*made);
  return {};
}

Status EnvironmentManager::serve_plugins() {
  if (!plugin_services_.empty()) return {};
  const auto answer = [](const Status& done, const bus::MessageView& response) {
    response.set("success", done.ok());
    if (!done) response.set("error", done.error().message);
  };
  struct Service {
    const char *name, *type;
    std::function<void(const bus::MessageView& request, const bus::MessageView& response)> act;
  };
  const Service services[] = {
      {"~/create_env", "cx_msgs/srv/CreateClipsEnv",
       [this, answer](const auto& q, const auto& a) { answer(create_environment(q.text("env_name")), a); }},
      {"~/destroy_env", "cx_msgs/srv/DestroyClipsEnv",
       [this, answer](const auto& q, const auto& a) { answer(destroy_environment(q.text("env_name")), a); }},
      {"~/load_plugin", "cx_msgs/srv/LoadClipsPlugin",
       [this, answer](const auto& q, const auto& a) { answer(load_plugin(q.text("env_name"), q.text("plugin_name")), a); }},
      {"~/unload_plugin", "cx_msgs/srv/UnloadClipsPlugin",
       [this, answer](const auto& q, const auto& a) { answer(unload_plugin(q.text("env_name"), q.text("plugin_name")), a); }},
      {"~/list_plugins", "cx_msgs/srv/ListClipsPlugins",
       [this](const auto& q, const auto& a) {
         a.set("success", true);
         if (q.text("env_name").empty()) return;
         auto names = plugin_names(q.text("env_name"));
         if (!names) {
           a.set("success", false).set("error", names.error().message);
           return;
         }
         for (const std::string& name : *names) a.append_text("plugins", name);
       }},
  };
  for (const Service& s : services) {
    auto made = serve(bus_, node_, s.name, s.type, s.act);
    if (!made) return made.error();
    plugin_services_.push_back(*made);
  }
  return {};
}

}  // namespace cxlab::cx
