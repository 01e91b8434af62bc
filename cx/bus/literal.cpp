#include "cx/bus/literal.h"

#include <charconv>
#include <limits>

namespace cxlab::bus {

namespace {

template <class T>
IntegerRange range_of() {
  return {std::numeric_limits<T>::min(), static_cast<std::uint64_t>(std::numeric_limits<T>::max())};
}

}  // namespace

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string nearest_is(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_word(word, candidates);
  return nearest.empty() ? nearest : "; nearest is " + in_quotes(nearest);
}

IntegerRange integer_range(FieldType type) {
  switch (type) {
    case FieldType::kBool: return {0, 1};
    case FieldType::kInt8: return range_of<std::int8_t>();
    case FieldType::kInt16: return range_of<std::int16_t>();
    case FieldType::kUint16: return range_of<std::uint16_t>();
    case FieldType::kInt32: return range_of<std::int32_t>();
    case FieldType::kUint32: return range_of<std::uint32_t>();
    case FieldType::kInt64: return range_of<std::int64_t>();
    case FieldType::kUint64: return {0, std::numeric_limits<std::uint64_t>::max()};
    default: return range_of<std::uint8_t>();  // byte, char, uint8
  }
}

std::string range_text(FieldType type) {
  const IntegerRange range = integer_range(type);
  return std::string(to_string(type)) + " from " + std::to_string(range.min) + " to " + std::to_string(range.max);
}

std::string_view trim(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const auto first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

Expected<std::int64_t> parse_integer(std::string_view text, FieldType type) {
  std::string_view digits = text;
  const bool negative = !digits.empty() && digits.front() == '-';
  if (!digits.empty() && (digits.front() == '-' || digits.front() == '+')) digits.remove_prefix(1);
  int base = 10;
  if (digits.size() > 2 && digits[0] == '0') {
    const char mark = static_cast<char>(digits[1] | 0x20);
    base = mark == 'x' ? 16 : mark == 'o' ? 8 : mark == 'b' ? 2 : 10;
    if (base != 10) digits.remove_prefix(2);
  }
  std::uint64_t magnitude = 0;
  const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), magnitude, base);
  const bool out_of_range = failure == std::errc::result_out_of_range;
  if (!out_of_range && (failure != std::errc{} || end != digits.data() + digits.size()))
    return input_error(found_expected(in_quotes(text), "an integer of " + range_text(type)));
  const IntegerRange range = integer_range(type);
  const std::uint64_t limit = negative ? std::uint64_t{0} - static_cast<std::uint64_t>(range.min) : range.max;
  if (out_of_range || magnitude > limit) return input_error(found_expected(std::string(text), range_text(type)));
  return static_cast<std::int64_t>(negative ? std::uint64_t{0} - magnitude : magnitude);
}

Expected<bool> parse_bool(std::string_view text) {
  if (text == "true" || text == "True" || text == "1") return true;
  if (text == "false" || text == "False" || text == "0") return false;
  return input_error(found_expected(in_quotes(text), "true or false"));
}

Expected<double> parse_real(std::string_view text) {
  std::string_view digits = text;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (failure == std::errc::result_out_of_range)
    return input_error(found_expected(std::string(text), "a number that a float64 can hold"));
  if (failure != std::errc{} || end != digits.data() + digits.size())
    return input_error(found_expected(in_quotes(text), "a number"));
  return value;
}

Status set_from_text(const MessageView& message, const Field& field, std::string_view text, std::size_t index) {
  if (field.is_real()) {
    const auto real = parse_real(text);
    if (!real) return real.error();
    message.set_real(field, *real, index);
    return {};
  }
  if (field.type == FieldType::kBool) {
    const auto flag = parse_bool(text);
    return flag ? message.set_integer(field, *flag, index) : Status(flag.error());
  }
  const auto integer = parse_integer(text, field.type);
  return integer ? message.set_integer(field, *integer, index) : Status(integer.error());
}

Expected<std::string> parse_text(std::string_view text) {
  if (text.empty() || (text.front() != '"' && text.front() != '\'')) return std::string(text);
  const char quote = text.front();
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == quote) {
      if (i + 1 == text.size()) return value;
      return input_error(found_expected(in_quotes(text.substr(i + 1)) + " after the closing quote", "the end"));
    }
    if (text[i] == '\\' && i + 1 < text.size()) {
      const char escaped = text[++i];
      if (escaped == 'n')
        value += '\n';
      else if (escaped == 't')
        value += '\t';
      else if (escaped == '\\' || escaped == '"' || escaped == '\'')
        value += escaped;
      else
        value.append({'\\', escaped});
    } else {
      value += text[i];
    }
  }
  return input_error("found no closing " + std::string(1, quote) + " in " + std::string(text));
}

Expected<std::vector<std::string>> parse_list(std::string_view text) {
  if (text.size() < 2 || text.front() != '[' || text.back() != ']')
    return input_error(found_expected(in_quotes(text), "a list like [1, 2]"));
  text = text.substr(1, text.size() - 2);
  std::vector<std::string> items;
  if (trim(text).empty()) return items;
  std::size_t start = 0;
  char quote = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && quote != 0) {
      if (text[i] == '\\')
        ++i;
      else if (text[i] == quote)
        quote = 0;
    } else if (i == text.size() || text[i] == ',') {
      const std::string_view item = trim(text.substr(start, i - start));
      if (item.empty()) return input_error("found an empty item in [" + std::string(text) + "]");
      items.emplace_back(item);
      start = i + 1;
    } else if ((text[i] == '"' || text[i] == '\'') && trim(text.substr(start, i - start)).empty()) {
      quote = text[i];
    }
  }
  return items;
}

}  // namespace cxlab::bus
