#pragma once
// Shared by the sources of the engine.

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "clips_api.h"
#include "cx/base/charge.h"
#include "cx/base/flat_table.h"
#include "cx/engine/engine.h"
#include "cx/engine/form_reader.h"
#include "firing_chain.h"
#include "rule_counter.h"

namespace cxlab {

/// The journal's data of a fact that exists.
struct KnownFact {
  const void* key = nullptr;  ///< its address
  std::uint64_t number = 0;   ///< counted over the life of the environment
  std::uint64_t record = 0;   ///< of its assert or last modify, in the stream of the environment
};

/// A function added from C++. Its address is the context of its definitions in CLIPS, so it stays when removed.
struct FunctionRecord {
  // Members that each call reads come first, so that they lie together.
  RuleEngine* engine = nullptr;
  Function function;  ///< empty once removed
  std::vector<unsigned> arg_bits;
  FunctionSpec spec;
  unsigned rest_bits = 0;
  clips::FunctionDefinition* definition = nullptr;
  /// Taken out of the table in which CLIPS looks up names, while removed.
  clips::FunctionHash* hidden = nullptr;
};

/// A built-in function of CLIPS whose definition points to ours.
struct Builtin {
  RuleEngine::Impl* impl = nullptr;
  clips::UserDefinedFunction* original = nullptr;
};

/// The name of the context in which rules fire.
inline constexpr std::string_view kRun = "run";

/// The engine of the innermost HostCall.
extern constinit thread_local RuleEngine* g_at_work;

/// Steps that each byte costs that CLIPS reads as rules.
inline constexpr std::uint64_t kStepsOfAByte = 10;
/// Bytes that cost one step when they are read, made or recorded.
inline constexpr std::uint64_t kBytesOfAStep = 16;
/// Steps that each text costs that a function makes: CLIPS prints it, hashes it, and reads it back.
inline constexpr std::uint64_t kStepsOfAText = 2;

struct RuleEngine::Impl {
  explicit Impl(RuleEngine& owner) : engine(owner) {}

  RuleEngine& engine;
  clips::Environment* env = nullptr;

  // --- Errors (errors.cpp) ---------------------------------------------------------------------------------------

  /// The work in progress, with its construct or function; the innermost is last. Its caller owns the texts.
  struct Context {
    ErrorSide side = ErrorSide::kLoad;
    std::string_view name;  ///< of a construct or a called function
    std::string_view file;
    int line = 0;
    const Form* form = nullptr;  ///< being loaded
  };
  std::vector<Context> contexts;
  /// A rule fires, or has fired and CLIPS may still report on it; its context is above `rule_depth` contexts.
  bool rule_open = false;
  bool rule_acting = false;
  std::size_t rule_depth = 0;
  int reads_at_end = 0;  ///< of the terminal in one act: questions that are asked until they are answered
  static constexpr int kMostReadsAtEnd = 1000;
  void count_read_at_end();
  clips::CLIPSLexeme* rule_atom = nullptr;    ///< its name, retained
  clips::CLIPSLexeme* module_atom = nullptr;  ///< that of its module, retained
  std::string_view rule_name, rule_module;    ///< the texts of them

  /// Which call of the rule that fires, or of the deffunction that was called back, was being evaluated.
  struct CallPlace {
    enum class Where { kUnknown, kElsewhere, kHere } where = Where::kUnknown;
    std::string name;         ///< of the function
    std::size_t actions = 0;  ///< of the construct
    std::size_t action = 0;   ///< the one with the call, from 0
    std::size_t calls = 0;    ///< of this function in that action
    std::size_t call = 0;     ///< from 0
  };
  CallPlace call_at_work();
  /// The line of that call, or 0.
  static int line_of_call(const ConstructInfo& info, const CallPlace& call);

  /// The output of CLIPS on stderr since the first "[CODE]"; where its messages begin, with the line being parsed.
  std::string captured;
  struct MessageStart {
    std::size_t at = 0;
    int line = 0;
    bool acting = false;             ///< said while the actions of a rule ran
    std::vector<std::string> rules;  ///< those behind the join that was evaluated, with their modules
    std::string read;                ///< `text_being_read()`
    CallPlace call;
  };
  std::vector<MessageStart> starts;
  std::string_view asserted_text;   ///< a fact that is being asserted from its text
  std::string_view evaluated_text;  ///< a form that the host evaluates
  /// The form of these in which a mistake may stand; empty while a construct of a file is read.
  std::string text_being_read() const;
  const clips::Expression* carried_out = nullptr;  ///< the outermost running call of a built-in function
  std::set<std::string> known_errors;              ///< keys of engine.errors_

