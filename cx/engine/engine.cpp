#include "cx/engine/engine.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "cx/base/remedy.h"
#include "cx/engine/version.h"
#include "internal/builtins.h"
#include "internal/rule_counter.h"

namespace cxlab {

using namespace clips;

namespace {

/// The logical names that the executive's log takes.
bool is_log_name(std::string_view name) {
  static constexpr std::array<std::string_view, 22> kNames{
      "stdout", "stderr", "stdwrn",  "t",    "l",     "info", "debug",   "warn",     "error",   "red",      "green",
      "blue",   "yellow", "magenta", "cyan", "white", "bold", "loginfo", "logdebug", "logwarn", "logerror", "stdin"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

bool router_query(Environment*, const char* name, void*) noexcept { return is_log_name(name); }

void router_write(Environment*, const char* name, const char* text, void* context) noexcept {
  static_cast<RuleEngine::Impl*>(context)->print(name, text);
}

int router_read(Environment*, const char*, void* context) noexcept {
  return static_cast<RuleEngine::Impl*>(context)->read_terminal();
}

int router_unread(Environment*, const char*, int character, void* context) noexcept {
  static_cast<RuleEngine::Impl*>(context)->unread.push_back(character);
  return character;
}

/// CLIPS calls it where it would end the process: it has found its data in disorder, and no rule may act any more.
void router_exit(Environment* env, int, void* context) noexcept {
  RuleEngine::Impl& impl = *static_cast<RuleEngine::Impl*>(context);
  if (impl.engine.options().limits == nullptr) return;
  impl.broken = true;
  impl.engine.exceed_limits(bug_error("CLIPS found its own data in disorder (the log has its message)"));
  AbortExit(env);
}

/// Keeps an environment whose data is in disorder until the process ends: to destroy it would follow broken pointers.
void keep_broken(Environment* environment) {
  static std::mutex mutex;
  static std::vector<Environment*>& kept = *new std::vector<Environment*>;
  const std::scoped_lock lock(mutex);
  kept.push_back(environment);
}

/// Our own data of an environment: the way back to its engine.
constexpr unsigned kOwnData = USER_ENVIRONMENT_DATA + 17;
struct OwnData {
  RuleEngine* engine = nullptr;
};

/// CLIPS asks again for the memory after this, as `new` does after a new-handler.
bool on_out_of_memory(Environment*, std::size_t) noexcept {
  const std::new_handler handler = std::get_new_handler();
  if (handler == nullptr) std::terminate();
  handler();
  return false;
}

/// Calls the new-handler where memory is too short for another environment: until `on_out_of_memory` is installed CLIPS
/// ends the process in its own way.
void ask_for_memory() {
  constexpr std::size_t kEnvironment = 4'000'000;
  const std::unique_ptr<char[]> room(new char[kEnvironment]);
  *static_cast<volatile char*>(room.get()) = 0;  // keeps the compiler from removing it
}

}  // namespace

RuleEngine::RuleEngine(EngineOptions options)
    : options_(std::move(options)),
      random_(options_.seed, "env/" + options_.name),
      impl_(std::make_unique<Impl>(*this)) {}

Expected<std::unique_ptr<RuleEngine>> RuleEngine::create(EngineOptions options) {
  if (options.name.empty()) return input_error("an environment needs a name");
  if (Status s = check_clips_library(); !s) return s.error();
  if (options.limits && options.limits->exceeded) return *options.limits->exceeded;
  std::unique_ptr<RuleEngine> engine(new RuleEngine(std::move(options)));
  ask_for_memory();
  Environment* env = CreateEnvironment();
  if (env == nullptr) return resource_error("no memory for a CLIPS environment");
  engine->environment_ = env;
  engine->impl_->env = env;
  AllocateEnvironmentData(env, kOwnData, sizeof(OwnData), nullptr);
  static_cast<OwnData*>(environment_data(env, kOwnData))->engine = engine.get();
  if (engine->options_.journal != nullptr) {
    engine->stream_ = engine->options_.journal->open_stream("env/" + engine->options_.name);
  }
  engine->impl_->install_router();
  SetOutOfMemoryFunction(env, on_out_of_memory);
  engine->impl_->install_builtins();
  engine->impl_->install_hooks();
  if (engine->options_.limits != nullptr) evaluation_data(env)->LookAtLimits = Impl::on_limits;
  engine->begin_tick();
  if (engine->options_.limits && engine->options_.limits->exceeded) return *engine->options_.limits->exceeded;
  return engine;
}

RuleEngine::~RuleEngine() {
  if (environment_ == nullptr) return;
  impl_->counter.reset();
  RemoveAssertFunction(environment_, "cxlab");
  RemoveRetractFunction(environment_, "cxlab");
  RemoveModifyFunction(environment_, "cxlab");
  for (auto& [name, record] : impl_->functions) impl_->show(*record);
  for (auto& record : impl_->replaced_functions) impl_->show(*record);
  if (options_.limits) options_.limits->held -= impl_->counted_memory;
  if (impl_->broken)
    keep_broken(environment_);
  else
    DestroyEnvironment(environment_);
}

RuleEngine* RuleEngine::at_work() { return g_at_work; }

RuleEngine* RuleEngine::of(Environment* environment) {
  const auto* found = static_cast<OwnData*>(environment_data(environment, kOwnData));
  return found == nullptr ? nullptr : found->engine;
}

void RuleEngine::Impl::install_router() {
  AddRouter(env, "cxlab", 40, router_query, router_write, router_read, router_unread, router_exit, this);
}

void RuleEngine::Impl::print(const char* logical_name, const char* text) {
  const std::string_view name = logical_name;
  if (leaving_calls && name == "stderr") return;
  if (name == "stderr") capture(text);
  // The load report names the errors of a form with their places, so the lines of CLIPS would repeat them. Those lines
  // begin with an empty one.
  const bool told_later = name == "stderr" && (starts.empty() ? is_parsing() && *text == '\n' : starts.back().line > 0);
  if (!told_later && engine.options_.on_output) engine.options_.on_output(name, text);
  evaluation_data(env)->Steps += 1 + std::strlen(text) / kBytesOfAStep;
}

int RuleEngine::Impl::read_terminal() {
  if (!unread.empty()) {
    const int character = unread.back();
    unread.pop_back();
    return character;
  }
  const auto read = [] { return Value::integer(std::getchar()); };
  int character = EOF;
  if (engine.options_.trust_rules) {
    if (engine.options_.on_reading) engine.options_.on_reading();
    LookOutside* outside = engine.options_.outside;
    character = static_cast<int>((outside != nullptr ? outside->look("terminal", read) : read()).as_integer());
  }
  if (character == EOF) count_read_at_end();
  return character;
}

void RuleEngine::Impl::count_read_at_end() {
  if (++reads_at_end != kMostReadsAtEnd) return;
  PrintErrorID(env, "CXLAB", 3, false);
  const std::string text =
      "The terminal was read " + std::to_string(kMostReadsAtEnd) + " times at its end in one action: stopped" +
      (engine.options_.trust_rules
           ? ".\n"
           : "; it is at its end for rules that are not trusted (" + std::string(kTrustRemedy) + ").\n");
  WriteString(env, STDERR, text.c_str());
  SetHaltExecution(env, true);
  SetEvaluationError(env, true);
}

void RuleEngine::reset() {
  HostCall call(*impl_, {ErrorSide::kCallback, "reset", {}, 0, nullptr});
  Reset(environment_);
}

namespace {

/// Whether an activation has a salience that is computed: only then does a refresh change anything.
bool any_salience_computed(Environment* env) {
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    const auto* rules =
        reinterpret_cast<const defruleModule*>(module->itemsArray[defrule_data(env)->DefruleModuleIndex]);
    for (const Activation* activation = rules->agenda; activation != nullptr; activation = activation->next)
      if (activation->theRule->dynamicSalience != nullptr) return true;
  }
  return false;
}

}  // namespace

void RuleEngine::refresh_all_agendas() {
  if (!any_salience_computed(environment_)) return;
  HostCall call(*impl_, {ErrorSide::kCallback, "refresh-agenda", {}, 0, nullptr});
  RefreshAllAgendas(environment_);
}

bool RuleEngine::Impl::anything_left() const {
  for (const FocalModule* focus = engine_data(env)->CurrentFocus; focus != nullptr; focus = focus->next) {
    if (focus->theDefruleModule->agenda != nullptr) return true;
  }
  return false;
}

RunReport RuleEngine::run(std::int64_t limit) {
  RunReport report;
  {
    HostCall call(*impl_, {ErrorSide::kCallback, kRun, {}, 0, nullptr}, Collect::kLater);
    impl_->count_firings(limit);
    // The limit of Run itself would print a message whenever half of it has fired.
    report.fired = Run(environment_, -1);
    impl_->limit = 0;
  }
  report.errors = take_errors();
  report.halted = impl_->rule_halted;
  report.loop = impl_->limit_reached;
  if (report.loop) report.loop_report = impl_->loop_report();
  return report;
}

Expected<Value> RuleEngine::eval(const std::string& expression) {
  std::optional<Value> value;
  bool syntax = false;
  const std::size_t errors_before = (impl_->flush_errors(), errors_.size());
  {
    HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr});
    CLIPSValue result;
    const std::string_view outer = std::exchange(impl_->evaluated_text, expression);
    const EvalError error = Eval(environment_, expression.c_str(), &result);
    impl_->evaluated_text = outer;
    if (error == EE_NO_ERROR) value = to_value(result);
    syntax = error == EE_PARSING_ERROR;
  }
  if (value) return *value;
  Error error =
      errors_.size() > errors_before ? errors_.back().error() : run_error("error while evaluating " + expression);
  return syntax ? std::move(error).with_code(kSyntaxCode) : error;
}

