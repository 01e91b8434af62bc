#pragma once
// One CLIPS environment of the executive: its engine, its place on the bus, its log.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <typeindex>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/engine/engine.h"
#include "cx/executive/files.h"
#include "cx/executive/log_router.h"
#include "cx/executive/printed_errors.h"
#include "cx/executive/run_control.h"
#include "cx/executive/run_settings.h"
#include "cx/node/log_output.h"

namespace cxlab::cx {

/// An error in rules, and where it happened.
struct RuleErrorEntry {
  std::string environment;
  RuleError error;
};

class ThreadGate;

/// How the lines of a manager, its environments and plugins are called in the log.
struct LoggerNames {
  std::string node;     ///< the manager
  std::string manager;  ///< its name in the run where the run has several managers, else empty

  /// "main", or "clips_manager-2/main".
  std::string in_log(std::string_view logger) const {
    if (manager.empty()) return std::string(logger);
    return logger == node ? manager : manager + '/' + std::string(logger);
  }
};

class Environment {
 public:
  struct Options {
    std::string name;
    std::string unique_name;           ///< in the run: of its streams; those of two managers may both be a "main"
    bus::NodeName node;                ///< that its names are resolved against
    const RunSettings* run = nullptr;  ///< outlives the environment
    bool redirect_stdout_to_debug = false;
    LoggerNames logger_names;
    LogFile* log_file = nullptr;                         ///< may be none
    std::vector<RuleErrorEntry>* rule_errors = nullptr;  ///< all errors are added here
    PrintedErrors* printed_errors = nullptr;             ///< what rules print as an error is added here; may be none
    /// Sets a parameter of the manager at once, of which the value is YAML; may be none.
    std::function<Status(const std::string& name, const std::string& yaml)> set_parameter = {};
    bool topic_logging = false;  ///< lines of rules also go to `publish_line`
    std::function<void(const std::string& environment, std::string_view logical_name, std::string_view line)>
        publish_line = [](const auto&, auto, auto) {};
  };
  static Expected<std::unique_ptr<Environment>> create(Options options, bus::Bus& bus, RecordSink& journal,
                                                       Files& files);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

  const std::string& name() const { return options_.name; }
  /// In the run: its stream is "env/" and this.
  const std::string& unique_name() const { return options_.unique_name; }
  /// The node that it belongs to.
  const bus::NodeName& node() const { return options_.node; }
  const RunSettings& settings() const { return *options_.run; }
  std::string name_in_log() const { return options_.logger_names.in_log(options_.name); }
  RuleEngine& engine() const { return *engine_; }
  bus::Bus& bus() const { return bus_; }
  bus::ParticipantId participant() const { return participant_; }
  Files& files() const { return files_; }
  SimTime now() const { return bus_.now(); }

  // --- Running
  /// Takes what waits for it: facts are asserted, callbacks called.
  Status take_inputs();
  /// RefreshAllAgendas, then runs until no rule is left. With a focus stack each of its modules gets the focus and is
  /// run in turn. Returns how many rules fired.
  struct Pass {
    std::vector<std::string> focus_stack = {};
    std::int64_t rule_limit = -1;  ///< firings after which the pass ends; below 0: none
  };
  Expected<std::int64_t> run(const Pass& pass);
  Status run() {
    auto fired = run(Pass{});
    return fired ? Status() : Status(fired.error());
  }
  /// Stops at this tick, before the plugins act, where the control of the run wants that or something was done there.
  Status stop_at_tick();
  /// Does something at the place where the environment has stopped: the value of an evaluation, printed, or nothing.
  /// Lines that are printed meanwhile go to the log as ever. `name`: see `ControlAct`.
  Expected<std::string> act(ControlAct::Verb verb, const std::string& text, const std::string& name = {});
  /// The same between the tick at that time (less than 0: before the first) and the next one.
  Expected<std::string> act_after_tick(SimTime tick, ControlAct::Verb verb, const std::string& text);
  /// In a replay: does what was done there.
  void repeat_acts_after_tick(SimTime tick);
  /// From here on the caller's thread is the one that plays the episode.
  void move_to_this_thread() { thread_ = std::this_thread::get_id(); }
  /// Whether a person or the program that plays the run has done anything.
  bool was_controlled() const { return was_controlled_; }
  /// Notes all errors since the last call. With `stop_on_rule_error` it returns the first one.
  Status check_errors();
  Status check_errors(std::vector<RuleError> errors);

  /// The environment is destroyed, or inactive until it is activated again: plugins need not remove constructs.
  bool ending() const { return ending_; }
  void end() { ending_ = true; }
  /// It is activated again: files may define existing types again with the same text.
  void begin_again();
  void has_begun() { engine_->keep_same_constructs(KeepSame::kNothing); }

