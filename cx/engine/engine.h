#pragma once
// One CLIPS environment, with errors, facts and functions. Only cx/engine includes clips.h.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/random.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/engine/construct_info.h"
#include "cx/engine/function.h"
#include "cx/engine/limits.h"
#include "cx/engine/outside.h"
#include "cx/engine/rule_counts.h"
#include "cx/engine/value.h"

namespace clips {
struct environmentData;
using Environment = environmentData;
}  // namespace clips

namespace cxlab {

struct Form;
class RuleCounter;

/// Where in a rule base an error was raised.
enum class ErrorSide : std::uint8_t {
  kLoad,      ///< while a construct or a form of a batch file was read
  kLhs,       ///< a test on a left-hand side
  kRhs,       ///< an action of a rule
  kCallback,  ///< a deffunction or form that the host called
};
/// "load", "LHS", "RHS", "callback".
std::string_view to_string(ErrorSide side);

/// An error in rules. `rule` is empty where there is none; a deffunction called by the host has its own name there.
struct RuleError {
  std::string rule;
  std::string file;
  int line = 0;
  ErrorSide side = ErrorSide::kLoad;
  SimTime t{};
  std::string message;               ///< first line that CLIPS said, with its [CODE], and the calls below
  std::string detail;                ///< all that CLIPS said
  int count = 1;                     ///< the same error again before it was taken is counted here
  std::vector<std::string> calls{};  ///< deffunctions and methods that were running, the innermost first

  /// `file:line: rule NAME, RHS: message`.
  std::string text() const;
  /// The kind is input for side load, run for the others.
  Error error() const;
};

enum class LoadMode : std::uint8_t {
  kConstructs,  ///< as `load*`: a file of constructs
  kBatch,       ///< as `batch*`: constructs and calls as at the prompt, results not echoed
};

enum class OnLoadError : std::uint8_t {
  kStop,       ///< the first error ends the load
  kKeepGoing,  ///< as CX: every form is tried, all errors are reported
};

/// Which constructs are left as they are where a file defines them again word for word.
enum class KeepSame : std::uint8_t {
  kNothing,
  kTypes,  ///< deftemplates, defclasses and defmodules, which CLIPS does not define again while something uses them
  kAll,    ///< all: a rule does not fire again for facts that it has fired for, a global keeps its value
};

/// `Error::code` of `eval` and `build`.
inline constexpr const char* kSyntaxCode = "syntax";
inline constexpr const char* kUnknownConstructCode = "unknown_construct";

struct LoadReport {
  std::vector<RuleError> errors;
  std::size_t forms = 0;  ///< read and handed to CLIPS
  bool ok() const { return errors.empty(); }
  /// The first error, or success.
  Status status() const;
};

/// A run that spent its limit with rules still waiting.
struct LoopReport {
  struct Count {
    std::string name;
    std::int64_t count = 0;
    std::string file;  ///< of rules: where it is defined; empty if that is not known
    int line = 0;
  };
  std::vector<Count> rules;      ///< most frequent first, at most 5
  std::vector<Count> templates;  ///< whose facts changed most, at most 5
  std::int64_t fired = 0;        ///< in all; the counts are of the last 5000 firings
  /// One sentence for the user.
  std::string text() const;
};

struct RunReport {
  std::int64_t fired = 0;
  std::vector<RuleError> errors;  ///< all since the last report, those of deliveries before the run included
  bool loop = false;              ///< the limit was reached with rules left on the agenda
  bool halted = false;            ///< a rule called (halt)
  LoopReport loop_report;
};

/// A copy of a fact, or of an instance of a class. An ordered fact has the one slot "implied"; an instance has the
/// template "object" and, before its own slots, `is-a` and `name`.
struct FactCopy {
  std::int64_t index = 0;    ///< as in f-3
  std::uint64_t number = 0;  ///< counted over the life of the environment, as in the journal
  std::string module;
  std::string template_name;
  std::vector<std::pair<std::string, Value>> slots;
  std::vector<std::string> classes{};  ///< of an instance: its class and those that it inherits from
  const Value* slot(std::string_view name) const;
  /// `(order (id O1) (state OPEN))`, `[r1] of ROBOT (speed 3)`.
  std::string print() const;
};

struct ActivationInfo {
  std::string module;
  std::string rule;
  int salience = 0;
  std::vector<std::int64_t> facts;  ///< indices; -1 for a condition without a fact (not, exists)
};

/// The matches of a rule, one entry for each disjunct of its left-hand side.
struct RuleMatches {
  struct Pattern {
    int condition = 0;         ///< counted from 1
    std::int64_t matches = 0;  ///< facts that match the pattern alone
    std::int64_t partial = 0;  ///< combinations of conditions 1 .. this that hold together
    bool negated = false;
  };
  std::vector<Pattern> patterns;
  std::int64_t activations = 0;
};

struct EngineOptions {
  std::string name = "main";          ///< of the environment; names its journal stream "env/<name>"
  std::function<SimTime()> now;       ///< simulated time; without one it stays 0
  SimTime epoch{};                    ///< since 1970, what simulated time 0 is to `time`, `local-time`, `gm-time`
  std::uint64_t seed = 0;             ///< of the episode; `random` draws from (seed, "env/<name>")
  RecordSink* journal = nullptr;      ///< may be none
  FileAccess* files = nullptr;        ///< none: every path is refused to rules, `load_file` opens what it is given
  LookOutside* outside = nullptr;     ///< may be none
  std::int64_t max_load_firings = 0;  ///< of a `(run)` in a file that is loaded; more are an error there; 0 = no limit
  bool trust_rules = false;           ///< `system`, `remove`, `rename` act; `read` reads the terminal
  LimitsInUse* limits = nullptr;      ///< may be none
  std::function<void(std::string_view logical_name, std::string_view text)> on_output;  ///< all that rules print
  std::function<void()> on_reading;  ///< rules are about to read the terminal
};

/// Owns one CLIPS environment. Single-threaded, pinned in memory; several in one process do not notice each other.
class RuleEngine {
 public:
  static Expected<std::unique_ptr<RuleEngine>> create(EngineOptions options);
  ~RuleEngine();
  RuleEngine(const RuleEngine&) = delete;
  RuleEngine& operator=(const RuleEngine&) = delete;

