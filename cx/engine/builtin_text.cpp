// Functions of CLIPS that make or read text: `format` without its fixed buffers, and a limit on nesting for what reads
// expressions.

#include <cstdio>
#include <cstring>

#include "internal/builtins.h"

namespace cxlab {

using namespace clips;

namespace {

constexpr std::size_t kLongestFlag = 80;      // as in CLIPS
constexpr std::size_t kMostDigits = 6;        // of a width or precision
constexpr int kLongestFormatted = 1'000'000;  // characters of one flag

/// A piece of a format string.
struct Piece {
  enum class Kind { kText, kFlag, kInvalid };
  Kind kind = Kind::kText;
  std::string text;  ///< of a flag: as printf takes it
};

/// The flag that follows a '%' at `at`, which moves behind it. A flag that is cut off is text.
Piece take_flag(std::string_view format, std::size_t& at) {
  static constexpr std::pair<char, const char*> kCharacters[] = {
      {'n', "\n"}, {'r', "\r"}, {'t', "\t"}, {'v', "\v"}, {'%', "%"}};
  for (const auto& [letter, text] : kCharacters) {
    if (at >= format.size() || format[at] != letter) continue;
    ++at;
    return {Piece::Kind::kText, text};
  }
  Piece piece{Piece::Kind::kText, "%"};
  while (at < format.size() && format[at] != '%' && piece.text.size() < kLongestFlag - 5) {
    const char c = format[at++];
    if (std::strchr("doxu", c) != nullptr) return {Piece::Kind::kFlag, piece.text + "ll" + c};
    piece.text += c;
    if (std::strchr("csefg", c) != nullptr) return {Piece::Kind::kFlag, piece.text};
    if (std::strchr("0123456789.-", c) == nullptr) return {Piece::Kind::kInvalid, piece.text};
  }
  return piece;
}

std::vector<Piece> pieces_of(std::string_view format) {
  std::vector<Piece> pieces;
  for (std::size_t at = 0; at < format.size();) {
    const std::size_t percent = std::min(format.find('%', at), format.size());
    if (percent > at) pieces.push_back({Piece::Kind::kText, std::string(format.substr(at, percent - at))});
    at = percent;
    if (at < format.size()) pieces.push_back(take_flag(format, ++at));
  }
  return pieces;
}

/// Whether a width or precision of the flag has too many digits.
bool is_huge(const std::string& flag) {
  std::size_t digits = 0;
  for (const char c : flag) {
    digits = c >= '0' && c <= '9' ? digits + 1 : 0;
    if (digits > kMostDigits) return true;
  }
  return false;
}

/// Adds what printf makes of it; false if that is too long.
template <class T>
bool add_printed(const std::string& flag, T value, std::string& out) {
  if (is_huge(flag)) return false;
  const int length = std::snprintf(nullptr, 0, flag.c_str(), value);
  if (length < 0 || length > kLongestFormatted) return false;
  const std::size_t before = out.size();
  out.resize(before + static_cast<std::size_t>(length) + 1);
  std::snprintf(out.data() + before, static_cast<std::size_t>(length) + 1, flag.c_str(), value);
  out.pop_back();
  return true;
}

enum class Added { kYes, kWrongType, kTooLong };

Added add_flag(const std::string& flag, const UDFValue& value, std::string& out) {
  const unsigned short type = value.header->type;
  const bool lexeme = type == STRING_TYPE || type == SYMBOL_TYPE;
  const bool integer = type == INTEGER_TYPE, real = type == FLOAT_TYPE;
  const auto added = [](bool fits) { return fits ? Added::kYes : Added::kTooLong; };
  switch (flag.back()) {
    case 's':
      if (!lexeme) return Added::kWrongType;
      return added(add_printed(flag, value.lexemeValue->contents, out));
    case 'c': {
      if (!lexeme && !integer) return Added::kWrongType;
      const char c = lexeme ? value.lexemeValue->contents[0] : static_cast<char>(value.integerValue->contents);
      if (c == '\0') return Added::kYes;
      return added(add_printed(flag, c, out));
    }
    case 'e':
    case 'f':
    case 'g':
      if (!integer && !real) return Added::kWrongType;
      return added(add_printed(
          flag, real ? value.floatValue->contents : static_cast<double>(value.integerValue->contents), out));
    default: {
      if (!integer && !real) return Added::kWrongType;
      if (!real) return added(add_printed(flag, value.integerValue->contents, out));
      const double number = value.floatValue->contents;
      const bool fits = number >= -0x1p63 && number < 0x1p63;
      return added(add_printed(flag, fits ? static_cast<long long>(number) : LLONG_MIN, out));
    }
  }
}

/// The logical name that the first argument means; empty if it is none.
std::string logical_name(const UDFValue& value) {
  switch (value.header->type) {
    case SYMBOL_TYPE:
    case STRING_TYPE:
    case INSTANCE_NAME_TYPE: {
      const std::string name = value.lexemeValue->contents;
      return name == "t" ? STDOUT : name;
    }
    case INTEGER_TYPE: return std::to_string(value.integerValue->contents);
    default: return {};
  }
}

}  // namespace

void format_function(Environment* env, UDFContext* context, UDFValue* result) {
  result->lexemeValue = CreateString(env, "");
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  const std::string name = logical_name(args[0]);
  if (name.empty()) {
    IllegalLogicalNameMessage(env, "format");
    return UDFThrowError(context);
  }
  if (name != "nil" && !QueryRouters(env, name.c_str())) return UnrecognizedRouterMessage(env, name.c_str());

  const std::vector<Piece> pieces = pieces_of(args[1].lexemeValue->contents);
  unsigned flags = 0;
  for (const Piece& piece : pieces) {
    if (piece.kind == Piece::Kind::kInvalid) {
      PrintErrorID(env, "IOFUN", 3, false);
      WriteString(env, STDERR, ("Invalid format flag \"" + piece.text + "\" specified in format function.\n").c_str());
      return UDFThrowError(context);
    }
    flags += piece.kind == Piece::Kind::kFlag;
  }
  if (flags + 2 != args.size()) {
    ExpectedCountError(env, "format", EXACTLY, flags + 2);
    return UDFThrowError(context);
  }
  std::string out;
  unsigned argument = 3;
  for (const Piece& piece : pieces) {
    if (piece.kind == Piece::Kind::kText) {
      out += piece.text;
      continue;
    }
    switch (add_flag(piece.text, args[argument - 1], out)) {
      case Added::kYes: break;
      case Added::kWrongType: {
        const char kind = piece.text.back();
        ExpectedTypeError1(env, "format", argument,
                           kind == 's'   ? "symbol or string"
                           : kind == 'c' ? "symbol, string, or integer"
                                         : "integer or float");
        return UDFThrowError(context);
      }
      case Added::kTooLong:
        complain(context, "'" + piece.text + "' gives more than a million characters");
        return UDFThrowError(context);
    }
    ++argument;
  }
  evaluation_data(env)->Steps += out.size() / kBytesOfAStep;
  result->lexemeValue = CreateString(env, out.c_str());
  if (name != "nil") WriteString(env, name.c_str(), out.c_str());
}

/// Calls the function of CLIPS, and counts the length of its texts. Whether it gives a text.
static bool call_with_texts(Environment* env, UDFContext* context, UDFValue* result) {
  evaluationData& counted = *evaluation_data(env);
  const bool outer = std::exchange(counted.TextsAreSteps, true);
  builtin_of(context).original(env, context, result);
  counted.TextsAreSteps = outer;
  const unsigned short type = result->header->type;
  if (type != STRING_TYPE && type != SYMBOL_TYPE) return false;
  counted.Steps += std::strlen(result->lexemeValue->contents) / kBytesOfAStep;
  return true;
}

/// A function that takes time with the length of its texts, and for making one.
void text_function(Environment* env, UDFContext* context, UDFValue* result) {
  if (call_with_texts(env, context, result)) evaluation_data(env)->Steps += kStepsOfAText;
}

/// One that reads each byte: a step.
void scanning_function(Environment* env, UDFContext* context, UDFValue* result) {
  const std::uint64_t before = evaluation_data(env)->Steps;
  (void)call_with_texts(env, context, result);
  evaluation_data(env)->Steps += (kBytesOfAStep - 1) * (evaluation_data(env)->Steps - before);
}

void nested_function(Environment*, UDFContext* context, UDFValue* result) {
  std::vector<UDFValue> args;
  if (!arguments(context, args)) return;
  count_parsed(context, std::strlen(args[0].lexemeValue->contents));
  if (const std::string excess = excess_of(args[0].lexemeValue->contents); !excess.empty())
    return refuse(context, result, excess);
  const Nesting nesting(context, result);
  if (!nesting) return;
  const bool asserts = UDFContextFunctionName(context) == std::string_view("assert-string");
  if (asserts) impl_of(context).asserted_text = args[0].lexemeValue->contents;
  call_original(context, result, args);
  impl_of(context).asserted_text = {};
}

}  // namespace cxlab
