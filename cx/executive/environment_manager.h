#pragma once
// The environment manager of CX: a lifecycle node that makes environments as its YAML says, loads their plugins and
// runs them. It has no thread and no timer: an episode calls it in the order of docs/reference/contracts.md 1.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment.h"
#include "cx/executive/files.h"
#include "cx/executive/plugin.h"
#include "cx/executive/run_settings.h"
#include "cx/node/bond.h"
#include "cx/node/lifecycle.h"
#include "cx/node/log.h"
#include "cx/node/parameter_services.h"
#include "cx/node/parameters.h"
#include "cx/run/parts.h"
#include "cx/wall/wall.h"

namespace cxlab::cx {

struct ManagerOptions : RunSettings {
  std::filesystem::path config;  ///< YAML as for the ROS 2 CX
  std::string node = "clips_manager";
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO, see `bus::NodeName`
  std::vector<GivenParameter> params;                       ///< of this node
  std::map<std::string, Package> packages;
  std::vector<PluginType> plugin_types;  ///< e.g. `builtin_plugins()`
  std::vector<std::string>
      native_classes;  ///< of libraries, which may be loaded though the configuration names them not
  FileRead on_read;    ///< called with each file that plugins and rules read; may be none
  std::function<void(bus::ParticipantId)>
      on_join;                            ///< called with the node and each environment on the bus; may be none
  std::filesystem::path outside_copies;   ///< replay: `Files::Options::outside`
  std::filesystem::path recorded_folder;  ///< replay: `Files::Options::recorded_folder`
  std::map<std::filesystem::path, std::filesystem::path> instead;  ///< `Files::Options::instead`
  bool one_of_several = false;  ///< lines of the log name the manager, because the run has others
  std::shared_ptr<std::set<std::string>>
      streams;  ///< of all managers of the run, so that no two share one; may be none
};

class EnvironmentManager final : public Agent {
 public:
  /// Reads and checks the configuration; the node joins the bus with its parameters and lifecycle services.
  static Expected<std::unique_ptr<EnvironmentManager>> create(ManagerOptions options, bus::Bus& bus,
                                                              RecordSink& journal);
  ~EnvironmentManager() override;
  EnvironmentManager(const EnvironmentManager&) = delete;
  EnvironmentManager& operator=(const EnvironmentManager&) = delete;

  // --- Life, as of a lifecycle node; others ask for it through `~/change_state`. kUsage where the state forbids it.
  LifeState state() const { return lifecycle_.state(); }
  /// The parameter `autostart_node`: it wants to be configured and activated at the start.
  bool autostart() const;
  /// Adds what its rules and plugins reach of the disk: the configuration, what that names, the packages.
  void add_reach(Wall& wall) const;
  /// Makes the environments, without plugins; offers the six services (list_envs, create_env, ...).
  Status configure() { return lifecycle_.change(Transition::kConfigure); }
  /// All plugins of all environments; then each environment: reset, agendas refreshed, run. Environments that were
  /// active before keep their constructs; what the plugins load again replaces them.
  Status activate() { return lifecycle_.change(Transition::kActivate); }
  /// (executive-finalize) and a last run in each environment; then its plugins go, in reverse order, and the services
  /// but list_envs. Does all of it and returns the first error. Nothing to do where nothing is active.
  Status deactivate();
  /// The environments go.
  Status cleanup() { return lifecycle_.change(Transition::kCleanup); }

  // --- A tick
  Status perceive() override;
  /// Lets the plugins act that are due, the executive above all.
  Status decide(SimTime now) override;
  /// Takes what was sent to the node and does it: transitions, environments, plugins, parameters.
  Status act() override;
  SimTime next_due() const override;
  /// Rules called (cx-shutdown) or (exit).
  bool shutdown_requested() const;
  /// They called (cx-shutdown) in the tick in which they had printed an error, which is the reason.
  const std::optional<Error>& gave_up() const { return gave_up_; }

  // --- What others ask of the node at run time. The error's message is the answer that CX gives; the log says more.
  /// Environment and plugins as its parameters say; no reset and no run. "Enviroment X already exists!"
  Status create_environment(const std::string& name);
  /// Plugins in reverse order, no (executive-finalize). "unknown Environment name"
  Status destroy_environment(const std::string& name);
  /// Sets a declared parameter at once, as the service does; `yaml` is its value.
  Status set_parameter(const std::string& name, const std::string& yaml);
  /// No reset. "unknown environment", "error while loading plugin"
  Status load_plugin(const std::string& environment, const std::string& plugin);
  /// "unknown plugin"
  Status unload_plugin(const std::string& environment, const std::string& plugin);
  std::vector<std::string> environment_names() const;
  /// In order of loading; fails if the environment does not exist.
  Expected<std::vector<std::string>> plugin_names(const std::string& environment) const;

  std::size_t size() const { return environments_.size(); }
  Environment& environment(std::size_t i) { return *environments_[i].environment; }
  Environment* find(std::string_view name);

