#include "cx/executive/environment_manager.h"

#include <algorithm>
#include <cctype>
#include <system_error>

#include "cx/executive/plugin_library.h"

namespace cxlab::cx {

namespace {

const std::vector<std::string> kEnvironmentKeys{"plugins", "log_clips_to_file", "redirect_stdout_to_debug", "watch"};

std::string lower(std::string text) {
  for (char& c : text) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::string near = nearest_word(word, known);
  return near.empty() ? std::string() : ", did you mean '" + near + "'?";
}

void keep_first(Status& first, Status next) {
  if (first && !next) first = std::move(next);
}

}  // namespace

EnvironmentManager::EnvironmentManager(ManagerOptions options, Parameters parameters, bus::Bus& bus, RecordSink& journal)
    : options_(std::move(options)),
      parameters_(std::move(parameters)),
      bus_(bus),
      journal_(journal),
      files_({options_.packages, options_.run_folder, options_.trust_rules, options_.on_read, options_.outside_copies}),
      node_name_{options_.node, options_.name_space, options_.remaps} {
  const std::string space = options_.name_space == "/" ? "" : options_.name_space.substr(options_.name_space.starts_with('/') ? 1 : 0) + '/';
  node_ = bus_.join(bus::ParticipantKind::kNode, node_name_, journal_.open_stream("node/" + space + options_.node));
}

EnvironmentManager::~EnvironmentManager() {
  environments_.clear();
  bus_.leave(node_);
}

Expected<std::unique_ptr<EnvironmentManager>> EnvironmentManager::create(ManagerOptions options, bus::Bus& bus, RecordSink& journal) {
  if (options.on_read)
    if (Status s = options.on_read("config/" + options.config.filename().string(), options.config); !s) return s.error();
  auto parameters = Parameters::load(options.config, options.node, options.name_space);
  if (!parameters) return parameters.error();
  const std::string prefix = options.node + '.';
  for (const auto& [name, value] : options.params) {
    if (!name.starts_with(prefix)) continue;
    if (Status s = parameters->set(name.substr(prefix.size()), value, "--param " + name); !s) return s.error();
  }
  auto manager = std::unique_ptr<EnvironmentManager>(new EnvironmentManager(std::move(options), std::move(*parameters), bus, journal));
  if (Status s = manager->add_packaged_plugins(); !s) return s.error();
  if (Status s = manager->check_configuration(); !s) return s.error();
  return manager;
}

Status EnvironmentManager::add_packaged_plugins() {
  for (const std::string& package : files_.packages()) {
    auto types = read_plugin_manifest(package, files_);
    if (!types) return types.error();
    for (PluginType& type : *types) {
      for (const PluginType& other : options_.plugin_types)
        if (other.name == type.name)
          return input_error("plugin class '" + type.name + "' of package '" + package + "' has a name that is taken: give it a namespace of your own");
      options_.plugin_types.push_back(std::move(type));
    }
  }
  return {};
}

Expected<const PluginType*> EnvironmentManager::type_of(const std::string& instance, const std::string& environment) const {
  std::string type;
  if (Status s = parameters_.read(instance + ".plugin", type); !s) return s.error();
  if (type.empty()) {
    std::vector<std::string> typed;
    for (const auto& group : parameters_.below(""))
      if (parameters_.find(group + ".plugin")) typed.push_back(group);
    return parameters_.error_at(environment + ".plugins", "plugin '" + instance + "' of environment '" + environment +
                                "': no parameter '" + instance + ".plugin' says what it is" + did_you_mean(instance, typed));
  }
  std::vector<std::string> known;
  for (const PluginType& t : options_.plugin_types) {
    if (t.has ? t.has(type, bus_.registry()) : t.name == type) return &t;
    if (!t.has) known.push_back(t.name);
  }
  for (const PluginType& t : options_.plugin_types)
    if (t.classes)
      for (std::string& name : t.classes(bus_.registry())) known.push_back(std::move(name));
  return parameters_.error_at(instance + ".plugin", "unknown plugin type '" + type + "'" + did_you_mean(type, known));
}

Status EnvironmentManager::check_unknown(const std::string& group, std::vector<std::string> known, const std::string& what) {
  for (const std::string& key : parameters_.below(group)) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string message = "unknown parameter '" + group + '.' + key + "' of " + what + did_you_mean(key, known);
    const Error error = parameters_.error_at(group + '.' + key, message);
    if (options_.strict) return error;
    log(LogLevel::kInfo, options_.node, error.text());
  }
  return {};
}

