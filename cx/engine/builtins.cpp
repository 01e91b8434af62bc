// Functions of CLIPS that depend on the machine, with answers of the episode: time, chance, files, operating system.

#include <ctime>

#include "cx/base/remedy.h"
#include "internal/builtins.h"

namespace cxlab {

using namespace clips;

void complain(UDFContext* context, const std::string& why) {
  std::string text = std::string("Function '") + UDFContextFunctionName(context) + "': " + why;
  if (const std::string rule = engine_of(context).current_rule(); !rule.empty()) text += " (rule '" + rule + "')";
  text += "\n";
  PrintErrorID(context->environment, "CXLAB", 2, false);
  WriteString(context->environment, STDERR, text.c_str());
}

void refuse(UDFContext* context, UDFValue* result, const std::string& why) {
  complain(context, why);
  UDFThrowError(context);
  result->lexemeValue = FalseSymbol(context->environment);
}

bool arguments(UDFContext* context, std::vector<UDFValue>& args) {
  for (unsigned i = 1; UDFHasNextArgument(context); ++i) {
    UDFValue value;
    if (!UDFNextArgument(context, GetNthRestriction(context->environment, context->theFunction, i), &value))
      return false;
    args.push_back(value);
  }
  return true;
}

void call_original(UDFContext* context, UDFValue* result, const std::vector<UDFValue>& args) {
  Environment* env = context->environment;
  Expression call{};
  call.type = FCALL;
  call.functionValue = context->theFunction;
  Expression** last = &call.argList;
  for (const UDFValue& arg : args) {
    // What an expression has of a multifield is a pointer to the value, which knows the part that is meant.
    const bool is_list = arg.header->type == MULTIFIELD_TYPE;
    *last = GenConstant(env, arg.header->type, is_list ? const_cast<UDFValue*>(&arg) : arg.value);
    last = &(*last)->nextArg;
    Retain(env, arg.header);
  }
  Expression* outer = evaluation_data(env)->CurrentExpression;
  evaluation_data(env)->CurrentExpression = &call;
  UDFContext inner = *context;
  inner.context = nullptr;
  inner.lastArg = call.argList;
  inner.lastPosition = 1;
  inner.returnValue = result;
  const bool outermost = impl_of(context).carried_out == nullptr;
  if (outermost) impl_of(context).carried_out = outer;
  builtin_of(context).original(env, &inner, result);
  if (outermost) impl_of(context).carried_out = nullptr;
  evaluation_data(env)->CurrentExpression = outer;
  for (const UDFValue& arg : args) Release(env, arg.header);
  ReturnExpression(env, call.argList);
}

namespace {

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
    refuse(context, result,
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

// --- The machine ---------------------------------------------------------------------------------------------------

/// A function whose answer depends on the machine: it goes through the input log, and the journal marks the call.
void machine_function(Environment* env, UDFContext* context, UDFValue* result) {
  const Value value = impl_of(context).look_outside(UDFContextFunctionName(context), [&] {
    std::vector<UDFValue> args;
    if (!arguments(context, args)) return Value();
    UDFValue answer;
    answer.voidValue = VoidConstant(env);
    call_original(context, &answer, args);
    return ValueRef(answer.value, value_type(*answer.header), 0, 0).copy();
  });
  result->value = value.is(ValueType::kVoid) ? static_cast<void*>(VoidConstant(env)) : to_clips(env, value);
}

void trusted_function(Environment* env, UDFContext* context, UDFValue* result) {
  if (!engine_of(context).options().trust_rules) {
    refuse(context, result, std::string("refused to rules that are not trusted (") + kTrustRemedy + ')');
    return;
  }
  machine_function(env, context, result);
}

void chdir_function(Environment*, UDFContext* context, UDFValue* result) {
  refuse(context, result, "refused: the working directory belongs to the whole process");
}

void watch_function(Environment* env, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  if (args[0].lexemeValue->contents == std::string_view(kStatistics))
    return complain(context, "statistics are not watched: they have the machine's time");
  call_original(context, result, args);
  SetWatchItem(env, kStatistics, false, nullptr);  // "all" has them
}

/// Profiles have the machine's time.
void profile_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  if (args[0].lexemeValue->contents == std::string_view("off")) return;
  refuse(context, result, "refused: a profile has the machine's time");
}

void strategy_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  if (args[0].lexemeValue->contents == std::string_view("random"))
    return refuse(context, result,
                  "the strategy 'random' draws from the chance of the whole process; (random) has the "
                  "environment's own");
  call_original(context, result, args);
}

/// Ends the run of the rules, not the process.
void exit_function(Environment* env, UDFContext* context, UDFValue*) {
  impl_of(context).exit_requested = true;
  SetHaltExecution(env, true);
}

/// A function through which message-handlers are called: they may call themselves without end.
void message_function(Environment* env, UDFContext* context, UDFValue* result) {
  const Nesting nesting(context, result);
  if (nesting) builtin_of(context).original(env, context, result);
}

constexpr std::pair<const char*, UserDefinedFunction*> kReplaced[] = {
    {"time", time_function},
    {"local-time", calendar_function},
    {"gm-time", calendar_function},
    {"timer", timer_function},
    {"random", random_function},
    {"seed", seed_function},
    {"open", open_function},
    {"seek", seek_function},
    {"load", load_function},
    {"load*", load_function},
    {"batch", batch_function},
    {"batch*", batch_function},
    {"load-facts", read_file_function},
    {"load-instances", read_file_function},
    {"restore-instances", read_file_function},
    {"fetch", read_file_function},
    {"toss", region_function},
    {"get-region", region_function},
    {"print-region", region_function},
    {"bload-facts", read_binary_function},
    {"bload-instances", read_binary_function},
    {"bload", read_binary_function},
    {"save-facts", write_file_function},
    {"save-instances", write_file_function},
    {"save", write_file_function},
    {"dribble-on", write_file_function},
    {"remove", change_file_function},
    {"bsave-facts", write_binary_function},
    {"bsave-instances", write_binary_function},
    {"bsave", write_binary_function},
    {"rename", change_file_function},
    {"format", format_function},
    {"str-cat", text_function},
    {"sym-cat", text_function},
    {"str-length", text_function},
    {"str-compare", text_function},
    {"str-index", text_function},
    {"str-replace", text_function},
    {"sub-string", text_function},
    {"upcase", text_function},
    {"lowcase", text_function},
    {"implode$", text_function},
    {"explode$", scanning_function},
    {"string-to-field", scanning_function},
    {"read", scanning_function},
    {"readline", scanning_function},
    {"eval", nested_function},
    {"build", nested_function},
    {"assert-string", nested_function},
    {"watch", watch_function},
    {"profile", profile_function},
    {"set-strategy", strategy_function},
    {"constructs-to-c", trusted_function},
    {"system", trusted_function},
    {"chdir", chdir_function},
    {"mem-used", machine_function},
    {"mem-requests", machine_function},
    {"release-mem", machine_function},
    {"operating-system", machine_function},
    {"exit", exit_function},
    {"send", message_function},
    {"make-instance", message_function},
    {"active-make-instance", message_function},
    {"initialize-instance", message_function},
    {"active-initialize-instance", message_function},
    {"modify-instance", message_function},
    {"active-modify-instance", message_function},
    {"duplicate-instance", message_function},
    {"active-duplicate-instance", message_function},
    {"message-modify-instance", message_function},
    {"active-message-modify-instance", message_function},
    {"message-duplicate-instance", message_function},
    {"active-message-duplicate-instance", message_function},
    {"unmake-instance", message_function},
};

}  // namespace

Nesting::Nesting(UDFContext* context, UDFValue* result) : impl_(impl_of(context)), entered_(!impl_.stack_is_full()) {
  if (entered_) {
    ++impl_.calls;
    return;
  }
  impl_.leave_calls(UDFContextFunctionName(context));
  result->lexemeValue = FalseSymbol(context->environment);
}

Nesting::~Nesting() {
  if (entered_ && --impl_.calls == 0) impl_.leaving_calls = false;
}

Value RuleEngine::Impl::look_outside(const char* function, const std::function<Value()>& look) {
  if (engine.options_.journal != nullptr) {
    data.begin().field("function", function).field("deterministic", false);
    write(RecordKind::kInput);
  }
  return engine.options_.outside != nullptr ? engine.options_.outside->look(function, look) : look();
}

void RuleEngine::Impl::install_builtins() {
  install_later_functions(env);
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
