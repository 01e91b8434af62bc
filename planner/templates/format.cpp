// Python's `"..." % arguments` and `"...".format(arguments)`.

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {
namespace {

constexpr int kWidest = 10000;

struct Spec {
  std::string fill = " ";
  char align = 0;  ///< < > ^ =
  char sign = '-';
  bool alternate = false;
  bool group = false;
  int width = 0;
  int precision = -1;
  char type = 0;
};

std::string grouped(const std::string& digits) {
  const std::size_t whole = std::min(digits.find_first_not_of("0123456789"), digits.size());
  std::string out;
  for (std::size_t i = 0; i < whole; ++i) {
    if (i > 0 && (whole - i) % 3 == 0) out += ',';
    out += digits[i];
  }
  return out + digits.substr(whole);
}

std::string padded(const Spec& spec, const std::string& sign, const std::string& body, char otherwise) {
  const std::size_t size = length_of(sign) + length_of(body);
  if (static_cast<std::size_t>(spec.width) <= size) return sign + body;
  const std::size_t missing = static_cast<std::size_t>(spec.width) - size;
  const auto fill = [&](std::size_t count) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) out += spec.fill;
    return out;
  };
  switch (spec.align != 0 ? spec.align : otherwise) {
    case '<': return sign + body + fill(missing);
    case '^': return fill(missing / 2) + sign + body + fill(missing - missing / 2);
    case '=': return sign + fill(missing) + body;
    default: return fill(missing) + sign + body;
  }
}

std::string whole_text(const Spec& spec, std::int64_t value) {
  const std::uint64_t size = value < 0 ? ~static_cast<std::uint64_t>(value) + 1 : static_cast<std::uint64_t>(value);
  const int base = spec.type == 'x' || spec.type == 'X' ? 16 : spec.type == 'o' ? 8 : spec.type == 'b' ? 2 : 10;
  std::array<char, 64> buffer{};
  std::string digits(buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), size, base).ptr);
  if (spec.type == 'X')
    for (char& c : digits) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (spec.alternate && base != 10) digits = std::string("0") + spec.type + digits;
  return digits;
}

std::string real_text(const Spec& spec, double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : "inf";
  char buffer[512];
  const int precision = std::min(spec.precision < 0 ? 6 : spec.precision, 100);
  const char type = spec.type == 0 ? 'g' : spec.type == '%' ? 'f' : spec.type;
  const std::string form = std::string("%.*") + type;
  std::snprintf(buffer, sizeof buffer, form.c_str(), precision, spec.type == '%' ? value * 100 : value);
  return spec.type == '%' ? std::string(buffer) + "%" : buffer;
}

Value formatted(Interpreter& interpreter, const Spec& spec, const Value& value) {
  if (spec.width > kWidest || spec.precision > kWidest) return interpreter.fail("the width of a format is too large");
  const bool real_type = spec.type != 0 && std::string("eEfFgG%").find(spec.type) != std::string::npos;
  const bool whole_type = spec.type != 0 && std::string("dixXob").find(spec.type) != std::string::npos;
  if (spec.type == 's' || (spec.type == 0 && !value.is_number()) || (spec.type == 0 && value.is_bool())) {
    if (spec.type == 's' && value.is_undefined()) return padded(spec, "", "", '<');
    std::string text = value.str();
    if (spec.precision >= 0) {
      const auto points = code_points(text);
      text.clear();
      for (std::size_t i = 0; i < points.size() && i < static_cast<std::size_t>(spec.precision); ++i) text += points[i];
    }
    return padded(spec, "", text, '<');
  }
  if (!real_type && !whole_type && spec.type != 0)
    return interpreter.fail(std::string("found the format '") + spec.type + "', which is not known");
  if (!value.is_number())
    return interpreter.fail(std::string("found ") + value.repr() + " for the format '" + spec.type +
                            "', expected a number");
  const bool real = real_type || (spec.type == 0 && value.is_float());
  if (whole_type && value.is_float() && spec.type != 'd' && spec.type != 'i')
    return interpreter.fail("found a float, expected a whole number");
  if (!real && value.is_float() && !(std::abs(value.as_float()) < 0x1p63))
    return interpreter.fail("found " + value.repr() + ", which is too large for a whole number");
  const bool negative = real ? std::signbit(value.as_float()) : value.as_int() < 0;
  const std::string sign = negative ? "-" : spec.sign == '+' ? "+" : spec.sign == ' ' ? " " : "";
  std::string body;
  if (!real) {
    body = whole_text(spec, value.as_int());
    if (spec.precision > static_cast<int>(body.size()))
      body.insert(0, static_cast<std::size_t>(spec.precision) - body.size(), '0');
  } else if (spec.type == 0 && spec.precision < 0) {
    body = float_text(std::abs(value.as_float()));
  } else {
    body = real_text(spec, std::abs(value.as_float()));
  }
  if (spec.group) body = grouped(body);
  return padded(spec, sign, body, '>');
}