Status EnvironmentManager::check_configuration() {
  if (Status s = parameters_.read("environments", names_); !s) return s;
  std::vector<std::string> checked;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::string& name = names_[i];
    if (std::find(names_.begin(), names_.begin() + static_cast<std::ptrdiff_t>(i), name) != names_.begin() + static_cast<std::ptrdiff_t>(i))
      return parameters_.error_at("environments", "environment '" + name + "' is listed twice");
    if (auto o = environment_options(name); !o) return o.error();
    if (Status s = check_unknown(name, kEnvironmentKeys, "environment '" + name + "'"); !s) return s;
    std::vector<std::string> plugins;
    if (Status s = parameters_.read(name + ".plugins", plugins); !s) return s;
    for (const std::string& plugin : plugins) {
      if (std::find(checked.begin(), checked.end(), plugin) != checked.end()) continue;
      checked.push_back(plugin);
      auto type = type_of(plugin, name);
      if (!type) {
        if (!options_.keep_going) return type.error();
        continue;  // told at activation, as in CX
      }
      if ((*type)->any_parameter) continue;
      std::vector<std::string> known = (*type)->parameters;
      known.push_back("plugin");
      if (Status s = check_unknown(plugin, std::move(known), "plugin '" + plugin + "' (" + (*type)->name + ")"); !s) return s;
    }
  }
  return {};
}

Expected<Environment::Options> EnvironmentManager::environment_options(const std::string& name) {
  Environment::Options o;
  o.name = name;
  o.node = node_name_;
  o.seed = options_.seed;
  o.epoch = options_.epoch;
  o.log = options_.log;
  o.outside = options_.outside;
  o.trust_rules = options_.trust_rules;
  o.stop_on_rule_error = options_.stop_on_rule_error;
  o.max_firings = options_.max_firings;
  o.rule_errors = &rule_errors_;
  bool to_file = true;
  if (Status s = parameters_.read(name + ".log_clips_to_file", to_file); !s) return s.error();
  if (Status s = parameters_.read(name + ".redirect_stdout_to_debug", o.redirect_stdout_to_debug); !s) return s.error();
  if (to_file && !options_.run_folder.empty()) {
    std::string file = options_.name_space.substr(options_.name_space.starts_with('/') ? 1 : 0);
    if (!file.empty()) file += '/';
    file += name + ".log";
    std::replace(file.begin(), file.end(), '/', '_');
    o.log_file = options_.run_folder / "logs" / file;
  }
  return o;
}

Status EnvironmentManager::configure() {
  if (!options_.run_folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options_.run_folder / "logs", error);
    if (error) return Error{ErrorKind::kResource, "cannot make the folder: " + error.message(), (options_.run_folder / "logs").string(), 0, {}};
  }
  for (const std::string& name : names_) {
    auto options = environment_options(name);
    if (!options) return options.error();
    auto environment = Environment::create(std::move(*options), bus_, journal_, files_);
    if (!environment) return environment.error();
    RuleEngine& engine = (*environment)->engine();
    engine.unwatch("all");
    std::vector<std::string> watch;
    if (Status s = parameters_.read(name + ".watch", watch); !s) return s;
    for (const std::string& item : watch)
      if (!engine.watch(lower(item))) return parameters_.error_at(name + ".watch", "Unknown watch item: " + item);
    if (Status s = engine.add_function({"cx-shutdown", "v", 0, 0, "", FunctionKind::kActing, options_.node,
                                        "Ends the executive at the end of this tick, through deactivation."},
                                       [this](Call&) { shutdown_ = true; });
        !s)
      return s;
    Entry entry;
    if (Status s = parameters_.read(name + ".plugins", entry.plugin_names); !s) return s;
    entry.environment = std::move(*environment);
    environments_.push_back(std::move(entry));
    log(LogLevel::kInfo, options_.node, "Initialized new CLIPS environment: " + name);
  }
  return {};
}

Status EnvironmentManager::load_plugin(Entry& entry, const std::string& name) {
  auto found = std::find_if(instances_.begin(), instances_.end(), [&](const auto& i) { return i.first == name; });
  if (found == instances_.end()) {
    auto type = type_of(name, entry.environment->name());
    if (!type) return type.error();
    std::string class_name;
    if (Status s = parameters_.read(name + ".plugin", class_name); !s) return s;
    PluginContext context{name, class_name, {}, parameters_, bus_, node_, files_, options_.epoch, options_.keep_going,
                          [this](Error e) { load_errors_.push_back(std::move(e)); },
                          [this](LogLevel level, std::string_view logger, std::string_view text) { log(level, logger, text); }};
    auto plugin = make_plugin(**type, std::move(context));
    if (!plugin) return plugin.error();
    if (Status s = call_plugin(**plugin, "initialize", [&] { return (*plugin)->initialize(); }); !s) return s;
    log(LogLevel::kInfo, options_.node, "Created plugin: " + name + " of type " + class_name + " on activation");
    instances_.push_back({name, Instance{*std::move(plugin), 0}});
    found = instances_.end() - 1;
  }
  Plugin& plugin = *found->second.plugin;
  if (Status s = call_plugin(plugin, "clips_env_init", [&] { return plugin.clips_env_init(EnvironmentGuard(*entry.environment)); }); !s) {
    entry.environment->engine().remove_functions_of(name);
    return s;
  }
  ++found->second.users;
  entry.loaded.push_back(&plugin);
  return {};
}

