// Functions of CLIPS 6.4.2 that 6.40, on which cxlab builds, lacks or answers in another way.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <unordered_set>

#include "internal/builtins.h"

namespace cxlab {

using namespace clips;

namespace {

/// Values are atoms: those that are equal are the same.
using Values = std::unordered_set<const void*>;

Values values_of(const UDFValue& field) {
  Values values;
  for (std::size_t i = 0; i < field.range; ++i) values.insert(field.multifieldValue->contents[field.begin + i].value);
  return values;
}

/// Collects the values of `field` for which `takes` is true, each once, in order.
template <class Takes>
void collect(const UDFValue& field, Values& seen, MultifieldBuilder* to, Takes takes) {
  for (std::size_t i = 0; i < field.range; ++i) {
    CLIPSValue value;
    value.value = field.multifieldValue->contents[field.begin + i].value;
    if (takes(value.value) && seen.insert(value.value).second) MBAppend(to, &value);
  }
}

/// The arguments; none after an error.
std::optional<std::vector<UDFValue>> multifields(UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> all;
  while (UDFHasNextArgument(context)) {
    UDFValue value;
    if (!UDFNextArgument(context, MULTIFIELD_BIT, &value)) {
      result->multifieldValue = EmptyMultifield(context->environment);
      result->begin = result->range = 0;
      return {};
    }
    all.push_back(value);
  }
  return all;
}

void give(MultifieldBuilder* made, UDFValue* result) {
  result->multifieldValue = MBCreate(made);
  result->begin = 0;
  result->range = result->multifieldValue->length;
  MBDispose(made);
}

void union_function(Environment* env, UDFContext* context, UDFValue* result) {
  const auto all = multifields(context, result);
  if (!all) return;
  MultifieldBuilder* made = CreateMultifieldBuilder(env, 8);
  Values seen;
  for (const UDFValue& field : *all) collect(field, seen, made, [](const void*) { return true; });
  give(made, result);
}

/// Values of the first argument that are in all others, or in none.
void compare_with_others(Environment* env, UDFContext* context, UDFValue* result, bool in_others) {
  const auto all = multifields(context, result);
  if (!all) return;
  std::vector<Values> others;
  for (std::size_t i = 1; i < all->size(); ++i) others.push_back(values_of((*all)[i]));
  MultifieldBuilder* made = CreateMultifieldBuilder(env, 8);
  Values seen;
  if (!all->empty())
    collect(all->front(), seen, made, [&](const void* value) {
      return std::all_of(others.begin(), others.end(), [&](const Values& o) { return o.contains(value) == in_others; });
    });
  give(made, result);
}

void intersection_function(Environment* env, UDFContext* context, UDFValue* result) {
  compare_with_others(env, context, result, true);
}

void difference_function(Environment* env, UDFContext* context, UDFValue* result) {
  compare_with_others(env, context, result, false);
}

void byte_length_function(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue text;
  const bool given = UDFFirstArgument(context, LEXEME_BITS | INSTANCE_NAME_BIT, &text);
  result->integerValue =
      CreateInteger(env, given ? static_cast<long long>(std::strlen(text.lexemeValue->contents)) : -1);
}

/// Halves go away from zero; 6.40 lets them go up.
void round_function(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue number;
  if (!UDFFirstArgument(context, NUMBER_BITS, &number)) {
    result->integerValue = CreateInteger(env, 0);
  } else if (number.header->type == INTEGER_TYPE) {
    result->integerValue = number.integerValue;
  } else {
    const double rounded = std::round(number.floatValue->contents);
    const bool fits = rounded >= -0x1p63 && rounded < 0x1p63;
    result->integerValue = CreateInteger(env, fits ? static_cast<long long>(rounded) : INT64_MIN);
  }
}

}  // namespace

void install_later_functions(Environment* env) {
  AddUDF(env, "union$", "m", 0, UNBOUNDED, "m", union_function, "union_function", nullptr);
  AddUDF(env, "intersection$", "m", 0, UNBOUNDED, "m", intersection_function, "intersection_function", nullptr);
  AddUDF(env, "difference$", "m", 1, UNBOUNDED, "m", difference_function, "difference_function", nullptr);
  AddUDF(env, "str-byte-length", "l", 1, 1, "syn", byte_length_function, "byte_length_function", nullptr);
  FindFunction(env, "round")->functionPointer = round_function;
}

}  // namespace cxlab
