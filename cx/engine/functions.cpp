// Functions that rules call and C++ answers.

#include <algorithm>
#include <cstddef>
#include <new>

#include "internal/impl.h"

namespace cxlab {

using namespace clips;

namespace {

UDFContext* context_of(void* context) { return static_cast<UDFContext*>(context); }

std::string error_text(UDFContext* context, std::string_view message) {
  return std::string("Function '") + UDFContextFunctionName(context) + "': " + std::string(message) + "\n";
}

void say_error(Environment* env, UDFContext* context, std::string_view message) {
  PrintErrorID(env, "CXLAB", 1, false);
  WriteString(env, STDERR, error_text(context, message).c_str());
  UDFThrowError(context);
}

}  // namespace

/// Evaluates the arguments, calls, and lets no exception through.
struct CallFrame {
  static_assert(1U << FLOAT_TYPE == FLOAT_BIT && 1U << INTEGER_TYPE == INTEGER_BIT && 1U << SYMBOL_TYPE == SYMBOL_BIT &&
                1U << STRING_TYPE == STRING_BIT && 1U << MULTIFIELD_TYPE == MULTIFIELD_BIT &&
                1U << EXTERNAL_ADDRESS_TYPE == EXTERNAL_ADDRESS_BIT && 1U << VOID_TYPE == VOID_BIT &&
                std::max({FLOAT_TYPE, INTEGER_TYPE, SYMBOL_TYPE}) < STRING_TYPE);

  static void run(Environment* env, UDFContext* context, UDFValue* result) {
    const FunctionRecord& record = *static_cast<FunctionRecord*>(context->context);
    constexpr std::size_t kInPlace = 8;
    alignas(ValueRef)
        std::byte memory[kInPlace * sizeof(ValueRef)];  // cleared for each call it would cost more than the call
    auto* args = reinterpret_cast<ValueRef*>(memory);
    std::size_t room = kInPlace, size = 0;
    std::vector<ValueRef> many;
    try {
      for (; context->lastArg != nullptr; ++size) {
        if (size == room) {
          if (many.empty()) many.assign(args, args + size);
          many.resize(room *= 4);
          args = many.data();
        }
        // The value is built in its place: a copy would have to wait for the write before it.
        const unsigned bits = size < record.arg_bits.size() ? record.arg_bits[size] : record.rest_bits;
        const Expression& arg = *context->lastArg;
        if (arg.type <= STRING_TYPE && (bits & 1U << arg.type) != 0) {
          // A number or a text as it stands in the rules.
          new (args + size) ValueRef(arg.value, value_type(arg.type), 0, 0);
          context->lastArg = arg.nextArg;
          ++context->lastPosition;
          continue;
        }
        UDFValue value;
        if (!next_argument(env, context, bits, value)) return;
        const bool list = value.header->type == MULTIFIELD_TYPE;
        const std::size_t begin = list ? value.begin : 0;
        const std::size_t length = !list ? 0 : value.range == SIZE_MAX ? value.multifieldValue->length : value.range;
        new (args + size) ValueRef(value.value, value_type(value.header->type), begin, length);
      }
      if (!record.function) {
        say_error(env, context, "belongs to unloaded plugin " + record.spec.owner);
        result->lexemeValue = FalseSymbol(env);
        return;
      }
      if (size < record.spec.min_args || size > record.spec.max_args) {
        say_error(env, context, found_expected(std::to_string(size) + " arguments", expected_arguments(record.spec)));
        result->lexemeValue = FalseSymbol(env);
        return;
      }
      Call call(*record.engine, record.spec, context, result);
      call.args_ = std::span<const ValueRef>(args, size);
      record.function(call);
    } catch (const std::exception& exception) {
      say_error(env, context, exception.what());
      result->lexemeValue = FalseSymbol(env);
    } catch (...) {
      say_error(env, context, "failed");
      result->lexemeValue = FalseSymbol(env);
    }
  }

  /// As UDFNextArgument, but faster for variables of a rule.
  static bool next_argument(Environment* env, UDFContext* context, unsigned bits, UDFValue& value) {
    Expression& arg = *context->lastArg;
    const bool variable = arg.type == PROC_GET_BIND || (arg.type >= FACT_JN_VAR1 && arg.type <= FACT_JN_VAR3);
    if (!variable) return UDFNextArgument(context, bits, &value);
    const bool failed = EvaluateExpression(env, &arg, &value);
    if (!failed && (bits & 1U << value.header->type) != 0) {
      context->lastArg = arg.nextArg;
      ++context->lastPosition;
      return true;
    }
    // An unbound variable has said so, and is the word FALSE from here on.
    Expression word{};
    word.type = SYMBOL_TYPE;
    word.value = value.value;
    word.nextArg = arg.nextArg;
    if (failed && value.header->type == SYMBOL_TYPE) context->lastArg = &word;
    if (!UDFNextArgument(context, bits, &value)) return false;
    if (failed) context->returnValue->lexemeValue = FalseSymbol(env);
    return !failed;
  }

