#pragma once
// Values as text: in interface definitions, and in the YAML of messages.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

/// Smallest and largest value of an integer type.
struct IntegerRange {
  std::int64_t min = 0;
  std::uint64_t max = 0;
};
IntegerRange integer_range(FieldType type);

/// "uint8 from 0 to 255": what is expected, for errors.
std::string range_text(FieldType type);

/// Decimal, 0x, 0o or 0b, with sign. uint64 above the range of int64 wraps. Errors have no file and line yet.
Expected<std::int64_t> parse_integer(std::string_view text, FieldType type);
Expected<bool> parse_bool(std::string_view text);  ///< true, false, in lower case or with a capital, 0, 1
Expected<double> parse_real(std::string_view text);
/// Reads the text as a value of the field's type, other than a text or a message, and sets it.
Status set_from_text(const MessageView& message, const Field& field, std::string_view text, std::size_t index);
/// Removes one pair of equal quotes, with their escapes (\n \t \\ \" \'); a text without quotes is itself.
Expected<std::string> parse_text(std::string_view text);
/// The items of "[a, 'b, c', 3]", as written.
Expected<std::vector<std::string>> parse_list(std::string_view text);

std::string_view trim(std::string_view text);
std::string in_quotes(std::string_view text);
/// "; nearest is 'float64'", or nothing: the end of an error.
std::string nearest_is(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace cxlab::bus