Expected<Value> RuleEngine::call(const std::string& function, std::span<const Value> args) {
  ++calls_;
  std::optional<Value> value;
  FunctionCallBuilderError error = FCBE_NO_ERROR;
  const std::size_t errors_before = (impl_->flush_errors(), errors_.size());
  {
    HostCall call(*impl_, {ErrorSide::kCallback, function, {}, 0, nullptr});
    // What Eval does, and FCBCall does not: a deffunction counts as in use until then, and (clear) would fail.
    const auto in_use = construct_data(environment_)->DanglingConstructs;
    FunctionCallBuilder* builder = CreateFunctionCallBuilder(environment_, args.size());
    for (const Value& arg : args) {
      CLIPSValue atom;
      atom.value = to_clips(environment_, arg);
      FCBAppend(builder, &atom);
    }
    CLIPSValue result;
    error = FCBCall(builder, function.c_str(), &result);
    if (error == FCBE_NO_ERROR) value = to_value(result);
    FCBDispose(builder);
    construct_data(environment_)->DanglingConstructs = in_use;
  }
  if (value) return *value;
  if (errors_.size() > errors_before) return errors_.back().error();
  const char* what = error == FCBE_FUNCTION_NOT_FOUND_ERROR ? "there is no function '"
                     : error == FCBE_INVALID_FUNCTION_ERROR ? "from C++ one cannot call '"
                                                            : "error in '";
  return run_error(what + function + "'");
}