  void capture(const char* text);
  /// Whether a form is read, not what it calls carried out.
  bool is_parsing() const;
  /// Turns what was captured into errors of the innermost context.
  void flush_errors() {
    if (!starts.empty()) make_errors();
  }
  void make_errors();
  /// File and line of an error of that construct; nothing without one.
  void set_place(RuleError& error, const ConstructInfo* info, const CallPlace& call) const;
  void add_error(RuleError error);
  /// The line of the only call that the message names in that side of the construct, else where the construct begins.
  int line_of_error(const ConstructInfo& info, ErrorSide side, const std::string& message) const;
  void close_rule();

  // --- Loading (loading.cpp) -------------------------------------------------------------------------------------

  /// (kind, name) -> places in `constructs`: one for each module, in order of definition.
  std::map<std::pair<std::string, std::string>, std::vector<std::size_t>> construct_index;
  std::vector<std::optional<ConstructInfo>> constructs;
  /// The constructs that a name stands for, with or without its module.
  std::vector<const ConstructInfo*> named(std::string_view kind, std::string_view name) const;
  void forget(const std::string& kind, const std::string& module, const std::string& name);
  struct LhsCall {
    std::string function;
    int line = 0;
  };
  std::map<std::string, std::set<std::string>> calls_of;     ///< deffunctions and generics
  std::map<std::string, std::vector<LhsCall>> lhs_calls_of;  ///< rules, with their modules
  // Who has ever called a function, on a left-hand side or in its body. Never too few: a definition that is replaced
  // stays.
  std::map<std::string, std::set<std::string>> rules_calling, functions_calling;
  std::set<std::string> reported_lhs;
  std::vector<Error> notes;

  OnLoadError on_load_error = OnLoadError::kKeepGoing;  ///< of the running load; the files that it loads follow it

  KeepSame keep_same = KeepSame::kNothing;
  bool is_there_already(const Form& form) const;
  bool load_form(const Form& form, const std::string& file, LoadMode mode);
  void remember(const Form& form, const std::string& file);
  struct Definition {
    std::string file;
    int line = 0;
    bool declaration = false;  ///< of a function whose actions come later
  };
  std::map<std::pair<std::string, std::string>, Definition> definitions;  ///< by module and what is defined
  /// A construct that takes the place of one that another form of a file has defined is a note.
  void note_definition(const Form& form, const std::string& file, bool may_replace);
  std::set<std::string> rules_reaching(const std::string& function) const;
  std::vector<RuleError> acting_on_lhs(const std::string& rule);
  /// Whether a function acts itself, or nothing where that is for its body to say.
  std::optional<bool> acts_itself(const std::string& function) const;
  bool is_acting(const std::string& function);
  bool only_gives_values(const clips::expr* expressions, std::vector<const clips::Deffunction*> within = {});
  void support_facts_of(const clips::Activation& activation);
  std::map<std::string, bool, std::less<>> known_acting;  ///< deffunctions and generics, until one of them changes

  // --- Facts and journal (facts.cpp, journal.cpp) ----------------------------------------------------------------

  FlatTable<KnownFact> known_facts;
  std::uint64_t last_fact_number = 0;
  RecordData data;
  std::vector<RecordRef> host_causes;
  std::vector<RecordRef> fire_causes;
  RecordRef fire_record;
  bool fire_recorded = false;
  const clips::Fact* modified = nullptr;  ///< between the two halves of a modify
  bool modified_again = false;
  std::vector<const void*> old_slots;

  /// Retracted facts and former values of changed slots, kept until nothing can use them. CLIPS does not retain an
  /// argument of a function while it evaluates the next one or runs a deffunction. When any inner deffunction returns,
  /// CLIPS frees the values that no fact holds any longer.
  std::vector<clips::Fact*> kept_facts;
  std::vector<clips::TypeHeader*> kept_values;
  /// To be called where no function is being evaluated, but for the one that called C++.
  void release_kept();
  /// Calls from the host since its garbage was collected.
  int uncollected = 0;
  static constexpr int kMostUncollected = 2;

  struct KnownName {
    std::string text;
    clips::CLIPSLexeme* atom = nullptr;  ///< retained
  };
  std::array<KnownName, 16> template_names;
  clips::Deftemplate* find_template(const std::string& name);
  clips::Fact* find_fact(std::int64_t index) const;
  std::optional<Error> put_slot(clips::Deftemplate& deftemplate, const Slot& slot, clips::CLIPSValue* slots);
  Expected<std::int64_t> assert_made(clips::Fact* fact);
  clips::Multifield* make_multifield(const std::vector<Value>& items);
  FactCopy copy_fact(clips::Fact& fact);
  static FactCopy copy_instance(clips::Instance& instance);
  void put_value(const clips::CLIPSValue& value);
  void put_slots(const clips::Fact& fact, bool changed_only);
  void write(RecordKind kind);

