// Functions of CLIPS that depend on the machine, with answers of the episode: time, chance, files, operating system.

#include <ctime>

#include "internal/impl.h"

namespace cxlab {

using namespace clips;

namespace {

Builtin& builtin_of(UDFContext* context) { return *static_cast<Builtin*>(context->context); }
RuleEngine::Impl& impl_of(UDFContext* context) { return *builtin_of(context).impl; }
RuleEngine& engine_of(UDFContext* context) { return impl_of(context).engine; }

void complain(Environment* env, UDFContext* context, const std::string& why) {
  std::string text = std::string("Function '") + UDFContextFunctionName(context) + "': " + why;
  if (const std::string rule = engine_of(context).current_rule(); !rule.empty()) text += " (rule '" + rule + "')";
  text += "\n";
  PrintErrorID(env, "CXLAB", 2, false);
  WriteString(env, STDERR, text.c_str());
}

void refuse(Environment* env, UDFContext* context, UDFValue* result, const std::string& why) {
  complain(env, context, why);
  UDFThrowError(context);
  result->lexemeValue = FalseSymbol(env);
}

/// Calls the original function with these values as its arguments.
void call_original(Environment* env, UDFContext* context, UDFValue* result, const std::vector<UDFValue>& args) {
  Expression call{};
  call.type = FCALL;
  call.functionValue = context->theFunction;
  Expression** last = &call.argList;
  for (const UDFValue& arg : args) {
    *last = GenConstant(env, arg.header->type, arg.value);
    last = &(*last)->nextArg;
  }
  ExpressionInstall(env, &call);
  Expression* outer = evaluation_data(env)->CurrentExpression;
  evaluation_data(env)->CurrentExpression = &call;
  UDFContext inner = *context;
  inner.context = nullptr;
  inner.lastArg = call.argList;
  inner.lastPosition = 1;
  inner.returnValue = result;
  builtin_of(context).original(env, &inner, result);
  evaluation_data(env)->CurrentExpression = outer;
  ExpressionDeinstall(env, &call);
  ReturnExpression(env, call.argList);
}

/// All arguments; false after an error, which CLIPS has reported.
bool arguments(UDFContext* context, std::vector<UDFValue>& args) {
  for (unsigned i = 1; UDFHasNextArgument(context); ++i) {
    UDFValue value;
    if (!UDFNextArgument(context, GetNthRestriction(context->environment, context->theFunction, i), &value))
      return false;
    args.push_back(value);
  }
  return true;
}

// --- Time ----------------------------------------------------------------------------------------------------------

SimTime time_of_day(UDFContext* context) { return engine_of(context).options().epoch + engine_of(context).now(); }

void time_function(Environment* env, UDFContext* context, UDFValue* result) {
  result->floatValue = CreateFloat(env, to_seconds(time_of_day(context)));
}

/// `gm-time` and `local-time`: the same, because simulated time has no zone.
void calendar_function(Environment* env, UDFContext* context, UDFValue* result) {
  static constexpr const char* kDays[] = {"Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"};
  const std::time_t seconds =
      static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(time_of_day(context)).count());
  std::tm calendar{};
  gmtime_r(&seconds, &calendar);
  Multifield* list = CreateMultifield(env, 9);
  const int numbers[] = {calendar.tm_year + 1900, calendar.tm_mon + 1, calendar.tm_mday,
                         calendar.tm_hour,        calendar.tm_min,     calendar.tm_sec};
  for (std::size_t i = 0; i < 6; ++i) list->contents[i].integerValue = CreateInteger(env, numbers[i]);
  list->contents[6].lexemeValue = CreateSymbol(env, kDays[calendar.tm_wday]);
  list->contents[7].integerValue = CreateInteger(env, calendar.tm_yday);
  list->contents[8].lexemeValue = FalseSymbol(env);
  result->multifieldValue = list;
  result->begin = 0;
  result->range = 9;
}

/// Evaluates its arguments, which takes no simulated time.
void timer_function(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue value;
  while (UDFHasNextArgument(context) && !GetHaltExecution(env)) UDFNextArgument(context, ANY_TYPE_BITS, &value);
  result->floatValue = CreateFloat(env, 0.0);
}

// --- Chance --------------------------------------------------------------------------------------------------------

void random_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  RandomStream& random = engine_of(context).random();
  if (args.empty()) {
    result->integerValue = CreateInteger(env, static_cast<long long>(random.below(1ULL << 31)));
    return;
  }
  if (args.size() != 2 || args[0].integerValue->contents > args[1].integerValue->contents) {
    refuse(env, context, result,
           args.size() == 1 ? "expected no or two bounds, found one" : "the first bound is above the second");
    return;
  }
  result->integerValue =
      CreateInteger(env, random.between(args[0].integerValue->contents, args[1].integerValue->contents));
}

void seed_function(Environment*, UDFContext* context, UDFValue*) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  RuleEngine& engine = engine_of(context);
  engine.random() = RandomStream(static_cast<std::uint64_t>(args[0].integerValue->contents), "env/" + engine.name());
}

// --- Files ---------------------------------------------------------------------------------------------------------

enum class Access { kRead, kWrite, kByMode };

