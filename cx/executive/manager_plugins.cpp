// Plugins of an environment manager: they are made, loaded into environments and unloaded again.

#include <algorithm>

#include "cx/base/remedy.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/plugin_library.h"

namespace cxlab::cx {

Status EnvironmentManager::load_all(Entry& entry) {
  const std::string list = entry.environment->name() + ".plugins";
  std::vector<std::string> names;
  if (Status s = parameters_.declare(list, names); !s) return s;
  log(LogLevel::kDebug, options_.node, "Loading plugins for " + entry.environment->name() + '.');
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto end = names.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(names.begin(), end, names[i]) != end)
      log(LogLevel::kWarn, options_.node,
          parameters_.error_at(list, "plugin '" + names[i] + "' is listed twice in '" + list + "': it is loaded once")
              .text());
    else if (!entry.find(names[i]))
      if (auto loaded = load(entry, names[i]); !loaded) return loaded.error();
  }
  return {};
}

Expected<bool> EnvironmentManager::load(Entry& entry, const std::string& name) {
  Status loaded = load_unchecked(entry, name);
  if (!loaded && loaded.error().file.empty()) {
    Error error = loaded.error();
    const Error place = parameters_.error_at(name + ".plugin", {});
    error.file = place.file;
    error.line = place.line;
    loaded = std::move(error);
  }
  Status rules = entry.environment->check_errors();
  for (Error& note : entry.environment->engine().take_notes()) {
    log(LogLevel::kWarn, entry.environment->name(), note.text());
    in_vain_.push_back(std::move(note));
  }
  for (const Status* s : {&loaded, &rules}) {
    if (*s) continue;
    const bool may_go_on = s->error().code != kUntrusted && (s == &loaded || s->error().kind == ErrorKind::kInput);
    if (!options_.keep_going || !may_go_on) return s->error();
    log(LogLevel::kError, name, s->error().text());
    load_errors_.push_back(s->error());
  }
  return loaded.ok();
}

Status EnvironmentManager::load_unchecked(Entry& entry, const std::string& name) {
  auto found = std::find_if(instances_.begin(), instances_.end(), [&](const Instance& i) { return i.name == name; });
  if (found == instances_.end()) {
    auto type = type_of(name, entry.environment->name());
    if (!type) return type.error();
    std::string class_name;
    if (Status s = parameters_.read(name + ".plugin", class_name); !s) return s;
    if (!may_load(**type))
      return input_error(
          "plugin '" + name + "': the class " + (*type)->name +
          " is native code, and was chosen while the run goes on; expected a class of cxlab, or one that "
          "the configuration names (" +
          kTrustRemedy + ')');
    auto plugin = make_plugin(
        **type, {name,
                 class_name,
                 {},
                 parameters_,
                 bus_,
                 node_,
                 files_,
                 options_,
                 [this](Error e) { load_errors_.push_back(std::move(e)); },
                 [this](LogLevel level, std::string_view logger, std::string_view text) { log(level, logger, text); }});
    if (!plugin) return plugin.error();
    if (Status s = call_plugin(**plugin, "initialize", [&] { return (*plugin)->initialize(); }); !s) return s;
    log(LogLevel::kDebug, options_.node, "Created plugin: " + name + " of type " + class_name + " on activation");
    instances_.push_back({name, *std::move(plugin), 0});
    found = instances_.end() - 1;
  }
  Plugin& plugin = *found->plugin;
  if (auto library = library_of(found->plugin);
      library && std::find(entry.libraries.begin(), entry.libraries.end(), library) == entry.libraries.end())
    entry.libraries.push_back(std::move(library));
  if (plugin.library().empty())
    log(LogLevel::kDebug, name, "Initializing plugin for environment " + entry.environment->name());
  if (Status s = call_plugin(plugin, "clips_env_init",
                             [&] { return plugin.clips_env_init(EnvironmentGuard(*entry.environment)); });
      !s) {
    entry.environment->close_gates(name);
    entry.environment->engine().remove_functions_of(name);
    return s;
  }
  if (entry.environment->has_gates()) deterministic_ = false;
  ++found->users;
  entry.loaded.push_back(&plugin);
  return {};
}

void EnvironmentManager::unload(Entry& entry, Plugin& plugin) {
  const std::string name = plugin.name();
  entry.environment->close_gates(name);
  const Status gone = call_plugin(plugin, "clips_env_destroyed", [&]() -> Status {
    plugin.clips_env_destroyed(EnvironmentGuard(*entry.environment));
    return {};
  });
  end_hook(gone);
  entry.environment->engine().remove_functions_of(name);
  log(LogLevel::kDebug, options_.node, "[" + name + "] Deactivated!");
  std::erase(entry.loaded, &plugin);
  for (Instance& instance : instances_)
    if (instance.plugin.get() == &plugin) --instance.users;
}

void EnvironmentManager::end(Entry& entry) {
  entry.environment->end();
  if (entry.environment->was_controlled()) deterministic_ = false;
  while (!entry.loaded.empty()) unload(entry, *entry.loaded.back());
  entry.environment->end_line();
}

void EnvironmentManager::finalize_unused() {
  for (std::size_t i = instances_.size(); i-- > 0;) {
    Instance& instance = instances_[i];
    if (instance.users > 0) continue;
    const Status ended = call_plugin(*instance.plugin, "finalize", [&]() -> Status {
      instance.plugin->finalize();
      return {};
    });
    end_hook(ended);
    instances_.erase(instances_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

}  // namespace cxlab::cx