  static void on_assert(clips::Environment*, void* fact, void* self) noexcept;
  static void on_retract(clips::Environment*, void* fact, void* self) noexcept;
  static void on_modify(clips::Environment*, clips::Fact* before, clips::Fact* after, void* self) noexcept;
  static void on_fire(clips::Environment*, clips::Activation* activation, void* self) noexcept;
  static void on_fired(clips::Environment*, clips::Activation* activation, void* self) noexcept;
  static void on_clear(clips::Environment*, void* self) noexcept;
  /// CLIPS calls it at each turn of a loop and at the end of each deffunction; ends a loop without end.
  static void on_turn(clips::Environment*, void* self) noexcept;
  /// CLIPS calls them for each call of a deffunction or generic function in an expression; end a recursion without end.
  static bool on_deffunction(clips::Environment*, void* deffunction, clips::UDFValue* result) noexcept;
  static bool on_generic(clips::Environment*, void* generic, clips::UDFValue* result) noexcept;
  /// Take the place of what CLIPS does at a reset: each construct is the context of its errors.
  static void on_reset_deffacts(clips::Environment*, void* self);
  static void on_reset_definstances(clips::Environment*, void* self);
  bool call(clips::EntityEvaluationFunction* evaluate, void* construct, clips::UDFValue* result);
  bool stack_is_full();  ///< nearly: calls are nested too deep
  /// Ends all calls, with an error that names the innermost function.
  void leave_calls(const std::string& function);

  // --- Running (engine.cpp) --------------------------------------------------------------------------------------

  std::int64_t limit = 0;
  std::int64_t fired = 0;
  bool limit_reached = false;
  bool rule_halted = false;
  bool exit_requested = false;
  bool broken = false;  ///< CLIPS cannot free what is in disorder: the environment stays
  bool anything_left() const;
  void count_firings(std::int64_t most);  ///< starts the count again; `most` firings later the loop ends with
                                          ///< `limit_reached`

  /// Counts what rules do; null where nobody wants the counts.
  std::unique_ptr<RuleCounter> counter;

  // --- Loops and limits (limits.cpp) -----------------------------------------------------------------------------

  FiringChain chain;  ///< of this tick
  /// Numbers of rules in `chain`, by their names and modules, which are retained.
  std::map<std::pair<clips::CLIPSLexeme*, clips::CLIPSLexeme*>, FiringChain::Rule> rule_numbers;
  std::vector<std::string> numbered_rules;          ///< with their modules
  FiringChain::Rule rule_number = 0;                ///< of the one that fired last
  std::optional<FiringChain::Round> round;          ///< seen in this tick, and watched: which facts change
  std::size_t round_seen_at = 0;                    ///< firing
  std::uint64_t look_for_round_at = 0;              ///< work
  std::map<std::string, std::int64_t> fired_rules;  ///< while `counting`
  std::map<std::string, std::int64_t> changed_templates;
  bool near_limit = false;  ///< the steps of this tick are nearly used up
  bool counting() const { return round || near_limit || (limit > 0 && fired + 5000 >= limit); }
  /// Steps of this tick; firings and memory count as some.
  std::uint64_t work() const;
  std::int64_t tick_memory = 0;  ///< held when it began
  void note_firing(const clips::Activation& activation);
  void note_change(const clips::Fact& fact);
  FiringChain::Rule number_of(const clips::ConstructHeader& rule);
  void look_for_round();
  /// The rules that take turns, where something else has ended them, too.
  std::optional<FiringChain::Round> last_round() const;
  LoopReport loop_report() const;

  /// One firing, or one call of the host.
  void begin_act();
  std::uint64_t act_began = 0;    ///< step
  std::int64_t act_memory = 0;    ///< held then
  std::uint64_t act_changes = 0;  ///< asserts and retracts
  /// Steps, and steps for the memory that is held more.
  std::uint64_t act_work() const;
  std::uint64_t steps_of_memory(std::int64_t before) const;
  /// Who was at work when somebody looked, and how often.
  struct Worker {
    bool matches = false;  ///< its conditions are matched; else it acts
    std::string name;      ///< of a rule, with its module; of what the host calls where `is_rule` is false
    bool is_rule = false;
    auto operator<=>(const Worker&) const = default;
  };
  using Workers = std::map<Worker, int>;
  Workers workers, act_workers;  ///< of this tick, of this act
  Worker at_work() const;
  Error too_many_steps(std::uint64_t steps, const char* in_what, const Workers& workers) const;

