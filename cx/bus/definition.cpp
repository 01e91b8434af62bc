#include "cx/bus/definition.h"

#include <algorithm>
#include <array>

#include "cx/bus/literal.h"

namespace cxlab::bus {

namespace {

constexpr std::size_t kMaxElements = std::size_t{1} << 24;

/// "bool" to "wstring", in the order of FieldType.
const std::vector<std::string>& primitives() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> all;
    for (int type = 0; type < static_cast<int>(FieldType::kMessage); ++type)
      all.emplace_back(to_string(static_cast<FieldType>(type)));
    return all;
  }();
  return words;
}

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Words of ROS: a letter first, single underscores between letters and digits, none at the end.
template <class IsLetter>
bool is_word(std::string_view text, IsLetter is_letter) {
  if (text.empty() || !is_letter(text.front()) || text.back() == '_') return false;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '_' ? text[i - 1] == '_' : !is_letter(text[i]) && !is_digit(text[i])) return false;
  }
  return true;
}

/// Cuts the first characters up to one of `stops` or white space off `rest`.
std::string_view take_word(std::string_view& rest, std::string_view stops) {
  rest = trim(rest);
  std::size_t end = 0;
  while (end < rest.size() && rest[end] != ' ' && rest[end] != '\t' && stops.find(rest[end]) == std::string_view::npos)
    ++end;
  const std::string_view word = rest.substr(0, end);
  rest = trim(rest.substr(end));
  return word;
}

/// Without the comment. '#' inside quotes is text.
std::string_view value_part(std::string_view text) {
  if (text.empty()) return text;
  const bool may_quote = text.front() == '"' || text.front() == '\'' || text.front() == '[';
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quote != 0) {
      if (text[i] == '\\')
        ++i;
      else if (text[i] == quote)
        quote = 0;
    } else if (text[i] == '#') {
      return trim(text.substr(0, i));
    } else if (may_quote && (text[i] == '"' || text[i] == '\'')) {
      quote = text[i];
    }
  }
  return trim(text);
}

class LineParser {
 public:
  LineParser(const std::string& file, int line) : file_(file), line_(line) {}

  Error fail(std::string message) const { return input_error(std::move(message), file_, line_); }

  Status parse(std::string_view text, Section& section) const {
    FieldSpec spec;
    spec.line = line_;
    std::string_view rest = text;
    const std::string_view type_word = take_word(rest, "#");
    if (Status status = parse_type(type_word, spec); !status) return status;
    const std::string_view name = take_word(rest, "=#");
    if (name.empty()) return fail("found no name after the type " + in_quotes(type_word));
    spec.field.name = name;
    if (!rest.empty() && rest.front() == '=') return add_constant(spec, value_part(trim(rest.substr(1))), section);
    return add_field(std::move(spec), value_part(rest), section);
  }

 private:
  Status parse_type(std::string_view word, FieldSpec& spec) const {
    Field& field = spec.field;
    std::string_view base = word;
    if (const auto bracket = base.find('['); bracket != std::string_view::npos) {
      if (base.back() != ']') return fail(found_expected(in_quotes(word), "an array like T[], T[3] or T[<=3]"));
      std::string_view size = base.substr(bracket + 1, base.size() - bracket - 2);
      base = base.substr(0, bracket);
      field.array = size.empty() ? ArrayKind::kUnbounded : ArrayKind::kFixed;
      if (size.substr(0, 2) == "<=") {
        field.array = ArrayKind::kBounded;
        size.remove_prefix(2);
      }
      if (field.array != ArrayKind::kUnbounded)
        if (Status status = parse_limit(size, word, field.size_limit); !status) return status;
    }
    if (const auto bound = base.find("<="); bound != std::string_view::npos) {
      if (base.substr(0, bound) != "string" && base.substr(0, bound) != "wstring")
        return fail("found " + in_quotes(word) + ": only string and wstring have a bound of this kind");
      if (Status status = parse_limit(base.substr(bound + 2), word, field.string_limit); !status) return status;
      base = base.substr(0, bound);
    }
    const auto primitive = std::ranges::find(primitives(), base);
    if (primitive != primitives().end()) {
      field.type = static_cast<FieldType>(primitive - primitives().begin());
      return {};
    }
    return parse_nested(base, word, spec);
  }

