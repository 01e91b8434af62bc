#include "cx/executive/environment_manager.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <system_error>

#include "cx/base/number_text.h"
#include "cx/bus/needed.h"
#include "cx/executive/plugin_library.h"
#include "cx/executive/strict_cx.h"
#include "cx/executive/suspect_words.h"
#include "cx/network/network.h"

namespace cxlab::cx {

namespace {

std::string lower(std::string text) {
  for (char& c : text) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// "cyan/" for "/cyan", nothing for the root.
std::string stream_prefix(const std::string& name_space) {
  return name_space == "/" ? std::string() : name_space.substr(name_space.starts_with('/') ? 1 : 0) + '/';
}

/// `name`, or where another manager of the run has it "<name>-2", "-3" ...
std::string claim(const ManagerOptions& options, const std::string& kind, const std::string& name) {
  const std::string wanted = stream_prefix(options.name_space) + name;
  std::string given = wanted;
  for (int k = 2; options.streams && !options.streams->insert(kind + given).second; ++k)
    given = wanted + '-' + std::to_string(k);
  return given;
}

void keep_first(Status& first, Status next) {
  if (first && !next) first = std::move(next);
}

}  // namespace

EnvironmentManager::EnvironmentManager(ManagerOptions options, Parameters parameters, bus::Bus& bus,
                                       RecordSink& journal)
    : options_(std::move(options)),
      parameters_(std::move(parameters)),
      bus_(bus),
      journal_(journal),
      files_({options_.packages, options_.run_folder.empty() ? options_.rules_folder : options_.run_folder,
              options_.trust_rules, options_.on_read, options_.outside_copies, options_.recorded_folder,
              options_.instead}),
      node_name_{options_.node, options_.name_space, options_.remaps},
      unique_node_(claim(options_, "node/", options_.node)),
      node_(bus_.join(bus::ParticipantKind::kNode, node_name_, journal_.open_stream("node/" + unique_node_))),
      lifecycle_(
          bus_, node_, [this](Transition t) { return change(t); },
          [this](const Error& why) {
            if (why.kind == ErrorKind::kUsage)
              log(LogLevel::kWarn, options_.node, why.message);
            else
              fail(why);
          }) {
  if (!options_.feed) options_.feed = &bus_.as_feed();
  if (!options_.network) {
    own_network_ = std::make_unique<net::Network>(bus_, journal_);
    options_.network = own_network_.get();
  }
  if (options_.on_join) options_.on_join(node_);
}

EnvironmentManager::~EnvironmentManager() {
  options_.log = nullptr;  // its owner may be destroyed
  bond_.reset();
  for (Entry& entry : environments_) end(entry);  // threads of plugins end with them, also where nobody deactivated
  finalize_unused();
  environments_.clear();
  bus_.leave(node_);
}

// --- Life

bool EnvironmentManager::autostart() const {
  bool autostart = false;
  return parameters_.read("autostart_node", autostart).ok() && autostart;
}

Status EnvironmentManager::change(Transition transition) {
  const CLocale numbers;
  switch (transition) {
    case Transition::kConfigure: return do_configure();
    case Transition::kActivate: return do_activate();
    case Transition::kDeactivate: return do_deactivate();
    case Transition::kCleanup: return do_cleanup();
    case Transition::kShutdown: break;
  }
  // Like the hook that CX runs before its process ends.
  Status first;
  if (state() == LifeState::kActive) first = do_deactivate();
  keep_first(first, do_cleanup());
  return first;
}

Status EnvironmentManager::check_environment_name(const std::string& name) {
  constexpr std::size_t kLongest = 200;  // its log is a file of that name
  if (name.empty()) return input_error("an environment needs a name");
  if (name.size() > kLongest)
    return input_error(found_expected("a name of " + std::to_string(name.size()) + " characters for an environment",
                                      "at most " + std::to_string(kLongest)));
  return {};
}

void EnvironmentManager::log_life(std::string_view begin, std::string_view end) {
  log(LogLevel::kDebug, options_.node, std::string(begin) + " [" + options_.node + ']' + std::string(end));
}

Status EnvironmentManager::do_configure() {
  log_life("Configuring", "...");
  if (!options_.run_folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options_.run_folder / "logs", error);
    if (error)
      return resource_error("cannot make the folder: " + error.message(), (options_.run_folder / "logs").string());
  }
  std::vector<std::string> names;
  if (Status s = parameters_.read("environments", names); !s) return s;
  for (const std::string& name : names) {
    if (Status s = check_environment_name(name); !s) return parameters_.error_at("environments", s.error().message);
    auto environment = make_environment(name);
    if (!environment) {
      environments_.clear();
      return environment.error();
    }
    environments_.push_back({{}, std::move(*environment), {}});
  }
  if (Status s = serve_environments(); !s) return s;
  if (Status s = serve_plugins(); !s) return s;
  log_life("Configured", "!");
  return {};
}

Status EnvironmentManager::do_activate() {
  log_life("Activating", "...");
  if (Status s = serve_plugins(); !s) return s;
  for (Entry& entry : environments_) {
    const bool again = entry.environment->ending();
    if (again) entry.environment->begin_again();
    const Status loaded = load_all(entry);
    entry.environment->has_begun();
    if (!loaded) return loaded;
    if (again) continue;
    if (options_.strict) note_each(facts_lost_by_reset(entry.environment->engine()));
    for (Error& word : suspect_words(entry.environment->engine())) {
      log(LogLevel::kWarn, entry.environment->name(), word.text());
      in_vain_.push_back(std::move(word));
    }
  }
  for (Entry& entry : environments_) {
    entry.environment->engine().reset();
    if (Status s = entry.environment->run(); !s) return s;
  }
  check_rules();
  if (Status s = form_bond(); !s) return s;
  log_life("Activated", "...");
  return {};
}

void EnvironmentManager::check_rules() {
  if (!options_.strict) return;
  for (const Entry& entry : environments_) {
    std::map<std::string, std::string> own;
    for (const Plugin* plugin : entry.loaded)
      if (!plugin->library().empty() || !plugin->type().starts_with("cx::")) own[plugin->name()] = plugin->type();
    note_each(differences_in_rules(entry.environment->engine(), options_.release, own));
  }
}

void EnvironmentManager::note_rule_errors() {
  std::vector<Error> errors;
  for (const RuleErrorEntry& entry : rule_errors_) {
    errors.push_back(entry.error.error());
    errors.back().kind = ErrorKind::kInput;
    errors.back().message = "strict-cx: error: " + errors.back().message;
  }
  note_each(std::move(errors));
}

void EnvironmentManager::note_each(std::vector<Error> errors) {
  for (Error& error : errors) {
    const std::string text = error.text();
    if (std::none_of(load_errors_.begin(), load_errors_.end(), [&](const Error& e) { return e.text() == text; }))
      note(std::move(error));
  }
}

Status EnvironmentManager::form_bond() {
  double period = 0;
  if (Status s = parameters_.read("bond_heartbeat_period", period); !s) return s;
  if (period <= 0) return {};
  Bond::Options options;
  options.id = options_.node;
  options.instance = node_name_.full_name();
  options.period = from_seconds(period);
  options.connect_timeout = kNever;  // nobody has to watch it
  auto bond = Bond::create(bus_, node_, std::move(options), [this](Bond::Loss loss) {
    log(LogLevel::kWarn, options_.node, "the peer of its bond " + std::string(to_string(loss)));
  });
  if (!bond) return bond.error();
  bond_ = *std::move(bond);
  return {};
}

Status EnvironmentManager::deactivate() {
  return state() == LifeState::kActive ? lifecycle_.change(Transition::kDeactivate) : flush_logs();
}

Status EnvironmentManager::do_deactivate() {
  Status first;
  check_rules();  // those of files that rules have loaded, too
  if (bond_) bond_->end();
  bond_.reset();
  for (Entry& entry : environments_) {
    RuleEngine& engine = entry.environment->engine();
    engine.clear_cause();
    if (auto fact = engine.assert_string("(executive-finalize)"); !fact) keep_first(first, fact.error());
    keep_first(first, entry.environment->run());
  }
  for (Entry& entry : environments_) {
    end(entry);
    keep_first(first, entry.environment->check_errors());
  }
  finalize_unused();
  keep_first(first, std::exchange(failure_, Status()));
  if (options_.strict) note_rule_errors();
  for (const bus::EndpointId service : plugin_services_) bus_.remove(service);
  plugin_services_.clear();
  for (Error& in_vain : parameters_.in_vain()) {
    log(LogLevel::kWarn, options_.node, in_vain.text());
    in_vain_.push_back(std::move(in_vain));
  }
  log_life("Deactivated", "...");
  keep_first(first, flush_logs());
  return first;
}

Status EnvironmentManager::do_cleanup() {
  for (Entry& entry : environments_) end(entry);
  environments_.clear();
  finalize_unused();
  for (auto* services : {&environment_services_, &plugin_services_}) {
    for (const bus::EndpointId service : *services) bus_.remove(service);
    services->clear();
  }
  return flush_logs();
}

// --- Environments

const std::string& EnvironmentManager::unique_name(const std::string& environment) {
  const auto known = unique_names_.find(environment);
  return known != unique_names_.end()
             ? known->second
             : unique_names_.emplace(environment, claim(options_, "env/", environment)).first->second;
}

Expected<LogFile*> EnvironmentManager::log_file(const std::string& name) {
  if (const auto known = log_files_.find(name); known != log_files_.end()) return known->second.get();
  std::string stem = unique_name(name);
  std::replace(stem.begin(), stem.end(), '/', '_');
  const std::filesystem::path folder = options_.run_folder / "logs";
  auto file = LogFile::create(folder / (stem + ".log"));
  if (!file) return file.error();
  std::error_code ignored;  // a file system without links has only the file itself
  std::filesystem::create_symlink(stem + ".log", folder / (stem + "_latest.log"), ignored);
  return log_files_.emplace(name, std::move(*file)).first->second.get();
}

Expected<std::unique_ptr<Environment>> EnvironmentManager::make_environment(const std::string& name) {
  Environment::Options o;
  o.name = name;
  o.unique_name = unique_name(name);
  o.node = node_name_;
  o.logger_names = logger_names();
  o.run = &options_;
  o.rule_errors = &rule_errors_;
  o.printed_errors = &printed_errors_;
  bool to_file = true;
  if (Status s = parameters_.declare(name + ".log_clips_to_file", to_file); !s) return s.error();
  if (Status s = parameters_.declare(name + ".redirect_stdout_to_debug", o.redirect_stdout_to_debug); !s)
    return s.error();
  if (Status s = parameters_.declare(name + ".log_clips_to_topic", o.topic_logging); !s) return s.error();
  o.publish_line = [this](const auto& environment, auto logical_name, auto line) {
    publish_line(environment, logical_name, line);
  };
  o.set_parameter = [this](const std::string& parameter, const std::string& yaml) {
    return set_parameter(parameter, yaml);
  };
  if (to_file && !options_.run_folder.empty()) {
    auto file = log_file(name);
    if (!file) return file.error();
    o.log_file = *file;
  }
  auto environment = Environment::create(std::move(o), bus_, journal_, files_);
  if (!environment) return environment.error();
  if (options_.on_join) options_.on_join((*environment)->participant());
  RuleEngine& engine = (*environment)->engine();
  engine.unwatch("all");
  std::vector<std::string> watch;
  if (Status s = parameters_.declare(name + ".watch", watch); !s) return s.error();
  for (const std::string& item : watch)
    if (!engine.watch(lower(item))) return parameters_.error_at(name + ".watch", "Unknown watch item: " + item);
  if (Status s = engine.add_function({"cx-shutdown", "v", 0, 0, "", FunctionKind::kActing, options_.node,
                                      "Ends the executive at the end of this tick, through deactivation."},
                                     [this](Call&) {
                                       shutdown_ = true;
                                       if (!gave_up_) gave_up_ = printed_errors_.last(bus_.now());
                                     });
      !s)
    return s.error();
  log(LogLevel::kDebug, options_.node, "Initialized new CLIPS environment: " + name);
  return environment;
}

Plugin* EnvironmentManager::Entry::find(std::string_view plugin) const {
  for (Plugin* p : loaded)
    if (p->name() == plugin) return p;
  return nullptr;
}

EnvironmentManager::Entry* EnvironmentManager::entry_of(std::string_view name) {
  for (Entry& entry : environments_)
    if (entry.environment->name() == name) return &entry;
  return nullptr;
}

Environment* EnvironmentManager::find(std::string_view name) {
  Entry* entry = entry_of(name);
  return entry ? entry->environment.get() : nullptr;
}

void EnvironmentManager::note(Error error) {
  log(LogLevel::kError, options_.node, error.text());
  load_errors_.push_back(std::move(error));
}

void EnvironmentManager::fail(Error error) {
  if (options_.keep_going && error.kind == ErrorKind::kInput)
    note(std::move(error));
  else
    keep_first(failure_, std::move(error));
}

void EnvironmentManager::end_hook(const Status& ended) {
  if (ended) return;
  if (options_.keep_going)
    note(ended.error());
  else
    keep_first(failure_, ended);
}

// --- A tick

Status EnvironmentManager::perceive() {
  for (Entry& entry : environments_) {
    if (Status s = call_handlers(entry.environment->name(), [&] { return entry.environment->take_inputs(); }); !s)
      return s;
    for (Plugin* plugin : entry.loaded)
      if (Status s =
              call_plugin(*plugin, "perceive", [&] { return plugin->perceive(EnvironmentGuard(*entry.environment)); });
          !s)
        return s;
  }
  return {};
}

Status EnvironmentManager::decide(SimTime now) {
  for (Entry& entry : environments_) {
    if (Status s = entry.environment->stop_at_tick(); !s) return s;
    for (Plugin* plugin : entry.loaded) {
      if (plugin->next_due(*entry.environment) > now) continue;
      if (Status s =
              call_plugin(*plugin, "on_due", [&] { return plugin->on_due(EnvironmentGuard(*entry.environment)); });
          !s)
        return s;
    }
    if (Status s = entry.environment->log_status(); !s) return s;
  }
  return {};
}

Status EnvironmentManager::act() {
  if (Status s = options_.feed->feed(node_); !s) return s;
  if (bond_) bond_->act();
  return std::exchange(failure_, Status());
}

SimTime EnvironmentManager::next_due() const {
  SimTime first = options_.feed->next_due();
  if (bond_) first = std::min(first, bond_->next_due());
  for (const Entry& entry : environments_)
    if (entry.environment->has_gates()) return bus_.now();
  for (const Entry& entry : environments_)
    for (const Plugin* plugin : entry.loaded) first = std::min(first, plugin->next_due(*entry.environment));
  return first;
}

std::vector<Error> EnvironmentManager::warnings() const {
  std::vector<Error> all = in_vain_, printed = printed_errors_.warnings();
  std::ranges::move(printed, std::back_inserter(all));
  return all;
}

bool EnvironmentManager::deterministic() const {
  return deterministic_ && std::none_of(environments_.begin(), environments_.end(),
                                        [](const Entry& e) { return e.environment->was_controlled(); });
}

bool EnvironmentManager::shutdown_requested() const {
  return shutdown_ || std::any_of(environments_.begin(), environments_.end(),
                                  [](const Entry& e) { return e.environment->engine().exit_requested(); });
}

// --- Log

Status EnvironmentManager::flush_logs() {
  Status first;
  for (auto& [name, file] : log_files_) keep_first(first, file->flush());
  return first;
}

void EnvironmentManager::publish_line(const std::string& environment, std::string_view logical_name,
                                      std::string_view line) {
  const auto type = bus_.registry().message("cx_msgs/msg/Log");
  if (!type) return fail(type.error());
  if (!bus::can_offer(bus_.registry(), "topic " + node_name_.expand("~/clips_log"), (*type)->name())) return;
  if (!log_topic_) {
    auto made = bus_.advertise(node_, "~/clips_log", **type);
    if (!made) return fail(made.error());
    log_topic_ = *made;
  }
  bus::Message message(**type);
  message.view()
      .set("env_name", environment)
      .set("logical_name", std::string(logical_name))
      .set("line", std::string(line));
  bus_.publish(*log_topic_, std::make_shared<const bus::Message>(std::move(message)));
}

void EnvironmentManager::log(LogLevel level, std::string_view logger, std::string_view text) {
  if (options_.log) options_.log->line({bus_.now(), level, logger_names().in_log(logger), text, {}});
}

}  // namespace cxlab::cx