  /// An object that plugins of this environment share, for example the messages that its rules hold. There is one
  /// object of each type. The first call makes it from this environment, which destroys it at its own end.
  template <class T>
  T& common() {
    auto& shared = common_[std::type_index(typeid(T))];
    if (!shared) shared = std::make_shared<T>(*this);
    return *static_cast<T*>(shared.get());
  }

  // --- What enters from outside
  /// Records a delivery as an input of this environment and makes it the cause of what follows. `what` and `name` as
  /// the rules know it: "topic" "/chatter".
  void note_input(std::string_view what, std::string_view name, const bus::Delivery& delivery);
  /// The same with a content that is no message of the bus; `cause` is the record of the post.
  void note_input(std::string_view what, std::string_view name, std::string_view content, RecordRef cause);
  /// The result of a function that looks outside, from `outside` or the input log.
  Value look(std::string_view function, const std::function<Value()>& outside);

  // --- Threads of plugins (cx/executive/thread_gate.h)
  /// A gate for the plugin's threads; the manager closes it before the plugin is unloaded. From then on each tick is
  /// played, and the run is not deterministic.
  Expected<std::shared_ptr<ThreadGate>> open_gate(const std::string& plugin);
  void close_gates(std::string_view plugin);
  bool has_gates() const { return !gates_.empty(); }
  /// Whether the caller is on the thread that plays the episode.
  bool on_its_thread() const { return thread_.load() == std::this_thread::get_id(); }
  /// The place on the bus from which requests of a plugin's threads come.
  bus::ParticipantId join_threads(bus::NodeName name, const std::string& plugin);

  /// A line of a plugin or of the manager that concerns this environment.
  void log(LogLevel level, std::string_view logger, std::string_view text);
  /// A text as if rules printed it.
  void print(std::string_view logical_name, std::string_view text) { router_.write(logical_name, text); }
  /// Tells a line that was begun as it is.
  void end_line() { router_.end_line(); }
  /// Whether lines of rules go to the manager's topic, too. Returns what was so before.
  bool set_topic_logging(bool on) { return std::exchange(options_.topic_logging, on); }
  /// Whether the log file could be written (kResource if not).
  Status log_status() const { return options_.log_file ? options_.log_file->status() : Status(); }

 private:
  Environment(Options options, bus::Bus& bus, Files& files);
  Expected<std::int64_t> run_rules(std::int64_t rule_limit);
  /// The same rule by rule, or up to where a person did something in the recorded run.
  Expected<std::int64_t> run_stopping(std::int64_t rule_limit);
  Error loop_error(const LoopReport& report) const;
  bool stops() const { return options_.run->control != nullptr || next_act().has_value(); }
  std::optional<ControlAct> next_act() const;
  Status stop_at(ControlPlace place);
  Expected<std::string> carry_out(ControlAct::Verb verb, const std::string& text, const std::string& name);
  Status load_planned(const std::string& text, const std::string& file);
  void write_line(const LogLine& line);
  Error loop_error(const std::string& what) const;

  Options options_;
  bus::Bus& bus_;
  Files& files_;
  RecordSink* journal_ = nullptr;
  RecordData data_;
  LogRouter router_;
  std::unique_ptr<RuleEngine> engine_;
  bus::ParticipantId participant_{};
  std::map<std::type_index, std::shared_ptr<void>> common_;
  bool ending_ = false;
  std::atomic<std::thread::id> thread_{std::this_thread::get_id()};
  std::vector<std::shared_ptr<ThreadGate>> gates_;
  int gates_opened_ = 0;
  ControlPlace place_;  ///< of the last stop, or of the run that goes on
  bool was_controlled_ = false;
};

/// Held while an environment is used: the mutex of CX. Only on the episode's thread, where holding it costs nothing; on
/// another, making one and using one (a copy that a plugin kept) throw std::logic_error: threads have
/// `Environment::open_gate`.
class EnvironmentGuard {
 public:
  explicit EnvironmentGuard(Environment& environment) : environment_(&environment) { check_thread(); }
  Environment& operator*() const { return check_thread(); }
  Environment* operator->() const { return &check_thread(); }
  RuleEngine& engine() const { return check_thread().engine(); }

 private:
  Environment& check_thread() const {
    if (!environment_->on_its_thread())
      throw std::logic_error(
          "environment '" + environment_->name() +
          "' is used on another thread than the episode's: threads go through Environment::open_gate");
    return *environment_;
  }

  Environment* environment_;
};

}  // namespace cxlab::cx