  /// The engine whose rules or constructs CLIPS is busy with on this thread, or null.
  static RuleEngine* at_work();
  /// The engine that owns this environment, or null.
  static RuleEngine* of(clips::Environment* environment);
  /// For plugins that use the C API. What they do with it is journaled like the rest.
  clips::Environment* raw() const { return environment_; }
  const std::string& name() const { return options_.name; }
  const EngineOptions& options() const { return options_; }
  SimTime now() const { return options_.now ? options_.now() : SimTime{}; }

  // --- Loading ---------------------------------------------------------------------------------------------------

  /// Reads a file form by form. A file that cannot be read is one error of the report.
  LoadReport load_file(const std::string& path, LoadMode mode, OnLoadError on_error = OnLoadError::kStop);
  LoadReport load_text(std::string_view text, const std::string& file, LoadMode mode,
                       OnLoadError on_error = OnLoadError::kStop);
  /// Sets what happens to constructs that a file defines again, from now on.
  void keep_same_constructs(KeepSame keep);
  /// Builds one construct, for example a deftemplate of a plugin.
  Status build(std::string_view construct, const std::string& file = {}, int line = 0);
  /// Removes a construct; fails while something uses it.
  Status undefine(std::string_view kind, const std::string& name);
  bool has(std::string_view kind, const std::string& name) const;

  // --- Facts -----------------------------------------------------------------------------------------------------

  /// `(time 12.5)`: evaluates calls inside, as CLIPS does. Returns the index of the fact; a duplicate returns the old
  /// one.
  Expected<std::int64_t> assert_string(const std::string& fact);

  struct Slot {
    std::string_view name;
    Value value;
  };
  /// A fact of a deftemplate; slots left out have their defaults. Types are not checked, as at run time in CLIPS.
  Expected<std::int64_t> assert_fact(const std::string& template_name, std::span<const Slot> slots);
  Expected<std::int64_t> assert_fact(const std::string& template_name, std::initializer_list<Slot> slots) {
    return assert_fact(template_name, std::span<const Slot>(slots.begin(), slots.size()));
  }
  /// An ordered fact `(name values...)`.
  Expected<std::int64_t> assert_ordered(const std::string& name, std::span<const Value> values);
  /// Changes slots; index and place in the journal stay. A change to the same values does nothing.
  Status modify_fact(std::int64_t index, std::span<const Slot> slots);
  /// False if there is no such fact.
  bool retract(std::int64_t index);
  bool fact_exists(std::int64_t index) const;

  /// In order of assertion; of one template (without module), or all.
  std::vector<FactCopy> facts(std::string_view template_name = {}) const;
  Expected<FactCopy> fact(std::int64_t index) const;
  std::size_t fact_count() const;
  /// The names of the slots of such facts, also while there is no fact: "implied" of an ordered one. Empty if there is
  /// no such template.
  std::vector<std::string> slot_names(const std::string& template_name) const;

  // --- Running ---------------------------------------------------------------------------------------------------