  static std::string expected_arguments(const FunctionSpec& spec) {
    if (spec.max_args == kAnyNumberOfArguments) return "at least " + std::to_string(spec.min_args);
    if (spec.max_args == spec.min_args) return std::to_string(spec.min_args);
    return std::to_string(spec.min_args) + " to " + std::to_string(spec.max_args);
  }
};

namespace {

/// Places the list of a result; CLIPS takes it over.
template <class Values, class Atom>
void give_multifield(RuleEngine& engine, void* result, const Values& values, Atom atom) {
  auto& out = *static_cast<UDFValue*>(result);
  out.multifieldValue = CreateMultifield(engine.raw(), values.size());
  out.begin = 0;
  out.range = values.size();
  for (std::size_t i = 0; i < values.size(); ++i)
    out.multifieldValue->contents[i].value = atom(engine.raw(), values[i]);
}

void set(void* result, void* atom) { static_cast<UDFValue*>(result)->value = atom; }

}  // namespace

void Call::give_integer(std::int64_t v) { set(result_, CreateInteger(engine_.raw(), v)); }
void Call::give_number(double v) { set(result_, CreateFloat(engine_.raw(), v)); }
void Call::give_symbol(std::string_view text) { set(result_, CreateSymbol(engine_.raw(), std::string(text).c_str())); }
void Call::give_string(std::string_view text) { set(result_, CreateString(engine_.raw(), std::string(text).c_str())); }
void Call::give_boolean(bool v) { set(result_, v ? TrueSymbol(engine_.raw()) : FalseSymbol(engine_.raw())); }
void Call::give_handle(Handle id) {
  set(result_, CreateCExternalAddress(engine_.raw(), reinterpret_cast<void*>(static_cast<std::uintptr_t>(id))));
}

void Call::give_integers(std::span<const std::int64_t> values) {
  give_multifield(engine_, result_, values, [](Environment* env, std::int64_t v) { return CreateInteger(env, v); });
}
void Call::give_numbers(std::span<const double> values) {
  give_multifield(engine_, result_, values, [](Environment* env, double v) { return CreateFloat(env, v); });
}
void Call::give_handles(std::span<const Handle> values) {
  give_multifield(engine_, result_, values, [](Environment* env, Handle v) { return to_clips(env, Value::handle(v)); });
}
void Call::give_strings(std::span<const std::string> values) {
  give_multifield(engine_, result_, values,
                  [](Environment* env, const std::string& v) { return CreateString(env, v.c_str()); });
}
void Call::give_list(std::span<const Value> values) {
  give_multifield(engine_, result_, values, [](Environment* env, const Value& v) { return to_clips(env, v); });
}

void Call::give(const Value& value) {
  if (value.is(ValueType::kMultifield)) {
    give_list(value.items());
  } else if (value.is(ValueType::kVoid)) {
    set(result_, VoidConstant(engine_.raw()));
  } else {
    set(result_, to_clips(engine_.raw(), value));
  }
}

void Call::give_arg(std::size_t i) {
  const ValueRef& arg = args_[i];
  auto& out = *static_cast<UDFValue*>(result_);
  out.value = const_cast<void*>(arg.atom());
  if (!arg.is(ValueType::kMultifield)) return;
  out.begin = arg.begin();
  out.range = arg.size();
}

void Call::fail(std::string_view message) {
  failed_ = true;
  say_error(engine_.raw(), context_of(context_), message);
  give_boolean(false);
}

void Call::complain(std::string_view message) {
  engine_.note_error("[CXLAB1] " + error_text(context_of(context_), message));
}

// --- Adding and removing -------------------------------------------------------------------------------------------

// CLIPS frees the definition of a removed function, even while compiled rules point to it. Old rules would then call a
// later function that got the same memory. So a definition is only taken out of the table of names, never freed.

void RuleEngine::Impl::hide(FunctionRecord& record) {
  FunctionHash** link =
      &external_function_data(env)->FunctionHashtable[HashSymbol(record.spec.name.c_str(), SIZE_FUNCTION_HASH)];
  while (*link != nullptr && (*link)->fdPtr != record.definition) link = &(*link)->next;
  if (*link == nullptr) return;
  record.hidden = *link;
  *link = record.hidden->next;
}

void RuleEngine::Impl::show(FunctionRecord& record) {
  if (record.hidden == nullptr) return;
  FunctionHash*& head =
      external_function_data(env)->FunctionHashtable[HashSymbol(record.spec.name.c_str(), SIZE_FUNCTION_HASH)];
  record.hidden->next = head;
  head = record.hidden;
  record.hidden = nullptr;
}

Status RuleEngine::add_function(FunctionSpec spec, Function function) {
  const auto refused = [&](const std::string& why) {
    return run_error("function '" + spec.name + "' of plugin '" + spec.owner + "' " + why);
  };
  const auto known = impl_->functions.find(spec.name);
  if (known != impl_->functions.end() && known->second->function) {
    return refused("exists already, from plugin '" + known->second->spec.owner + "'");
  }
  if (FindFunction(environment_, spec.name.c_str()) != nullptr) return refused("is a function of CLIPS");
  if (has("deffunction", spec.name) || has("defgeneric", spec.name)) return refused("is defined by rules");

  impl_->known_acting.clear();
  if (known != impl_->functions.end()) {
    FunctionRecord& old = *known->second;
    if (old.spec.returns == spec.returns && old.spec.arg_types == spec.arg_types &&
        old.spec.min_args == spec.min_args && old.spec.max_args == spec.max_args) {
      old.spec = std::move(spec);
      old.function = std::move(function);
      impl_->show(old);
      return {};
    }
  }

  auto record = std::make_unique<FunctionRecord>();
  record->engine = this;
  record->spec = std::move(spec);
  const FunctionSpec& made = record->spec;
  const AddUDFError error = AddUDF(environment_, made.name.c_str(), made.returns.c_str(), made.min_args, made.max_args,
                                   made.arg_types.empty() ? nullptr : made.arg_types.c_str(), CallFrame::run,
                                   made.name.c_str(), record.get());
  if (error != AUE_NO_ERROR) {
    spec = made;
    return refused(error == AUE_INVALID_ARGUMENT_TYPE_ERROR
                       ? "has argument types '" + made.arg_types + "' that CLIPS does not know"
                   : error == AUE_INVALID_RETURN_TYPE_ERROR
                       ? "returns '" + made.returns + "', which CLIPS does not know"
                       : "has more arguments at least than at most");
  }
  record->definition = FindFunction(environment_, made.name.c_str());
  record->function = std::move(function);
  const std::size_t typed = made.max_args == kAnyNumberOfArguments ? 16 : made.max_args;
  for (std::size_t i = 0; i < typed; ++i) {
    record->arg_bits.push_back(GetNthRestriction(environment_, record->definition, static_cast<unsigned>(i + 1)));
  }
  record->rest_bits = GetNthRestriction(environment_, record->definition, static_cast<unsigned>(typed + 1));
  if (known != impl_->functions.end()) {
    // Rules compiled with the old definition call the new function from now on.
    for (auto& old : impl_->replaced_functions) {
      if (old->spec.name == made.name) old->definition->context = record.get();
    }
    known->second->definition->context = record.get();
    impl_->replaced_functions.push_back(std::move(known->second));
    known->second = std::move(record);
  } else {
    const std::string name = made.name;
    impl_->functions.emplace(name, std::move(record));
  }
  return {};
}

bool RuleEngine::remove_function(const std::string& name) {
  const auto known = impl_->functions.find(name);
  if (known == impl_->functions.end() || !known->second->function) return false;
  known->second->function = nullptr;
  impl_->known_acting.clear();
  impl_->hide(*known->second);
  return true;
}

void RuleEngine::remove_functions_of(const std::string& owner) {
  for (auto& [name, record] : impl_->functions) {
    if (record->spec.owner == owner) remove_function(name);
  }
}

void RuleEngine::keep(const ValueRef& text) {
  RetainLexeme(environment_, static_cast<CLIPSLexeme*>(const_cast<void*>(text.atom())));
}

std::vector<FunctionSpec> RuleEngine::functions() const {
  std::vector<FunctionSpec> specs;
  for (const auto& [name, record] : impl_->functions) {
    if (record->function) specs.push_back(record->spec);
  }
  return specs;
}

}  // namespace cxlab