int digits(const std::string& text, std::size_t& at) {
  int number = 0;
  for (; at < text.size() && text[at] >= '0' && text[at] <= '9'; ++at)
    number = std::min(number * 10 + (text[at] - '0'), kWidest + 1);
  return number;
}

/// `[[fill]align][sign][#][0][width][,][.precision][type]`
std::optional<Spec> parse_spec(const std::string& text) {
  Spec spec;
  std::size_t at = 0;
  const auto is_align = [](char c) { return c == '<' || c == '>' || c == '^' || c == '='; };
  const auto points = code_points(text);
  if (points.size() > 1 && points[1].size() == 1 && is_align(points[1][0])) {
    spec.fill = points[0];
    spec.align = points[1][0];
    at = points[0].size() + 1;
  } else if (!text.empty() && is_align(text[0])) {
    spec.align = text[at++];
  }
  if (at < text.size() && (text[at] == '+' || text[at] == '-' || text[at] == ' ')) spec.sign = text[at++];
  if (at < text.size() && text[at] == '#') spec.alternate = (++at, true);
  if (at < text.size() && text[at] == '0') {
    if (spec.align == 0) {
      spec.align = '=';
      spec.fill = "0";
    }
    ++at;
  }
  spec.width = digits(text, at);
  if (at < text.size() && text[at] == ',') spec.group = (++at, true);
  if (at < text.size() && text[at] == '.') spec.precision = digits(text, ++at);
  if (at < text.size()) spec.type = text[at++];
  if (at != text.size()) return std::nullopt;
  return spec;
}

/// `name`, `0`, `name.attribute`, `0[key]`
Value field(Interpreter& interpreter, const std::string& path, const Call& call, std::size_t& automatic) {
  std::size_t at = std::min(path.find_first_of(".["), path.size());
  const std::string first = path.substr(0, at);
  Value value;
  if (first.empty() || first.find_first_not_of("0123456789") == std::string::npos) {
    std::size_t digit = 0;
    const std::size_t index = first.empty() ? automatic++ : static_cast<std::size_t>(digits(first, digit));
    if (index >= call.positional.size())
      return interpreter.fail("found no argument " + std::to_string(index) + " for a format");
    value = call.positional[index];
  } else {
    bool known = false;
    for (const auto& [name, named] : call.named)
      if (name == first) {
        value = named;
        known = true;
      }
    if (!known) return interpreter.fail("found no argument '" + first + "' for a format");
  }
  while (at < path.size() && !interpreter.failed()) {
    const bool bracket = path[at] == '[';
    const std::size_t end = bracket ? path.find(']', at) : std::min(path.find_first_of(".[", at + 1), path.size());
    if (end == std::string::npos) return interpreter.fail("found a '[' without ']' in a format");
    const std::string key = path.substr(at + 1, end - at - 1);
    std::size_t digit = 0;
    if (!bracket) {
      value = interpreter.attribute(value, key);
    } else if (!key.empty() && key.find_first_not_of("0123456789") == std::string::npos) {
      value = interpreter.item(value, digits(key, digit));
    } else {
      value = interpreter.item(value, key);
    }
    at = bracket ? end + 1 : end;
  }
  return value;
}

}  // namespace