  void reset();
  void refresh_all_agendas();
  /// Empties the agenda. An activation returns only with other facts, as if it had fired. The facts that it would
  /// assert with `logical` and that are there rest on what it matches from now on.
  void settle_agenda();
  /// Facts that rest on others, and that `settle_agenda` could not make rest on these again. Their rules assert them
  /// within a condition or a loop, with what other actions have bound, or with a function that acts or is generic.
  std::vector<FactCopy> facts_not_supported_when_settled() const;
  /// Fires rules until none is left, `limit` have fired (0 = no limit), or a rule raised an error that halts.
  RunReport run(std::int64_t limit = 0);
  /// Evaluates a call or a word as at the prompt.
  Expected<Value> eval(const std::string& expression);
  /// Calls a function, deffunction or generic by name. An error inside is also in the next report, side callback.
  Expected<Value> call(const std::string& function, std::span<const Value> args);
  bool callable(const std::string& function) const;
  /// How often `call` was called since this was asked last.
  std::int64_t take_call_count() { return std::exchange(calls_, 0); }
  /// Starts the count of steps again (`Limits::steps`).
  void begin_tick();
  /// Sets `LimitsInUse::exceeded` to this, with the rule or form at work and its place, and ends what rules do.
  void exceed_limits(Error error);
  /// Errors since the last report or call of this.
  std::vector<RuleError> take_errors();
  /// Records an error at the place where rules are now, worded like those of CLIPS (`[CODE1] ...\n`). It prints nothing
  /// and halts nothing.
  void note_error(const std::string& text);
  bool has_errors() const { return !errors_.empty(); }
  /// `(exit)` was called by a rule; it ends the run and nothing else.
  bool exit_requested() const;

  /// "facts", "rules", "activations", ... or "all"; false if there is no such item. "statistics" shows nothing.
  bool watch(const std::string& item);
  bool unwatch(const std::string& item);

  /// From now on: counts what rules do. It changes nothing that they do. Asked again, it counts more, or goes on.
  void count(Counting what);
  /// All counts so far, also those of removed rules.
  EngineCounts counts() const;
  /// How often each counted rule was put on the agenda, by name with module: "MAIN::go".
  std::map<std::string, std::int64_t> activations() const;

  // --- Functions -------------------------------------------------------------------------------------------------

  /// Fails if the name is taken by another function or a construct, or the types are not understood.
  Status add_function(FunctionSpec spec, Function function);
  /// Leaves a tombstone that raises "belongs to unloaded plugin P", because compiled rules may still point to it;
  /// a function added later under that name serves them again.
  bool remove_function(const std::string& name);
  void remove_functions_of(const std::string& owner);
  /// Those added here and not removed, by name.
  std::vector<FunctionSpec> functions() const;
  Handle new_handle() { return Handle{++last_handle_}; }
  /// A text of a call stays where it is as long as the engine: its atom then means this text, and is quick to compare.
  /// For the few texts that functions are called with again and again.
  void keep(const ValueRef& text);
  /// Acting functions that tests on a left-hand side call, directly or through deffunctions: found at load, where each
  /// is an error with `kStop` and a note here with `kKeepGoing`.
  std::vector<Error> take_notes();
  /// The first such function that the rule calls; empty: none.
  std::string acting_call(const ConstructInfo& rule) const;

  // --- Looking in ------------------------------------------------------------------------------------------------

  /// All constructs with their places, in order of definition.
  std::vector<ConstructInfo> constructs() const;
  /// Null if there is none, or it was not read by this engine. `name` may have a module (`MAIN::go`); without one, and
  /// with several modules that have it, the last that was defined.
  const ConstructInfo* find_construct(std::string_view kind, std::string_view name) const;
  /// All that the name stands for: one, or without a module one for each module that has it.
  std::vector<ConstructInfo> find_constructs(std::string_view kind, std::string_view name) const;
  /// The module whose deftemplate that name stands for in rules of `module`; empty if there is none.
  std::string template_module(const std::string& module, const std::string& name) const;
  /// `MODULE::NAME` (without MAIN) of all globals with their values, in order of definition.
  std::vector<std::pair<std::string, Value>> globals() const;
  /// Instances of the classes that patterns of rules in `module` can match, in order of their making.
  std::vector<FactCopy> instances(const std::string& module) const;
  /// Makes it the current module, or pushes it on the focus stack; false if there is none of that name.
  bool use_module(const std::string& module);
  bool focus_on(const std::string& module);
  /// The modules whose rules the next run fires, the first on top. Empty means MAIN.
  std::vector<std::string> focus() const;
  std::vector<ActivationInfo> agenda() const;
  Expected<std::vector<RuleMatches>> matches(const std::string& rule) const;
  /// The rule whose actions run now, or empty.
  std::string current_rule() const;
  RandomStream& random() { return random_; }

  // --- Journal ---------------------------------------------------------------------------------------------------

  StreamId stream() const { return stream_; }
  /// The cause of asserts and retracts outside of rules, until the next call; empty = none.
  void set_cause(std::span<const RecordRef> causes);
  void set_cause(RecordRef cause) { set_cause(std::span<const RecordRef>(&cause, 1)); }
  void clear_cause() { set_cause(std::span<const RecordRef>{}); }
  /// The cause of what happens now: the record of the rule that fires, else what `set_cause` said.
  std::span<const RecordRef> cause() const;

  // For the sources of the engine
  struct Impl;
  RuleCounter* counter() const;  ///< null unless it counts

 private:
  explicit RuleEngine(EngineOptions options);

  EngineOptions options_;
  clips::Environment* environment_ = nullptr;
  RandomStream random_;
  StreamId stream_{};
  std::uint64_t last_handle_ = 0;
  std::int64_t calls_ = 0;
  std::vector<RuleError> errors_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cxlab
