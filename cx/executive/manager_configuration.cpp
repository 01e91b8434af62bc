// The configuration of an environment manager, read and checked before anything runs.

#include <algorithm>

#include "cx/base/remedy.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/plugin_library.h"
#include "cx/executive/reach.h"
#include "cx/node/parameter_services.h"
#include "cx/node/rcl_yaml.h"

namespace cxlab::cx {

namespace {

/// ", did you mean 'clips_manager.strategy.dispatch'?" for "strategy.dispatch" and "clips_manger.strategy.dispatch".
std::string did_you_mean_node(const std::string& name, const std::string& node) {
  const std::size_t dot = name.find('.');
  const bool misspelt = dot != std::string::npos && !nearest_word(name.substr(0, dot), {node}).empty();
  return ", did you mean '" + node + (misspelt ? name.substr(dot) : '.' + name) + "'?";
}

}  // namespace

Expected<std::unique_ptr<EnvironmentManager>> EnvironmentManager::create(ManagerOptions options, bus::Bus& bus,
                                                                         RecordSink& journal) {
  if (options.on_read)
    if (Status s = options.on_read("config/" + options.config.filename().string(), options.config); !s)
      return s.error();
  for (const auto& [package, found] : options.packages)
    if (!options.trust_rules && holds_a_home(found.folder))
      return input_error("package " + package + ": found " + found.folder.string() +
                         ", which holds all that a user has; rules may read their packages, so expected a folder of "
                         "its own (" +
                         kTrustRemedy + ')');
  bus::NodeName name{options.node, options.name_space, options.remaps};
  bus::rename_node(name);
  options.node = name.name;
  options.name_space = name.name_space;
  options.remaps = name.remaps;
  auto parameters = Parameters::load(options.config, options.node, options.name_space);
  if (!parameters) return parameters.error();
  const std::string full_name = name.full_name();
  for (const GivenParameter& given : options.params) {
    const std::vector<std::string> nodes{options.node + '.', full_name + '.'};
    const auto node = std::ranges::find_if(nodes, [&](const auto& prefix) { return given.name.starts_with(prefix); });
    if (node == nodes.end())
      return input_error(
          found_expected("the parameter '" + given.name + "'",
                         "NODE.NAME with the node " + options.node + did_you_mean_node(given.name, options.node)),
          given.origin);
    if (Status s = parameters->set(given.name.substr(node->size()), given.value, given.origin); !s) return s.error();
  }
  auto manager = std::unique_ptr<EnvironmentManager>(
      new EnvironmentManager(std::move(options), std::move(*parameters), bus, journal));
  if (manager->options_.strict) manager->note_each(refused_by_rcl(manager->options_.config));
  manager->read_configured();
  if (Status s = manager->add_packaged_plugins(); !s) return s.error();
  if (Status s = manager->check_configuration(); !s) return s.error();
  if (Status s = manager->lifecycle_.serve(); !s) return s.error();
  auto setter = serve_parameters(bus, manager->node_, manager->parameters_);
  if (!setter) return setter.error();
  manager->set_parameters_ = *std::move(setter);
  return manager;
}

Status EnvironmentManager::set_parameter(const std::string& name, const std::string& yaml) {
  Parameters given;
  if (Status s = given.set(name, yaml, Origin{}); !s) return s;
  std::vector<std::pair<std::string, Parameter>> values;
  for (const std::string& each : given.names()) {
    const Parameter* old = parameters_.find(each);
    if (!old)
      return input_error("the node " + node_name_.full_name() + " has no parameter '" + each + "'" +
                         did_you_mean(each, parameters_.names()));
    Parameter value = *given.find(each);
    value.asked_for = false;
    // As where a plugin reads it.
    if (old->type == Parameter::Type::kDouble && value.type == Parameter::Type::kInteger) value.type = old->type;
    values.emplace_back(each, std::move(value));
  }
  return set_parameters_(std::move(values));
}

Status EnvironmentManager::add_packaged_plugins() {
  for (const std::string& package : files_.packages()) {
    auto types = read_plugin_manifest(package, files_);
    if (!types) return types.error();
    for (PluginType& type : *types) {
      for (const PluginType& other : options_.plugin_types)
        if (other.name == type.name)
          return manifest_error(
              type, found_expected("the plugin class '" + type.name + "', which " + place_of(other) + " has too",
                                   "a name of its own"));
      options_.plugin_types.push_back(std::move(type));
    }
  }
  return {};
}

Expected<const PluginType*> EnvironmentManager::type_of(const std::string& instance,
                                                        const std::string& environment) const {
  std::string type;
  if (Status s = parameters_.read(instance + ".plugin", type); !s) return s.error();
  if (type.empty() && parameters_.find(instance + ".plugin"))
    return parameters_.error_at(instance + ".plugin",
                                "parameter '" + instance + ".plugin': " + found_text("", "the class of a plugin"));
  if (type.empty()) {
    std::vector<std::string> typed;
    for (const auto& group : parameters_.below(""))
      if (parameters_.find(group + ".plugin")) typed.push_back(group);
    const std::string misspelt = nearest_word("plugin", parameters_.below(instance));
    return parameters_.error_at(environment + ".plugins",
                                "plugin '" + instance + "' of environment '" + environment + "': no parameter '" +
                                    instance + ".plugin' says what it is" +
                                    (misspelt.empty() ? did_you_mean(instance, typed)
                                                      : ", did you mean it by '" + instance + '.' + misspelt + "'?"));
  }
  std::vector<std::string> known;
  for (const PluginType& t : options_.plugin_types) {
    if (t.has ? t.has(type, bus_.registry()) : t.name == type) return &t;
    if (!t.has) known.push_back(t.name);
  }
  std::string remedy;
  for (const PluginType& t : options_.plugin_types) {
    if (!t.classes) continue;
    for (std::string& name : t.classes(bus_.registry())) known.push_back(std::move(name));
    if (type.starts_with(t.name.substr(0, t.name.find('<'))))
      remedy =
          " (a package of your own is named by packages: {NAME: DIR} in the scenario or story, or by "
          "--package NAME=DIR of cxlab env, check, test and mutate)";
  }
  return parameters_.error_at(instance + ".plugin",
                              "unknown plugin type '" + type + "'" + did_you_mean(type, known) + remedy);
}

Status EnvironmentManager::check_unknown(const std::string& group, std::vector<std::string> known,
                                         const std::string& what) {
  for (const std::string& key : parameters_.below(group)) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string message = "unknown parameter '" + group + '.' + key + "' of " + what + did_you_mean(key, known);
    const Error error = parameters_.error_at(group + '.' + key, message);
    if (options_.strict) return error;
    log(LogLevel::kInfo, options_.node, error.text());
  }
  return {};
}