  std::uint64_t turns = 0;  ///< of loops since the rule fired or the host called
  static constexpr std::uint64_t kMostTurns = 10'000'000;
  std::int64_t counted_memory = 0;    ///< its share of `LimitsInUse::held`
  std::uint64_t counted_written = 0;  ///< by CLIPS, bytes: charged so far
  static constexpr std::uint64_t kStepsBetweenLooks = 100'000;
  /// The rule, with its module, behind the join that is being evaluated; of several the first; empty without one.
  std::string rule_under_test() const;
  /// Ends what rules do where a limit is exceeded.
  void look_at_limits();
  void exceed(Error error, const std::string& remedy = {});
  std::string remedy() const;
  /// CLIPS calls it after so many steps or bytes; returns whether what it does has to end.
  static bool on_limits(clips::Environment*) noexcept;
  /// Bytes in memory and on disk.
  std::int64_t taken() const {
    return clips::memory_data(env)->MemoryAmount + static_cast<std::int64_t>(clips::evaluation_data(env)->Written) +
           Charge::memory() + Charge::disk();
  }
  /// The same for what happens often: counts where a megabyte more is taken than when it last looked.
  void glance_at_limits() {
    const LimitsInUse* limits = engine.options_.limits;
    if (limits == nullptr) return;
    if (limits->exceeded || taken() > look_again_at ||
        (limits->stop != nullptr && limits->stop->load(std::memory_order_relaxed)))
      look_at_limits();
  }
  std::int64_t look_again_at = 0;
  /// Number of running calls of deffunctions and generic functions, and the place on the stack where the outermost
  /// began.
  int calls = 0;
  std::uintptr_t calls_begin = 0;
  bool leaving_calls = false;  ///< they were nested too deep: the messages of CLIPS at each level are dropped
  static constexpr std::uintptr_t kMostStack = 6 * 1024 * 1024;
  clips::EntityEvaluationFunction* call_deffunction = nullptr;  ///< of CLIPS
  clips::EntityEvaluationFunction* call_generic = nullptr;

  // --- Functions (functions.cpp, builtins.cpp) -------------------------------------------------------------------

  std::map<std::string, std::unique_ptr<FunctionRecord>> functions;
  std::vector<std::unique_ptr<FunctionRecord>> replaced_functions;  ///< removed, and added again with other types
  std::map<std::string, Builtin> builtins;

  std::vector<int> unread;  ///< characters of the terminal that CLIPS gave back
  void print(const char* logical_name, const char* text);
  int read_terminal();
  /// The answer of a function that differs from machine to machine, through the input log; the journal marks the call.
  Value look_outside(const char* function, const std::function<Value()>& look);

  void install_router();
  void install_hooks();
  void install_builtins();
  void hide(FunctionRecord& record);
  void show(FunctionRecord& record);
};

/// When the garbage of a call from C++ is collected: at its end, or with that of later calls, where it is little.
enum class Collect : std::uint8_t { kNow, kLater };

/// A call from C++ into CLIPS: errors of before are cleared, garbage is collected, and what CLIPS says belongs to this
/// context.
class HostCall {
 public:
  HostCall(RuleEngine::Impl& impl, const RuleEngine::Impl::Context& context, Collect collect = Collect::kNow);
  ~HostCall();
  HostCall(const HostCall&) = delete;
  HostCall& operator=(const HostCall&) = delete;

 private:
  RuleEngine::Impl& impl_;
  std::size_t depth_;
  bool embedded_;  ///< else a function of rules called C++, and what it leaves is collected here
  Collect collect_;
  RuleEngine* outer_;  ///< that was at work before
  Charge charge_;
  clips::GCBlock block_;
};

inline ValueType value_type(unsigned short clips_type) {
  switch (clips_type) {
    case INTEGER_TYPE: return ValueType::kInteger;
    case FLOAT_TYPE: return ValueType::kFloat;
    case SYMBOL_TYPE: return ValueType::kSymbol;
    case STRING_TYPE: return ValueType::kString;
    case INSTANCE_NAME_TYPE: return ValueType::kInstanceName;
    case EXTERNAL_ADDRESS_TYPE: return ValueType::kHandle;
    case FACT_ADDRESS_TYPE: return ValueType::kFact;
    case INSTANCE_ADDRESS_TYPE: return ValueType::kInstance;
    case MULTIFIELD_TYPE: return ValueType::kMultifield;
    default: return ValueType::kVoid;
  }
}
inline ValueType value_type(const clips::TypeHeader& header) { return value_type(header.type); }
Value to_value(const clips::CLIPSValue& value);
/// An atom, or a multifield of the garbage frame.
void* to_clips(clips::Environment* env, const Value& value);
std::string qualified_name(const clips::ConstructHeader& header);

}  // namespace cxlab
