#pragma once
// The base class of plugins. YAML lists a plugin under an instance name; one instance may serve several environments.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment.h"
#include "cx/executive/files.h"
#include "cx/executive/run_settings.h"
#include "cx/node/log.h"
#include "cx/node/parameters.h"

namespace cxlab::cx {

/// The manager's arguments for a plugin. All of them outlive it.
struct PluginContext {
  std::string name;        ///< of the instance
  std::string type;        ///< as in YAML, for example "cx::FileLoadPlugin"
  std::string library;     ///< file that it comes from; empty = built in
  Parameters& parameters;  ///< of the manager node
  bus::Bus& bus;
  bus::ParticipantId node{};  ///< the manager node on the bus
  Files& files;
  const RunSettings& run;
  std::function<void(Error)> note_load_error;
  std::function<void(LogLevel, std::string_view logger, std::string_view text)> log;
};

class Plugin {
 public:
  explicit Plugin(PluginContext context) : context_(std::move(context)) {}
  virtual ~Plugin() = default;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;

  /// Once, before its first environment.
  virtual Status initialize() { return {}; }
  /// Once for each environment: adds functions, templates and rules. After an error the plugin does not count as loaded
  /// there.
  virtual Status clips_env_init(EnvironmentGuard environment) = 0;
  /// Removes what it added. Functions whose `owner` is `name()` are removed without it.
  virtual void clips_env_destroyed(EnvironmentGuard) {}
  /// Once, when it has left its last environment.
  virtual void finalize() {}

  /// Each tick, after the environment has taken what waited for it and before any rule runs: for facts of its own that
  /// are due. `next_due` makes sure of the tick.
  virtual Status perceive(EnvironmentGuard) { return {}; }
  /// When it wants to act in that environment; `on_due` is called at the first tick not before.
  virtual SimTime next_due(const Environment&) const { return kNever; }
  virtual Status on_due(EnvironmentGuard) { return {}; }

  const std::string& name() const { return context_.name; }
  const std::string& type() const { return context_.type; }
  const std::string& library() const { return context_.library; }

 protected:
  const PluginContext& context() const { return context_; }
  /// Declares `<instance>.<key>` with the field's value as default, and reads it.
  template <class T>
  Status parameter(std::string_view key, T& field) const {
    return context_.parameters.declare(context_.name + '.' + std::string(key), field);
  }
  void log(LogLevel level, std::string_view text) const { context_.log(level, context_.name, text); }
  void log(Environment& environment, LogLevel level, std::string_view text) const {
    environment.log(level, context_.name, text);
  }

 private:
  PluginContext context_;
};

class PluginLibrary;

/// A plugin class as YAML names it, or a family of classes that are made from their names.
struct PluginType {
  std::string name;  ///< "cx::ExecutivePlugin"; of a family a pattern for people, "cx::CX<Pkg><Name>Plugin"
  std::vector<std::string> parameters;                         ///< that it reads, beside `plugin`
  std::function<std::unique_ptr<Plugin>(PluginContext)> make;  ///< none where a library has it
  /// Families only: whether a class is one of them, and the names of all (asked for when a class was not found).
  std::function<bool(const std::string& type, bus::Registry& interfaces)> has = {};
  std::function<std::vector<std::string>(bus::Registry& interfaces)> classes = {};
  // Only for classes in libraries of users:
  std::shared_ptr<PluginLibrary> library = {};
  int line = 0;  ///< in the manifest
  std::string description = {};
  bool any_parameter = false;  ///< the manifest does not list them
};

/// A plugin's data of each environment, in order of loading.
template <class State>
class PerEnvironment {
 public:
  State* find(const Environment& environment) const {
    for (const auto& [e, state] : states_)
      if (e == &environment) return state.get();
    return nullptr;
  }
  template <class... Args>
  State& add(const Environment& environment, Args&&... args) {
    states_.emplace_back(&environment, std::make_unique<State>(std::forward<Args>(args)...));
    return *states_.back().second;
  }
  void remove(const Environment& environment) {
    std::erase_if(states_, [&](const auto& item) { return item.first == &environment; });
  }
  bool empty() const { return states_.empty(); }
  bool is_last(const Environment& environment) const {
    return !states_.empty() && states_.back().first == &environment;
  }

 private:
  std::vector<std::pair<const Environment*, std::unique_ptr<State>>> states_;
};

}  // namespace cxlab::cx