Status EnvironmentManager::activate() {
  for (Entry& entry : environments_) {
    for (const std::string& name : entry.plugin_names) {
      Status loaded = load_plugin(entry, name);
      if (Status s = entry.environment->check_errors(); loaded && !s) loaded = std::move(s);
      if (loaded) continue;
      if (!options_.keep_going || loaded.error().kind != ErrorKind::kInput) return loaded;
      log(LogLevel::kError, name, loaded.error().text());
      load_errors_.push_back(loaded.error());
    }
    for (const Error& note : entry.environment->engine().take_notes())
      entry.environment->log(LogLevel::kWarn, options_.node, note.text());
  }
  for (Entry& entry : environments_) {
    entry.environment->engine().reset();
    if (Status s = entry.environment->run(); !s) return s;
  }
  return {};
}

Status EnvironmentManager::deactivate() {
  Status first;
  for (Entry& entry : environments_) {
    RuleEngine& engine = entry.environment->engine();
    engine.clear_cause();
    if (auto fact = engine.assert_string("(executive-finalize)"); !fact) keep_first(first, fact.error());
    keep_first(first, entry.environment->run());
  }
  for (Entry& entry : environments_) {
    entry.environment->end();
    for (auto it = entry.loaded.rbegin(); it != entry.loaded.rend(); ++it) {
      keep_first(first, call_plugin(**it, "clips_env_destroyed", [&] {
        (*it)->clips_env_destroyed(EnvironmentGuard(*entry.environment));
        return Status();
      }));
      entry.environment->engine().remove_functions_of((*it)->name());
      log(LogLevel::kInfo, options_.node, "[" + (*it)->name() + "] Deactivated!");
    }
    entry.loaded.clear();
    keep_first(first, entry.environment->check_errors());
  }
  for (auto it = instances_.rbegin(); it != instances_.rend(); ++it)
    keep_first(first, call_plugin(*it->second.plugin, "finalize", [&] {
      it->second.plugin->finalize();
      return Status();
    }));
  instances_.clear();
  keep_first(first, flush_logs());
  return first;
}

Environment* EnvironmentManager::find(std::string_view name) {
  for (Entry& entry : environments_)
    if (entry.environment->name() == name) return entry.environment.get();
  return nullptr;
}

Status EnvironmentManager::perceive(std::size_t i) {
  Entry& entry = environments_[i];
  if (Status s = entry.environment->perceive(); !s) return s;
  for (Plugin* plugin : entry.loaded)
    if (Status s = plugin->perceive(EnvironmentGuard(*entry.environment)); !s) return s;
  return {};
}

Status EnvironmentManager::decide_if_due(std::size_t i, SimTime now) {
  Entry& entry = environments_[i];
  for (Plugin* plugin : entry.loaded) {
    if (plugin->next_due(*entry.environment) > now) continue;
    if (Status s = call_plugin(*plugin, "on_due", [&] { return plugin->on_due(EnvironmentGuard(*entry.environment)); }); !s) return s;
  }
  return entry.environment->log_status();
}

SimTime EnvironmentManager::next_due() const {
  SimTime first = kNever;
  for (const Entry& entry : environments_)
    for (const Plugin* plugin : entry.loaded) first = std::min(first, plugin->next_due(*entry.environment));
  return first;
}

bool EnvironmentManager::shutdown_requested() const {
  return shutdown_ || std::any_of(environments_.begin(), environments_.end(),
                                  [](const Entry& e) { return e.environment->engine().exit_requested(); });
}

Status EnvironmentManager::flush_logs() {
  Status first;
  for (Entry& entry : environments_) keep_first(first, entry.environment->flush_log());
  return first;
}

void EnvironmentManager::log(LogLevel level, std::string_view logger, std::string_view text) {
  if (options_.log) options_.log->line({bus_.now(), level, logger, text, {}});
}

}  // namespace cxlab::cx