bool RuleEngine::exit_requested() const { return impl_->exit_requested; }

bool RuleEngine::callable(const std::string& function) const {
  return FindFunction(environment_, function.c_str()) != nullptr || has("deffunction", function) ||
         has("defgeneric", function);
}

bool RuleEngine::watch(const std::string& item) {
  const bool known = SetWatchItem(environment_, item.c_str(), true, nullptr);
  SetWatchItem(environment_, kStatistics, false, nullptr);  // they have the machine's time
  return known;
}

bool RuleEngine::unwatch(const std::string& item) { return SetWatchItem(environment_, item.c_str(), false, nullptr); }

std::string RuleEngine::current_rule() const {
  return std::string(impl_->rule_acting ? impl_->rule_name : std::string_view());
}

std::vector<Error> RuleEngine::take_notes() { return std::exchange(impl_->notes, {}); }

// --- Looking in ----------------------------------------------------------------------------------------------------

std::vector<ActivationInfo> RuleEngine::agenda() const {
  std::vector<ActivationInfo> list;
  Defmodule* current = GetCurrentModule(environment_);
  for (Defmodule* module = GetNextDefmodule(environment_, nullptr); module != nullptr;
       module = GetNextDefmodule(environment_, module)) {
    SetCurrentModule(environment_, module);
    for (Activation* activation = GetNextActivation(environment_, nullptr); activation != nullptr;
         activation = GetNextActivation(environment_, activation)) {
      ActivationInfo info;
      info.module = module->header.name->contents;
      info.rule = activation->theRule->header.name->contents;
      info.salience = activation->salience;
      for (unsigned short i = 0; i < activation->basis->bcount; ++i) {
        const AlphaMatch* match = activation->basis->binds[i].gm.theMatch;
        const PatternEntity* item = match == nullptr ? nullptr : match->matchingItem;
        const bool fact = item != nullptr && item->header.type == FACT_ADDRESS_TYPE;
        info.facts.push_back(fact ? reinterpret_cast<const Fact*>(item)->factIndex : -1);
      }
      list.push_back(std::move(info));
    }
  }
  SetCurrentModule(environment_, current);
  return list;
}