Value format_braces(Interpreter& interpreter, const std::string& format, const Call& call) {
  std::string out;
  std::size_t automatic = 0;
  for (std::size_t i = 0; i < format.size() && !interpreter.failed(); ++i) {
    const char c = format[i];
    if ((c == '{' || c == '}') && i + 1 < format.size() && format[i + 1] == c) {
      out += c;
      ++i;
      continue;
    }
    if (c == '}') return interpreter.fail("found a single '}' in a format");
    if (c != '{') {
      out += c;
      continue;
    }
    const std::size_t end = format.find('}', i);
    if (end == std::string::npos) return interpreter.fail("found a single '{' in a format");
    std::string path = format.substr(i + 1, end - i - 1), spec_text, conversion;
    if (const std::size_t colon = path.find(':'); colon != std::string::npos) {
      spec_text = path.substr(colon + 1);
      path.resize(colon);
    }
    if (const std::size_t mark = path.find('!'); mark != std::string::npos) {
      conversion = path.substr(mark + 1);
      path.resize(mark);
    }
    Value value = field(interpreter, path, call, automatic);
    if (conversion == "r") value = value.repr();
    if (conversion == "s") value = value.str();
    if (value.is_undefined() && !spec_text.empty() && !interpreter.require(value)) return {};
    const auto spec = parse_spec(spec_text);
    if (!spec ||
        (spec->precision >= 0 && (value.is_whole() && !value.is_bool()) && (spec->type == 0 || spec->type == 'd')))
      return interpreter.fail("found the format '" + spec_text + "' for " + value.repr() + ", which is not understood");
    if (!spec_text.empty() && (value.as_list() != nullptr || value.as_dict() != nullptr || value.is_none()))
      return interpreter.fail("found " + value.repr() +
                              " for a format with a width or type, expected a text or a number");
    const std::string piece = formatted(interpreter, *spec, value).str();
    if (!interpreter.spend(1, piece.size())) return {};
    out += piece;
    i = end;
  }
  return out;
}

Value format_percent(Interpreter& interpreter, const std::string& format, const Value& argument) {
  std::string out;
  std::size_t next = 0;
  const ListData* tuple = argument.as_list();
  if (tuple != nullptr && !tuple->tuple) tuple = nullptr;
  const std::size_t count = tuple != nullptr ? tuple->items.size() : 1;
  bool by_name = false;
  for (std::size_t i = 0; i < format.size() && !interpreter.failed(); ++i) {
    if (format[i] != '%') {
      out += format[i];
      continue;
    }
    if (++i >= format.size()) return interpreter.fail("found the end of a format behind '%'");
    if (format[i] == '%') {
      out += '%';
      continue;
    }
    Value value;
    bool found = false;
    if (format[i] == '(') {
      const std::size_t end = format.find(')', i);
      if (end == std::string::npos) return interpreter.fail("found a '(' without ')' in a format");
      value = interpreter.item(argument, format.substr(i + 1, end - i - 1));
      found = by_name = true;
      i = end + 1;
    }
    Spec spec;
    spec.align = '>';
    for (; i < format.size() && std::string("-+ #0").find(format[i]) != std::string::npos; ++i) {
      if (format[i] == '-') spec.align = '<';
      if (format[i] == '+' || format[i] == ' ') spec.sign = format[i];
      if (format[i] == '#') spec.alternate = true;
      if (format[i] == '0' && spec.align != '<') spec.fill = "0";
    }
    spec.width = digits(format, i);
    if (i < format.size() && format[i] == '.') spec.precision = digits(format, ++i);
    if (i >= format.size()) return interpreter.fail("found an incomplete format");
    spec.type = format[i];
    if (!found) {
      if (next >= count) return interpreter.fail("found too few arguments for a format");
      value = tuple != nullptr ? tuple->items[next] : argument;
      ++next;
    }
    if (spec.type == 'r') value = value.repr();
    if (spec.type == 'r' || spec.type == 's') {
      spec.type = 's';
      spec.fill = " ";
    }
    if (spec.type == 'i' || spec.type == 'u') spec.type = 'd';
    if (spec.fill == "0" && spec.align != '<') spec.align = '=';
    if (spec.align == '<') spec.fill = " ";
    const std::string piece = formatted(interpreter, spec, value).str();
    if (!interpreter.spend(1, piece.size())) return {};
    out += piece;
  }
  if (!by_name && tuple != nullptr && next < count) return interpreter.fail("found too many arguments for a format");
  if (!by_name && tuple == nullptr && next == 0 && argument.as_dict() == nullptr && argument.as_list() == nullptr)
    return interpreter.fail("found too many arguments for a format");
  return out;
}

}  // namespace cxlab::planner::templates
