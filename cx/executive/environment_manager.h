#pragma once
// The environment manager of CX: reads its YAML, makes the environments, loads their plugins and runs them. It has no
// thread and no timer: an episode calls it in the order of docs/contracts.md 1.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment.h"
#include "cx/executive/files.h"
#include "cx/executive/log.h"
#include "cx/executive/parameters.h"
#include "cx/executive/plugin.h"

namespace cxlab::cx {

struct ManagerOptions {
  std::filesystem::path config;                              ///< YAML as for the ROS 2 CX
  std::string node = "clips_manager";
  std::string name_space = "/";
  std::vector<std::pair<std::string, std::string>> remaps;   ///< FROM := TO
  std::vector<std::pair<std::string, std::string>> params;   ///< NODE.NAME -> value (YAML); those of other nodes are left alone
  std::map<std::string, Package> packages;
  std::vector<PluginType> plugin_types;                      ///< e.g. `builtin_plugins()`
  LogSink* log = nullptr;                                    ///< may be none
  LookOutside* outside = nullptr;                            ///< may be none
  FileRead on_read;                                          ///< told of each file that plugins and rules read; may be none
  std::uint64_t seed = 0;                                    ///< each environment draws from a stream of its own
  double epoch = 0;                                          ///< s since 1970 at simulated time 0
  std::filesystem::path outside_copies;                      ///< replay: `Files::Options::outside`
  std::filesystem::path run_folder;                          ///< for `logs/<env>.log` and what rules write; empty = neither
  bool stop_on_rule_error = true;                            ///< else errors are only noted, as CX does
  std::int64_t max_firings = 100000;                         ///< a run of an environment; 0 = no limit
  bool keep_going = false;                                   ///< errors in rule files are noted and loading goes on
  bool strict = false;                                       ///< unknown parameters are errors
  bool trust_rules = false;                                  ///< rules read and write any file and call `system`
};

class EnvironmentManager {
 public:
  /// Reads and checks the configuration.
  static Expected<std::unique_ptr<EnvironmentManager>> create(ManagerOptions options, bus::Bus& bus, RecordSink& journal);
  ~EnvironmentManager();
  EnvironmentManager(const EnvironmentManager&) = delete;
  EnvironmentManager& operator=(const EnvironmentManager&) = delete;

  // --- Life, as of a lifecycle node. Each may be called once, in this order; after an error only `deactivate`.
  /// Makes the environments, without plugins.
  Status configure();
  /// All plugins of all environments; then each environment: reset, agendas refreshed, run.
  Status activate();
  /// (executive-finalize) and a last run in each environment; then its plugins go, in reverse order. Does all of it and
  /// returns the first error.
  Status deactivate();

  // --- A tick: first every environment perceives, then every environment decides
  std::size_t size() const { return environments_.size(); }
  Environment& environment(std::size_t i) { return *environments_[i].environment; }
  Environment* find(std::string_view name);
  Status perceive(std::size_t i);
  /// Lets the plugins act that are due, the executive above all.
  Status decide_if_due(std::size_t i, SimTime now);
  /// The earliest time at which any environment has something to decide.
  SimTime next_due() const;
  /// Rules called (cx-shutdown) or (exit).
  bool shutdown_requested() const;

  // --- What has happened
  const std::string& node() const { return options_.node; }
  /// All errors of rules so far, those of loading included.
  const std::vector<RuleErrorEntry>& rule_errors() const { return rule_errors_; }
  /// With `keep_going`: what was wrong in files and plugins that did not load.
  const std::vector<Error>& load_errors() const { return load_errors_; }
  /// Writes the log files out.
  Status flush_logs();

 private:
  struct Instance {
    std::shared_ptr<Plugin> plugin;  // as make_plugin gave it
    int users = 0;
  };
  struct Entry {
    std::unique_ptr<Environment> environment;
    std::vector<std::string> plugin_names;  // as listed
    std::vector<Plugin*> loaded;            // in order of loading
  };

  EnvironmentManager(ManagerOptions options, Parameters parameters, bus::Bus& bus, RecordSink& journal);
  Status add_packaged_plugins();
  Status check_configuration();
  Status check_unknown(const std::string& group, std::vector<std::string> known, const std::string& what);
  Expected<const PluginType*> type_of(const std::string& instance, const std::string& environment) const;
  Expected<Environment::Options> environment_options(const std::string& name);
  Status load_plugin(Entry& entry, const std::string& name);
  void log(LogLevel level, std::string_view logger, std::string_view text);

  ManagerOptions options_;
  Parameters parameters_;
  bus::Bus& bus_;
  RecordSink& journal_;
  Files files_;
  bus::NodeName node_name_;
  bus::ParticipantId node_{};
  std::vector<std::string> names_;
  std::vector<Entry> environments_;
  std::vector<std::pair<std::string, Instance>> instances_;  // in order of creation
  std::vector<RuleErrorEntry> rule_errors_;
  std::vector<Error> load_errors_;
  bool shutdown_ = false;
};

}  // namespace cxlab::cx