bool RuleEngine::use_module(const std::string& module) {
  Defmodule* found = FindDefmodule(environment_, module.c_str());
  if (found != nullptr) SetCurrentModule(environment_, found);
  return found != nullptr;
}

bool RuleEngine::focus_on(const std::string& module) {
  Defmodule* found = FindDefmodule(environment_, module.c_str());
  if (found != nullptr) Focus(found);
  return found != nullptr;
}

std::vector<std::string> RuleEngine::focus() const {
  std::vector<std::string> modules;
  for (const FocalModule* focus = engine_data(environment_)->CurrentFocus; focus != nullptr; focus = focus->next)
    modules.emplace_back(focus->theModule->header.name->contents);
  return modules;
}

std::vector<std::pair<std::string, Value>> RuleEngine::globals() const {
  std::vector<std::pair<std::string, Value>> list;
  Defmodule* current = GetCurrentModule(environment_);
  for (Defmodule* module = GetNextDefmodule(environment_, nullptr); module != nullptr;
       module = GetNextDefmodule(environment_, module)) {
    SetCurrentModule(environment_, module);
    const std::string name = module->header.name->contents;
    for (Defglobal* global = GetNextDefglobal(environment_, nullptr); global != nullptr;
         global = GetNextDefglobal(environment_, global)) {
      CLIPSValue value;
      DefglobalGetValue(global, &value);
      list.emplace_back((name == "MAIN" ? "" : name + "::") + DefglobalName(global), to_value(value));
    }
  }
  SetCurrentModule(environment_, current);
  return list;
}

Expected<std::vector<RuleMatches>> RuleEngine::matches(const std::string& rule) const {
  Defrule* first = FindDefrule(environment_, rule.c_str());
  if (first == nullptr) return input_error("there is no rule '" + rule + "'");
  std::vector<RuleMatches> disjuncts;
  for (Defrule* disjunct = first; disjunct != nullptr; disjunct = disjunct->disjunct) {
    RuleMatches matches;
    std::vector<joinInformation> alpha(AlphaJoinCount(environment_, disjunct));
    AlphaJoins(environment_, disjunct, static_cast<unsigned short>(alpha.size()), alpha.data());
    std::vector<joinInformation> beta(BetaJoinCount(environment_, disjunct));
    BetaJoins(environment_, disjunct, static_cast<unsigned short>(beta.size()), beta.data());
    for (std::size_t i = 0; i < alpha.size(); ++i) {
      const joinNode& join = *alpha[i].theJoin;
      RuleMatches::Pattern pattern;
      pattern.condition = static_cast<int>(i) + 1;
      pattern.negated = join.patternIsNegated;
      if (join.rightSideEntryStructure == nullptr) {
        pattern.matches = join.rightMemory->beta[0]->children != nullptr ? 1 : 0;
      } else {
        const auto* header = static_cast<const patternNodeHeader*>(join.rightSideEntryStructure);
        for (const alphaMemoryHash* hash = header->firstHash; hash != nullptr; hash = hash->nextHash) {
          for (const PartialMatch* match = hash->alphaMemory; match != nullptr; match = match->nextInMemory)
            ++pattern.matches;
        }
      }
      pattern.partial = pattern.matches;
      for (const joinInformation& info : beta) {
        if (info.theJoin == &join && info.theMemory != nullptr)
          pattern.partial = static_cast<std::int64_t>(info.theMemory->count);
      }
      matches.patterns.push_back(pattern);
    }
    for (const ActivationInfo& activation : agenda()) {
      if (activation.rule == first->header.name->contents && activation.module == DefruleModule(first))
        ++matches.activations;
    }
    disjuncts.push_back(std::move(matches));
  }
  return disjuncts;
}

}  // namespace cxlab