  // --- What has happened
  const std::string& node() const { return options_.node; }
  bus::ParticipantId participant() const { return node_; }
  /// All errors of rules so far, those of loading included.
  const std::vector<RuleErrorEntry>& rule_errors() const { return rule_errors_; }
  /// With `keep_going`: what was wrong in files and plugins that did not load.
  const std::vector<Error>& load_errors() const { return load_errors_; }
  /// After deactivation: given parameters that nothing read. At any time: what rules printed as an error.
  std::vector<Error> warnings() const;
  /// The given parameters that nothing has read so far.
  std::vector<Error> unread_parameters() const { return parameters_.in_vain(); }
  /// False once a plugin has opened a gate for threads, or a person has done something in an environment.
  bool deterministic() const;
  /// Writes the log files out.
  Status flush_logs();

 private:
  struct Instance {
    std::string name;
    std::shared_ptr<Plugin> plugin;  // as make_plugin gave it
    int users = 0;                   // environments
  };
  struct Entry {
    std::vector<std::shared_ptr<void>> libraries;  // of all plugins that were ever loaded here: goes last
    std::unique_ptr<Environment> environment;
    std::vector<Plugin*> loaded;  // in order of loading
    Plugin* find(std::string_view plugin) const;
  };

  EnvironmentManager(ManagerOptions options, Parameters parameters, bus::Bus& bus, RecordSink& journal);
  void read_configured();
  /// A library that is chosen while the run goes on is code of a stranger, but for those that the configuration names.
  bool may_load(const PluginType& type) const;
  Status add_packaged_plugins();
  Status check_configuration();
  /// Nothing runs; with `strict` a parameter that is nearly called 'environments' is an error.
  Status check_no_environments();
  void log_no_plugins(const std::string& environment, const std::vector<std::string>& listed);
  Status check_unknown(const std::string& group, std::vector<std::string> known, const std::string& what);
  Expected<const PluginType*> type_of(const std::string& instance, const std::string& environment) const;

  Status change(Transition transition);
  Status do_configure();
  Status do_activate();
  Status do_deactivate();
  Status do_cleanup();

  static Status check_environment_name(const std::string& name);
  Expected<std::unique_ptr<Environment>> make_environment(const std::string& name);
  /// The name of an environment in the run, the same each time that it is made.
  const std::string& unique_name(const std::string& environment);
  Expected<LogFile*> log_file(const std::string& name);
  Status load_all(Entry& entry);
  /// Loads one plugin and says whether it is there now. Fails if what went wrong must end the run: with `keep_going`
  /// a plugin that fails is only noted, and not recorded as loaded.
  Expected<bool> load(Entry& entry, const std::string& name);
  Status load_unchecked(Entry& entry, const std::string& name);
  void unload(Entry& entry, Plugin& plugin);
  /// An environment ends: its plugins go, the last loaded first.
  void end(Entry& entry);
  /// `finalize` of those instances that no environment has any more, the last made first.
  void finalize_unused();
  void note(Error error);
  /// With `strict`: what CX would do otherwise with the rules that are there.
  void check_rules();
  /// Errors of rules: what cxlab reports is not defined in CX.
  void note_rule_errors();
  /// Notes the errors that were not noted before.
  void note_each(std::vector<Error> errors);
  /// A request at run time failed: noted with `keep_going`, else the run ends.
  void fail(Error error);
  /// A hook of a plugin has ended: an error of any kind is noted with `keep_going`, else the run ends.
  void end_hook(const Status& ended);
  Entry* entry_of(std::string_view name);

  /// While active and `bond_heartbeat_period` is above 0: on topic `bond`, with the node's name as id, as nav2 has it.
  Status form_bond();
  Status serve_environments();
  Status serve_plugins();
  LoggerNames logger_names() const { return {options_.node, options_.one_of_several ? unique_node_ : std::string()}; }
  void log(LogLevel level, std::string_view logger, std::string_view text);
  /// The words of CX for the begin or end of a transition: "Configuring [clips_manager]...".
  void log_life(std::string_view begin, std::string_view end);
  /// On the topic `~/clips_log`.
  void publish_line(const std::string& environment, std::string_view logical_name, std::string_view line);

  ManagerOptions options_;
  std::unique_ptr<net::Network> own_network_;
  Parameters parameters_;
  ParameterSetter set_parameters_;
  std::set<std::string> configured_;  ///< texts of the configuration, classes of plugins among them
  bus::Bus& bus_;
  RecordSink& journal_;
  Files files_;
  bus::NodeName node_name_;
  std::string unique_node_;  // of the run: its name, with namespace, and number if need be
  bus::ParticipantId node_{};
  Lifecycle lifecycle_;
  std::vector<bus::EndpointId> environment_services_, plugin_services_;  // list_envs; the others
  std::optional<bus::EndpointId> log_topic_;                             // made with the first line
  std::map<std::string, std::string> unique_names_;            // of environments: with namespace, and number if need be
  std::map<std::string, std::unique_ptr<LogFile>> log_files_;  // by environment; outlive it, it may come again
  std::vector<RuleErrorEntry> rule_errors_;  // they and printed errors: of environments, until these end
  PrintedErrors printed_errors_;
  std::vector<Entry> environments_;
  std::vector<Instance> instances_;  // in order of creation
  std::vector<Error> load_errors_;
  std::vector<Error> in_vain_;  // parameters
  std::unique_ptr<Bond> bond_;  // may be none
  Status failure_;              // of something that was asked for, that must end the run
  bool shutdown_ = false;
  std::optional<Error> gave_up_;
  bool deterministic_ = true;
};

}  // namespace cxlab::cx