/// Calls the original with the paths that its first `paths` arguments may really use. `kByMode`: as the third argument
/// of `open` says.
template <Access access, std::size_t paths = 1>
void file_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  FileAccess* files = engine_of(context).options().files;
  std::string mode = access == Access::kWrite ? "w" : "r";
  if (access == Access::kByMode && args.size() > 2 && args[2].header->type == STRING_TYPE)
    mode = args[2].lexemeValue->contents;
  for (std::size_t i = 0; i < paths; ++i) {
    const std::string named = args[i].lexemeValue->contents;
    if (files == nullptr) return refuse(env, context, result, "rules may not use files here: " + named);
    const bool reads = mode == "r" || mode == "rb";
    const Expected<std::string> allowed = reads ? files->for_reading(named) : files->for_writing(named);
    if (!allowed) return refuse(env, context, result, allowed.error().message);
    args[i].lexemeValue = CreateString(env, allowed->c_str());
  }
  call_original(env, context, result, args);
}

/// `load`, `load*`, `batch`, `batch*`: form by form, as files loaded by the host. TRUE unless a construct was refused
/// (load) or the file could not be read.
template <LoadMode mode>
void load_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::string path = args[0].lexemeValue->contents;
  RuleEngine& engine = engine_of(context);
  if (engine.options().files == nullptr) {
    refuse(env, context, result, "rules may not use files here: " + path);
    return;
  }
  LoadReport report = engine.load_file(path, mode, impl_of(context).on_load_error);
  const bool readable = report.errors.empty() || report.errors.front().line != 0;
  result->lexemeValue = CreateBoolean(env, mode == LoadMode::kBatch ? readable : report.ok());
  if (!readable) {
    // As in CLIPS an error of the call, after which the rule goes on.
    complain(env, context, report.errors.front().message);
    return;
  }
  for (RuleError& error : report.errors) impl_of(context).add_error(std::move(error));
}

// --- The machine ---------------------------------------------------------------------------------------------------

/// A function whose answer depends on the machine: it goes through the input log, and the journal marks the call.
void machine_function(Environment* env, UDFContext* context, UDFValue* result) {
  const Value value = impl_of(context).look_outside(UDFContextFunctionName(context), [&] {
    std::vector<UDFValue> args;
    if (!arguments(context, args)) return Value();
    UDFValue answer;
    answer.voidValue = VoidConstant(env);
    call_original(env, context, &answer, args);
    return ValueRef(answer.value, value_type(*answer.header), 0, 0).copy();
  });
  result->value = value.is(ValueType::kVoid) ? static_cast<void*>(VoidConstant(env)) : to_clips(env, value);
}

void trusted_function(Environment* env, UDFContext* context, UDFValue* result) {
  if (!engine_of(context).options().trust_rules) {
    refuse(env, context, result,
           "refused to rules that are not trusted (--trust-rules lifts this, or trust_rules: true in the scenario)");
    return;
  }
  machine_function(env, context, result);
}

void chdir_function(Environment* env, UDFContext* context, UDFValue* result) {
  refuse(env, context, result, "refused: the working directory belongs to the whole process");
}

/// Ends the run of the rules, not the process.
void exit_function(Environment* env, UDFContext* context, UDFValue*) {
  impl_of(context).exit_requested = true;
  SetHaltExecution(env, true);
}

constexpr std::pair<const char*, UserDefinedFunction*> kReplaced[] = {
    {"time", time_function},
    {"local-time", calendar_function},
    {"gm-time", calendar_function},
    {"timer", timer_function},
    {"random", random_function},
    {"seed", seed_function},
    {"open", file_function<Access::kByMode>},
    {"load", load_function<LoadMode::kConstructs>},
    {"load*", load_function<LoadMode::kConstructs>},
    {"batch", load_function<LoadMode::kBatch>},
    {"batch*", load_function<LoadMode::kBatch>},
    {"load-facts", file_function<Access::kRead>},
    {"bload-facts", file_function<Access::kRead>},
    {"load-instances", file_function<Access::kRead>},
    {"restore-instances", file_function<Access::kRead>},
    {"bload-instances", file_function<Access::kRead>},
    {"bload", file_function<Access::kRead>},
    {"fetch", file_function<Access::kRead>},
    {"save-facts", file_function<Access::kWrite>},
    {"bsave-facts", file_function<Access::kWrite>},
    {"save-instances", file_function<Access::kWrite>},
    {"bsave-instances", file_function<Access::kWrite>},
    {"save", file_function<Access::kWrite>},
    {"bsave", file_function<Access::kWrite>},
    {"dribble-on", file_function<Access::kWrite>},
    {"remove", file_function<Access::kWrite>},
    {"rename", file_function<Access::kWrite, 2>},
    {"constructs-to-c", trusted_function},
    {"system", trusted_function},
    {"chdir", chdir_function},
    {"mem-used", machine_function},
    {"mem-requests", machine_function},
    {"release-mem", machine_function},
    {"operating-system", machine_function},
    {"exit", exit_function},
};

}  // namespace

Value RuleEngine::Impl::look_outside(const char* function, const std::function<Value()>& look) {
  if (engine.options_.journal != nullptr) {
    data.begin().field("function", function).field("deterministic", false);
    write(RecordKind::kInput);
  }
  return engine.options_.outside != nullptr ? engine.options_.outside->look(function, look) : look();
}

void RuleEngine::Impl::install_builtins() {
  for (const auto& [name, function] : kReplaced) {
    FunctionDefinition* definition = FindFunction(env, name);
    if (definition == nullptr) continue;
    Builtin& builtin = builtins[name];
    builtin = {this, definition->functionPointer};
    definition->functionPointer = function;
    definition->context = &builtin;
  }
}

}  // namespace cxlab