Status EnvironmentManager::check_no_environments() {
  std::vector<std::string> values;  // a group is not a misspelt list
  for (const std::string& name : parameters_.below(""))
    if (name != "environments" && parameters_.find(name)) values.push_back(name);
  const std::string near = nearest_word("environments", values);
  if (near.empty()) {
    log(LogLevel::kInfo, options_.node,
        parameters_.error_at("", "no parameter 'environments': nothing runs until create_env is called").text());
    return {};
  }
  const Error error = parameters_.error_at(
      near, "unknown parameter '" + near +
                "' of the manager, did you mean 'environments'? Nothing runs until create_env is called");
  if (options_.strict) return error;
  log(LogLevel::kWarn, options_.node, error.text());
  return {};
}

void EnvironmentManager::log_no_plugins(const std::string& environment, const std::vector<std::string>& listed) {
  std::string text =
      "environment '" + environment + "': no parameter '" + environment + ".plugins', nothing is loaded into it";
  const bool unknown_name = parameters_.below(environment).empty();  // else check_unknown reports a misspelt key in it
  for (const std::string& group : parameters_.below(""))
    if (unknown_name && parameters_.find(group + ".plugins") &&
        std::find(listed.begin(), listed.end(), group) == listed.end()) {
      text += ", did you mean '" + group + "'?";
      break;
    }
  log(LogLevel::kInfo, options_.node, parameters_.error_at("environments", text).text());
}

Status EnvironmentManager::check_configuration() {
  std::vector<std::string> names, checked;
  bool autostart = false, use_sim_time = false;
  double bond = 0;
  if (Status s = parameters_.declare("use_sim_time", use_sim_time); !s) return s;  // as every node
  if (Status s = parameters_.declare("autostart_node", autostart); !s) return s;
  if (Status s = parameters_.declare("bond_heartbeat_period", bond); !s) return s;
  std::string compat = "released";
  if (Status s = parameters_.declare("compat", compat); !s) return s;
  if (compat != "released" && compat != "next")
    return parameters_.error_at("compat", "parameter 'compat': " + found_text(compat, "released or next"));
  options_.next = compat == "next";
  const bool none = !parameters_.find("environments");
  if (Status s = parameters_.declare("environments", names); !s) return s;
  if (none)
    if (Status s = check_no_environments(); !s) return s;
  for (const std::string& name : names) {
    if (std::count(names.begin(), names.end(), name) > 1)
      return parameters_.error_at("environments", "environment '" + name + "' is listed twice");
    if (Status s = check_unknown(name,
                                 {"plugins", "log_clips_to_file", "log_clips_to_topic", "redirect_stdout_to_debug",
                                  "watch", "focus_stack", "rule_limit"},
                                 "environment '" + name + "'");
        !s)
      return s;
    std::vector<std::string> plugins;
    if (Status s = parameters_.read(name + ".plugins", plugins); !s) return s;
    if (!parameters_.find(name + ".plugins")) log_no_plugins(name, names);
    for (const std::string& plugin : plugins) {
      if (std::find(checked.begin(), checked.end(), plugin) != checked.end()) continue;
      checked.push_back(plugin);
      auto type = type_of(plugin, name);
      if (!type) {
        if (!options_.keep_going) return type.error();
        continue;  // reported at activation, as in CX
      }
      if ((*type)->any_parameter) continue;
      std::vector<std::string> known = (*type)->parameters;
      known.push_back("plugin");
      if (Status s = check_unknown(plugin, std::move(known), "plugin '" + plugin + "' (" + (*type)->name + ")"); !s)
        return s;
    }
  }
  return {};
}

}  // namespace cxlab::cx