  Status parse_nested(std::string_view base, std::string_view word, FieldSpec& spec) const {
    std::array<std::string_view, 3> parts;
    std::size_t count = 0;
    for (std::string_view rest = base;; ++count) {
      const auto slash = rest.find('/');
      if (count < parts.size()) parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    ++count;
    const std::string_view type = count <= 3 ? parts[count - 1] : std::string_view{};
    const auto letter = [](char c) { return is_lower(c) || is_upper(c); };
    const bool good_package = count == 1 || is_word(parts[0], is_lower);
    const bool good_kind = count < 3 || parts[1] == "msg";
    if (type.empty() || !is_upper(type.front()) ||
        !std::ranges::all_of(type, [&](char c) { return letter(c) || is_digit(c); }) || !good_package || !good_kind) {
      return fail(found_expected("type " + in_quotes(word), "a primitive type, Name, package/Name or package/msg/Name" +
                                                                nearest_is(std::string(base), primitives())));
    }
    spec.field.type = FieldType::kMessage;
    spec.nested_name = base;
    return {};
  }

  Status parse_limit(std::string_view text, std::string_view word, std::size_t& limit) const {
    const auto value = parse_integer(text, FieldType::kUint32);
    if (!value || !is_digit(text.front()) || *value < 1 || *value > static_cast<std::int64_t>(kMaxElements))
      return fail(found_expected(in_quotes(text) + " in " + in_quotes(word),
                                 "a number from 1 to " + std::to_string(kMaxElements)));
    limit = static_cast<std::size_t>(*value);
    return {};
  }

  Status add_constant(const FieldSpec& spec, std::string_view value, Section& section) const {
    const Field& field = spec.field;
    if (!is_word(field.name, is_upper))
      return fail(found_expected("constant " + in_quotes(field.name), "a name in capitals like MAX_SPEED"));
    if (field.is_message() || field.array != ArrayKind::kSingle)
      return fail("constant " + in_quotes(field.name) + " has type " + in_quotes(field.type_text()) +
                  ", expected a primitive type, not an array");
    if (find_constant(section, field.name)) return fail("constant " + in_quotes(field.name) + " is defined twice");
    if (value.empty() && !field.is_text()) return fail("constant " + in_quotes(field.name) + " has no value");
    Constant constant{field.name, field.type, std::string(value)};
    Status status;
    if (field.is_text()) {
      auto text = parse_text(value);
      if (!text) return fail("constant " + in_quotes(field.name) + ": " + text.error().message);
      constant.value_text = std::move(*text);
    } else if (field.is_real()) {
      if (const auto real = parse_real(value); !real) status = real.error();
    } else if (field.type == FieldType::kBool) {
      if (const auto flag = parse_bool(value); !flag) status = flag.error();
    } else if (const auto integer = parse_integer(value, field.type); !integer) {
      status = integer.error();
    }
    if (!status) return fail("constant " + in_quotes(field.name) + ": " + status.error().message);
    section.constants.push_back(std::move(constant));
    return {};
  }

  Status add_field(FieldSpec spec, std::string_view value, Section& section) const {
    const std::string& name = spec.field.name;
    if (!is_word(name, is_lower))
      return fail(
          found_expected("field " + in_quotes(name), std::string("a name in lower case like max_speed") +
                                                         (is_word(name, is_upper) ? " (a constant needs '=')" : "")));
    for (const FieldSpec& other : section.fields)
      if (other.field.name == name)
        return fail("field " + in_quotes(name) + " is defined twice, first in line " + std::to_string(other.line));
    if (spec.field.is_message() && !value.empty())
      return fail("found default " + in_quotes(value) + " of field " + in_quotes(name) +
                  ": only primitive types have defaults");
    spec.field.default_text = value;
    section.fields.push_back(std::move(spec));
    return {};
  }

  static bool find_constant(const Section& section, const std::string& name) {
    return std::ranges::any_of(section.constants, [&](const Constant& c) { return c.name == name; });
  }

  const std::string& file_;
  int line_;
};

}  // namespace

Expected<std::vector<Section>> parse_definition(std::string_view text, const std::string& file, std::size_t sections) {
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);  // byte order mark
  std::vector<Section> result(1);
  int line = 0;
  while (!text.empty()) {
    ++line;
    const auto end = text.find('\n');
    const std::string_view row = trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (row.empty() || row.front() == '#') continue;
    if (row.substr(0, 3) == "---") {
      if (result.size() == sections)
        return input_error("found one '---' more than the " + std::to_string(sections - 1) + " expected", file, line);
      result.emplace_back();
      continue;
    }
    if (Status status = LineParser(file, line).parse(row, result.back()); !status) return status.error();
  }
  if (result.size() != sections)
    return input_error(
        found_expected(std::to_string(result.size() - 1) + " lines of '---'", std::to_string(sections - 1)), file,
        line);
  return result;
}

}  // namespace cxlab::bus
