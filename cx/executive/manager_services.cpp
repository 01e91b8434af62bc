// Requests to the environment manager at run time, and its services for them: list, create and destroy
// environments; list, load and unload plugins.

#include <utility>

#include "cx/executive/environment_manager.h"

namespace cxlab::cx {

std::vector<std::string> EnvironmentManager::environment_names() const {
  std::vector<std::string> names;
  for (const Entry& entry : environments_) names.push_back(entry.environment->name());
  return names;
}

Expected<std::vector<std::string>> EnvironmentManager::plugin_names(const std::string& environment) const {
  for (const Entry& entry : environments_) {
    if (entry.environment->name() != environment) continue;
    std::vector<std::string> names;
    for (const Plugin* plugin : entry.loaded) names.push_back(plugin->name());
    return names;
  }
  return input_error("unknown environment");
}

Status EnvironmentManager::create_environment(const std::string& name) {
  if (find(name)) return input_error("Enviroment " + name + " already exists!");
  if (Status s = check_environment_name(name); !s) {
    log(LogLevel::kError, options_.node, "Failed to create environment " + name + ": " + s.error().message);
    return s;
  }
  auto environment = make_environment(name);
  if (!environment) {
    fail(environment.error());
    return environment.error();
  }
  environments_.push_back({{}, std::move(*environment), {}});
  if (Status s = load_all(environments_.back()); !s) {
    fail(s.error());
    return s;
  }
  return {};
}

Status EnvironmentManager::destroy_environment(const std::string& name) {
  Entry* entry = entry_of(name);
  if (!entry) return input_error("unknown Environment name");
  end(*entry);
  if (Status s = entry->environment->check_errors(); !s) fail(s.error());
  entry->environment.reset();  // before the code of its plugins
  environments_.erase(environments_.begin() + (entry - environments_.data()));
  finalize_unused();
  return {};
}

Status EnvironmentManager::load_plugin(const std::string& environment, const std::string& plugin) {
  Entry* entry = entry_of(environment);
  if (!entry) return input_error("unknown environment");
  const Error refused = input_error("error while loading plugin");
  if (entry->find(plugin)) {
    log(LogLevel::kInfo, options_.node,
        "plugin '" + plugin + "' is loaded in environment '" + environment + "' already");
    return {};
  }
  if (auto type = type_of(plugin, environment); !type) {
    fail(type.error());
    return refused;
  }
  const auto loaded = load(*entry, plugin);
  if (!loaded && failure_) failure_ = loaded.error();
  if (loaded && *loaded) return {};
  finalize_unused();
  return refused;
}

Status EnvironmentManager::unload_plugin(const std::string& environment, const std::string& plugin) {
  Entry* entry = entry_of(environment);
  if (!entry) {
    log(LogLevel::kError, options_.node,
        "there is no environment '" + environment + "' to unload plugin '" + plugin + "' from");
    return input_error("unknown plugin");
  }
  Plugin* found = entry->find(plugin);
  if (!found) return input_error("unknown plugin");
  unload(*entry, *found);
  if (Status s = entry->environment->check_errors(); !s) fail(s.error());
  finalize_unused();
  return {};
}

// --- As services

Status EnvironmentManager::serve_environments() {
  if (!environment_services_.empty()) return {};
  auto made =
      serve(bus_, node_, {{"~/list_envs", "cx_msgs/srv/ListClipsEnvs", [this](const auto&, const auto& response) {
                             for (const std::string& name : environment_names()) response.append_text("envs", name);
                             response.set("success", true);
                           }}});
  if (!made) return made.error();
  environment_services_ = *std::move(made);
  return {};
}

Status EnvironmentManager::serve_plugins() {
  if (!plugin_services_.empty()) return {};
  const auto answer = [](const Status& done, const bus::MessageView& response) {
    response.set("success", done.ok());
    if (!done) response.set("error", done.error().message);
  };
  auto made =
      serve(bus_, node_,
            {
                {"~/create_env", "cx_msgs/srv/CreateClipsEnv",
                 [this, answer](const auto& q, const auto& a) { answer(create_environment(q.text("env_name")), a); }},
                {"~/destroy_env", "cx_msgs/srv/DestroyClipsEnv",
                 [this, answer](const auto& q, const auto& a) { answer(destroy_environment(q.text("env_name")), a); }},
                {"~/load_plugin", "cx_msgs/srv/LoadClipsPlugin",
                 [this, answer](const auto& q, const auto& a) {
                   answer(load_plugin(q.text("env_name"), q.text("plugin_name")), a);
                 }},
                {"~/unload_plugin", "cx_msgs/srv/UnloadClipsPlugin",
                 [this, answer](const auto& q, const auto& a) {
                   answer(unload_plugin(q.text("env_name"), q.text("plugin_name")), a);
                 }},
                {"~/list_plugins", "cx_msgs/srv/ListClipsPlugins",
                 [this](const auto& q, const auto& a) {
                   a.set("success", true);
                   if (q.text("env_name").empty() && !options_.next) return;
                   auto names = plugin_names(q.text("env_name"));
                   if (!names) {
                     a.set("success", false).set("error", names.error().message);
                     return;
                   }
                   for (const std::string& name : *names) a.append_text("plugins", name);
                 }},
                {"~/set_topic_logging", "cx_msgs/srv/SetTopicLogging",
                 [this](const auto& q, const auto& a) {
                   if (Environment* environment = find(q.text("env_name")))
                     environment->set_topic_logging(q.integer("enabled") != 0);
                   a.set("success", true);
                 }},
            });
  if (!made) return made.error();
  plugin_services_ = *std::move(made);
  return {};
}

}  // namespace cxlab::cx
