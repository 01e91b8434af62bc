#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "cx/base/expected.h"
#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {
namespace {

using Filter = Value (*)(Interpreter&, const Value&, const Call&);

Arguments given(Interpreter& self, const char* name, const Call& call, std::string_view names) {
  return Arguments(self, std::string("the filter ") + name, call, names);
}

/// `a.b.0` of an item; the item itself if there is no attribute.
Value part_of(Interpreter& self, const Value& item, const Value* attribute) {
  if (attribute == nullptr || attribute->is_none()) return item;
  if (attribute->is_int()) return self.item(item, *attribute);
  Value value = item;
  const std::string path = attribute->str();
  for (std::size_t at = 0; at <= path.size() && !self.failed();) {
    const std::size_t end = std::min(path.find('.', at), path.size());
    const std::string name = path.substr(at, end - at);
    const bool number = !name.empty() && name.size() < 9 && name.find_first_not_of("0123456789") == std::string::npos;
    value = self.item(value, number ? Value(std::stoi(name)) : Value(name));
    at = end + 1;
  }
  return value;
}

Value folded(const Value& value, bool case_sensitive) {
  return !case_sensitive && value.is_string() ? Value(lower(value.as_string())) : value;
}

std::vector<Value> sorted(Interpreter& self, std::vector<Value> values, const Value* attribute, bool case_sensitive,
                          bool reverse) {
  struct Keyed {
    std::vector<Value> keys;
    Value value;
  };
  std::vector<Value> attributes;  // several, separated by commas
  if (attribute != nullptr && attribute->is_string()) {
    const std::string all = attribute->as_string();
    for (std::size_t at = 0; at <= all.size();) {
      const std::size_t end = std::min(all.find(',', at), all.size());
      attributes.emplace_back(all.substr(at, end - at));
      at = end + 1;
    }
  } else if (attribute != nullptr && !attribute->is_none()) {
    attributes.push_back(*attribute);
  }
  std::vector<Keyed> keyed;
  for (Value& value : values) {
    Keyed each{{}, value};
    for (const Value& name : attributes) each.keys.push_back(folded(part_of(self, value, &name), case_sensitive));
    if (attributes.empty()) each.keys.push_back(folded(value, case_sensitive));
    keyed.push_back(std::move(each));
  }
  const auto before = [&](const Keyed& a, const Keyed& b) {
    for (std::size_t i = 0; i < a.keys.size(); ++i) {
      if (self.failed()) return false;
      if (a.keys[i].equals(b.keys[i])) continue;
      return self.less(a.keys[i], b.keys[i]);
    }
    return false;
  };
  self.spend(keyed.size() * 8);
  // Insertion into a sorted list stays defined when an order does not hold together.
  std::vector<Keyed> out;
  for (Keyed& each : keyed) {
    if (self.failed()) break;
    const auto at = std::upper_bound(out.begin(), out.end(), each, [&](const Keyed& a, const Keyed& b) {
      return reverse ? before(b, a) : before(a, b);
    });
    out.insert(at, std::move(each));
  }
  values.clear();
  for (Keyed& each : out) values.push_back(std::move(each.value));
  return values;
}

Value filter_abs(Interpreter& self, const Value& subject, const Call&) {
  if (!self.require(subject)) return {};
  if (subject.is_float()) return std::abs(subject.as_float());
  if (!subject.is_whole()) return self.fail("found " + subject.repr() + ", expected a number");
  std::int64_t size = subject.as_int();
  if (size < 0 && __builtin_sub_overflow(std::int64_t{0}, size, &size)) return self.fail("the number is too large");
  return size;
}

Value filter_attr(Interpreter& self, const Value& subject, const Call& call) {
  const std::string name = given(self, "attr", call, "name").text(0, "");
  if (subject.as_dict() != nullptr && !has_method(subject, name))
    return Value::undefined(name);  // attributes only, not items
  return self.attribute(subject, name);
}

Value filter_batch(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "batch", call, "linecount fill_with");
  const std::int64_t size = arguments.integer(0, 0);
  std::vector<Value> rows, row;
  for (Value& item : self.items(subject)) {
    if (static_cast<std::int64_t>(row.size()) == size) rows.push_back(Value::list(std::exchange(row, {})));
    row.push_back(std::move(item));
  }
  if (!row.empty()) {
    while (arguments.has(1) && static_cast<std::int64_t>(row.size()) < size && self.spend(1))
      row.push_back(*arguments[1]);
    rows.push_back(Value::list(std::move(row)));
  }
  return Value::list(std::move(rows));
}

Value filter_slice(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "slice", call, "slices fill_with");
  const std::int64_t slices = arguments.integer(0, 1);
  if (slices < 1 || slices > 100000)
    return self.fail("found " + std::to_string(slices) + " slices, expected 1 to 100000");
  const std::vector<Value> items = self.items(subject);
  const std::size_t each = items.size() / static_cast<std::size_t>(slices),
                    more = items.size() % static_cast<std::size_t>(slices);
  std::vector<Value> out;
  std::size_t at = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(slices); ++i) {
    std::vector<Value> part;
    for (std::size_t k = 0; k < each + (i < more ? 1 : 0); ++k) part.push_back(items[at++]);
    if (arguments.has(1) && i >= more) part.push_back(*arguments[1]);
    out.push_back(Value::list(std::move(part)));
  }
  return Value::list(std::move(out));
}

Value filter_method(Interpreter& self, const Value& subject, std::string_view method, const Call& call) {
  return call_method(self, Value(subject.str()), method, call);
}
Value filter_capitalize(Interpreter& self, const Value& subject, const Call& call) {
  return filter_method(self, subject, "capitalize", call);
}
Value filter_lower(Interpreter&, const Value& subject, const Call&) { return lower(subject.str()); }
Value filter_upper(Interpreter&, const Value& subject, const Call&) { return upper(subject.str()); }
Value filter_string(Interpreter&, const Value& subject, const Call&) { return subject.str(); }

Value filter_center(Interpreter& self, const Value& subject, const Call& call) {
  Call with_width = call;
  if (call.positional.empty() && call.named.empty()) with_width.positional.emplace_back(80);
  return filter_method(self, subject, "center", with_width);
}

/// Words of letters and digits begin with a capital; as Jinja, parted at blanks, hyphens and brackets.
Value filter_title(Interpreter&, const Value& subject, const Call&) {
  std::string out = lower(subject.str());
  bool begins = true;
  for (char& c : out) {
    if (begins && c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    begins = kWhitespace.find(c) != std::string_view::npos || c == '-' || c == '(' || c == '{' || c == '[' || c == '<';
  }
  return out;
}

Value filter_default(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "default", call, "default_value boolean");
  return subject.is_undefined() || (arguments.truth(1, false) && !subject.truth()) ? arguments.get(0, Value(""))
                                                                                   : subject;
}

Value filter_dictsort(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "dictsort", call, "case_sensitive by reverse");
  const std::string by = arguments.text(1, "key");
  if (by != "key" && by != "value") return self.fail("found '" + by + "', expected 'key' or 'value'");
  if (subject.as_dict() == nullptr) return self.fail("found " + subject.repr() + " for dictsort, expected a dict");
  std::vector<Value> pairs;
  for (const auto& [key, value] : subject.as_dict()->entries) pairs.push_back(Value::tuple({key, value}));
  const Value part(by == "key" ? 0 : 1);
  return Value::list(sorted(self, std::move(pairs), &part, arguments.truth(0, false), arguments.truth(2, false)));
}

Value filter_escape(Interpreter&, const Value& subject, const Call&) {
  std::string out;
  for (const char c : subject.str()) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '\'': out += "&#39;"; break;
      case '"': out += "&#34;"; break;
      default: out += c;
    }
  }
  return out;
}

Value filter_first(Interpreter& self, const Value& subject, const Call&) {
  const std::vector<Value> items = self.items(subject);
  return items.empty() ? Value::undefined("No first item, sequence was empty.") : items.front();
}
Value filter_last(Interpreter& self, const Value& subject, const Call&) {
  const std::vector<Value> items = self.items(subject);
  return items.empty() ? Value::undefined("No last item, sequence was empty.") : items.back();
}

/// Without the underscores between digits, as Python reads numbers in strings.
std::string without_underscores(const std::string& text) {
  const auto digit = [&](std::size_t at) {
    return at < text.size() && std::isxdigit(static_cast<unsigned char>(text[at])) != 0;
  };
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] != '_' || i == 0 || !digit(i - 1) || !digit(i + 1)) out += text[i];
  return out;
}

Value filter_float(Interpreter& self, const Value& subject, const Call& call) {
  const Value otherwise = given(self, "float", call, "default").get(0, Value(0.0));
  if (subject.is_number()) return subject.as_float();
  if (!self.require(subject)) return {};
  if (!subject.is_string()) return otherwise;
  const std::string text = without_underscores(trim(subject.as_string(), kWhitespace, true, true));
  double number = 0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, code] = std::from_chars(begin, text.data() + text.size(), number);
  return code == std::errc{} && end == text.data() + text.size() ? Value(number) : otherwise;
}

Value filter_int(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "int", call, "default base");
  const Value otherwise = arguments.get(0, Value(0));
  const auto whole = [&](double number) {
    if (std::isnan(number) || (std::isinf(number) && subject.is_string())) return otherwise;
    return std::abs(number) < 0x1p63 ? Value(static_cast<std::int64_t>(number)) : self.fail("the number is too large");
  };
  if (subject.is_number()) return subject.is_float() ? whole(subject.as_float()) : Value(subject.as_int());
  if (!self.require(subject)) return {};
  if (!subject.is_string()) return otherwise;
  std::string text = without_underscores(trim(subject.as_string(), kWhitespace, true, true));
  auto base = static_cast<int>(arguments.integer(1, 10));
  if (base < 2 || base > 36) return self.fail("found base " + std::to_string(base) + ", expected 2 to 36");
  if (base == 16 && (text.starts_with("0x") || text.starts_with("0X"))) text = text.substr(2);
  if (base == 2 && (text.starts_with("0b") || text.starts_with("0B"))) text = text.substr(2);
  if (base == 8 && (text.starts_with("0o") || text.starts_with("0O"))) text = text.substr(2);
  std::int64_t number = 0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, code] = std::from_chars(begin, text.data() + text.size(), number, base);
  if (code == std::errc{} && end == text.data() + text.size()) return number;
  const Value real = filter_float(self, Value(text), Call{{Value::none()}, {}});
  return real.is_float() ? whole(real.as_float()) : otherwise;
}

Value filter_format(Interpreter& self, const Value& subject, const Call& call) {
  if (!call.named.empty()) {
    Value names = Value::dict();
    for (const auto& [name, value] : call.named) assign(*names.as_dict(), name, value);
    return format_percent(self, subject.str(), names);
  }
  return format_percent(self, subject.str(), Value::tuple(call.positional));
}

Value filter_groupby(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "groupby", call, "attribute default case_sensitive");
  const bool exact = arguments.truth(2, false);
  const auto key_of = [&](const Value& item) {
    const Value key = part_of(self, item, arguments[0]);
    return key.is_undefined() && arguments.has(1) ? *arguments[1] : key;
  };
  std::vector<Value> pairs;
  for (const Value& item : self.items(subject)) pairs.push_back(Value::tuple({key_of(item), item}));
  const Value first(0);
  std::vector<Value> groups;
  for (const Value& pair : sorted(self, std::move(pairs), &first, exact, false)) {
    const Value& key = pair.as_list()->items[0];
    if (groups.empty() || !folded(groups.back().as_list()->items[0], exact).equals(folded(key, exact)))
      groups.push_back(Value::tuple({key, Value::list({})}, {"grouper", "list"}));
    groups.back().as_list()->items[1].as_list()->items.push_back(pair.as_list()->items[1]);
  }
  return Value::list(std::move(groups));
}

Value filter_indent(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "indent", call, "width first blank");
  if (!self.require(subject)) return {};
  if (!subject.is_string()) return self.fail("found " + subject.repr() + " to indent, expected a string");
  std::string space;
  if (arguments.has(0) && arguments[0]->is_string()) {
    space = arguments[0]->as_string();
  } else {
    space = std::string(static_cast<std::size_t>(std::clamp<std::int64_t>(arguments.integer(0, 4), 0, 10000)), ' ');
  }
  const bool blank = arguments.truth(2, false);
  const std::string text = subject.str();
  std::string out;
  bool first = true;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (!first) out += '\n';
    if ((first ? arguments.truth(1, false) : true) && (first || blank || !line.empty())) out += space;
    out += line;
    if (!self.spend(1, line.size() + space.size())) return {};
    first = false;
    at = end + 1;
  }
  return out;
}

Value filter_items(Interpreter& self, const Value& subject, const Call& call) {
  if (subject.is_undefined()) return Value::list({});
  if (subject.as_dict() == nullptr) return self.fail("found " + subject.repr() + " for items, expected a dict");
  return call_method(self, subject, "items", call);
}

Value filter_join(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "join", call, "d attribute");
  const std::string between = arguments.text(0, "");
  std::string out;
  bool first = true;
  for (const Value& item : self.items(subject)) {
    const std::string piece = part_of(self, item, arguments[1]).str();
    if (!first) out += between;
    first = false;
    out += piece;
    if (!self.spend(1, piece.size() + between.size())) return {};
  }
  return out;
}

Value filter_length(Interpreter& self, const Value& subject, const Call&) {
  if (subject.is_string()) return static_cast<std::int64_t>(length_of(subject.as_string()));
  if (subject.is_number() || subject.is_none())
    return self.fail("object of type '" + std::string(subject.type_name()) + "' has no len()");
  return static_cast<std::int64_t>(self.items(subject).size());
}

Value filter_list(Interpreter& self, const Value& subject, const Call&) { return Value::list(self.items(subject)); }

/// map(attribute=..., default=...) or map("filter", arguments...)
Value filter_map(Interpreter& self, const Value& subject, const Call& call) {
  std::vector<Value> out;
  if (!subject.truth()) return Value::list({});
  if (call.positional.empty()) {
    const Arguments arguments = given(self, "map", call, "- attribute default");
    if (!arguments.has(1)) return self.fail("map takes the name of a filter, or attribute=...");
    for (const Value& item : self.items(subject)) {
      Value value = part_of(self, item, arguments[1]);
      out.push_back(value.is_undefined() && arguments.has(2) ? *arguments[2] : std::move(value));
    }
    return Value::list(std::move(out));
  }
  const std::string name = call.positional[0].str();
  if (!is_filter(name)) return self.fail("found '" + name + "', expected a filter" + filter_hint(name));
  const Call rest{{call.positional.begin() + 1, call.positional.end()}, call.named};
  for (const Value& item : self.items(subject)) out.push_back(apply_filter(self, name, item, rest));
  return Value::list(std::move(out));
}

Value select(Interpreter& self, const Value& subject, const Call& call, bool wanted, bool by_attribute) {
  std::vector<Value> out;
  const std::size_t skip = by_attribute ? 1 : 0;
  if (call.positional.size() < skip) return self.fail("selectattr and rejectattr take the name of an attribute");
  const std::string test = call.positional.size() > skip ? call.positional[skip].str() : std::string{};
  if (!test.empty() && !is_test(test)) return self.fail("found '" + test + "', expected a test" + test_hint(test));
  Call rest{{}, call.named};
  if (call.positional.size() > skip + 1)
    rest.positional.assign(call.positional.begin() + static_cast<std::ptrdiff_t>(skip) + 1, call.positional.end());
  if (!subject.truth()) return Value::list({});  // as Jinja, whatever it is
  for (Value& item : self.items(subject)) {
    if (self.failed()) return {};
    const Value value = by_attribute ? part_of(self, item, &call.positional[0]) : item;
    if ((test.empty() ? value.truth() : apply_test(self, test, value, rest)) == wanted) out.push_back(std::move(item));
  }
  return Value::list(std::move(out));
}
Value filter_select(Interpreter& self, const Value& subject, const Call& call) {
  return select(self, subject, call, true, false);
}
Value filter_reject(Interpreter& self, const Value& subject, const Call& call) {
  return select(self, subject, call, false, false);
}
Value filter_selectattr(Interpreter& self, const Value& subject, const Call& call) {
  return select(self, subject, call, true, true);
}
Value filter_rejectattr(Interpreter& self, const Value& subject, const Call& call) {
  return select(self, subject, call, false, true);
}

Value extreme(Interpreter& self, const Value& subject, const Call& call, bool largest) {
  const Arguments arguments = given(self, largest ? "max" : "min", call, "case_sensitive attribute");
  const bool exact = arguments.truth(0, false);
  Value best = Value::undefined("No aggregated item, sequence was empty.");
  Value best_key;
  for (const Value& item : self.items(subject)) {
    if (self.failed()) return {};
    const Value key = folded(part_of(self, item, arguments[1]), exact);
    if (best.is_undefined() || (largest ? self.less(best_key, key) : self.less(key, best_key))) {
      best = item;
      best_key = key;
    }
  }
  return best;
}
Value filter_max(Interpreter& self, const Value& subject, const Call& call) {
  return extreme(self, subject, call, true);
}
Value filter_min(Interpreter& self, const Value& subject, const Call& call) {
  return extreme(self, subject, call, false);
}

Value filter_replace(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "replace", call, "old new count");
  if (!arguments.has(0) || !arguments.has(1)) return self.fail("the filter replace takes what to replace and by what");
  Call plain{{Value(arguments.text(0, "")), Value(arguments.text(1, ""))}, {}};
  if (arguments.has(2) && !arguments[2]->is_none()) plain.positional.push_back(*arguments[2]);
  return filter_method(self, subject, "replace", plain);
}

Value filter_reverse(Interpreter& self, const Value& subject, const Call&) {
  std::vector<Value> items = self.items(subject);
  std::reverse(items.begin(), items.end());
  if (!subject.is_string()) return Value::list(std::move(items));
  std::string out;
  for (const Value& item : items) out += item.as_string();
  return out;
}

Value filter_round(Interpreter& self, const Value& subject, const Call& call) {
  Arguments arguments = given(self, "round", call, "precision method");
  if (!subject.is_number()) return self.fail("found " + subject.repr() + " to round, expected a number");
  const std::int64_t precision = arguments.integer(0, 0);
  const std::string method = arguments.text(1, "common");
  const double scale = std::pow(10.0, static_cast<double>(precision));
  if (method == "ceil") return (std::ceil(subject.as_float() * scale) + 0.0) / scale;  // no negative zero
  if (method == "floor") return (std::floor(subject.as_float() * scale) + 0.0) / scale;
  if (method != "common") return self.fail("found the method '" + method + "', expected common, ceil or floor");
  if (precision < 0) {
    const double rounded = std::nearbyint(subject.as_float() * scale) / scale;
    if (!subject.is_whole()) return rounded;
    return std::abs(rounded) < 0x1p63 ? Value(static_cast<std::int64_t>(rounded))
                                      : self.fail("the number is too large");
  }
  if (subject.is_whole()) return subject.as_int();
  char text[512];
  std::snprintf(text, sizeof text, "%.*f", static_cast<int>(std::min<std::int64_t>(precision, 100)),
                subject.as_float());
  double rounded = 0;
  std::from_chars(text, text + sizeof text, rounded);
  return rounded;
}

Value filter_sort(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "sort", call, "reverse case_sensitive attribute");
  return Value::list(
      sorted(self, self.items(subject), arguments[2], arguments.truth(1, false), arguments.truth(0, false)));
}

Value filter_sum(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "sum", call, "attribute start");
  Value total = arguments.get(1, Value(0));
  for (const Value& item : self.items(subject)) {
    if (self.failed()) return {};
    total = self.binary("+", total, part_of(self, item, arguments[0]));
  }
  return total;
}

void append_json(Interpreter& self, const Value& value, std::string& out, int depth) {
  if (depth > 50) {
    self.fail("found values nested more than 50 deep for tojson");
  } else if (value.is_none()) {
    out += "null";
  } else if (value.is_bool()) {
    out += value.truth() ? "true" : "false";
  } else if (value.is_number()) {
    out += value.repr();
  } else if (value.is_string()) {
    out += '"';
    for (const char c : value.as_string()) {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned char>(c));
      if (c == '"' || c == '\\')
        out += std::string("\\") + c;
      else if (c == '\n')
        out += "\\n";
      else if (c == '\t')
        out += "\\t";
      else if (c == '\r')
        out += "\\r";
      else if (static_cast<unsigned char>(c) < 0x20 || c == '<' || c == '>' || c == '&' || c == '\'')
        out += escaped;
      else
        out += c;
    }
    out += '"';
  } else if (const ListData* list = value.as_list()) {
    out += '[';
    for (std::size_t i = 0; i < list->items.size(); ++i) {
      if (i > 0) out += ", ";
      append_json(self, list->items[i], out, depth + 1);
    }
    out += ']';
  } else if (value.as_dict() != nullptr) {
    out += '{';
    std::vector<Value> keys = sorted(self, self.items(value), nullptr, true, false);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (i > 0) out += ", ";
      append_json(self, Value(keys[i].str()), out, depth + 1);
      out += ": ";
      append_json(self, *find(*value.as_dict(), keys[i]), out, depth + 1);
    }
    out += '}';
  } else {
    self.fail("object of type " + std::string(value.type_name()) + " is not JSON serializable");
  }
}

Value filter_tojson(Interpreter& self, const Value& subject, const Call& call) {
  if (!call.positional.empty() || !call.named.empty())
    return self.fail_unsupported("found tojson with an indent: not supported");
  std::string out;
  append_json(self, subject, out, 0);
  return out;
}

Value filter_trim(Interpreter& self, const Value& subject, const Call& call) {
  return filter_method(self, subject, "strip", call);
}

Value filter_truncate(Interpreter& self, const Value& subject, const Call& call) {
  if (subject.is_undefined()) return subject;
  Arguments arguments = given(self, "truncate", call, "length killwords end leeway");
  const std::int64_t length = arguments.integer(0, 255), leeway = arguments.integer(3, 5);
  const std::string end = arguments.text(2, "...");
  const auto points = code_points(subject.str());
  if (static_cast<std::int64_t>(points.size()) <= length + leeway) return subject.str();
  const std::int64_t kept = length - static_cast<std::int64_t>(length_of(end));
  if (kept < 0)
    return self.fail("found the length " + std::to_string(length) +
                     " to truncate to, expected at least that of the end");
  std::string out;
  for (std::int64_t i = 0; i < kept; ++i) out += points[static_cast<std::size_t>(i)];
  if (!arguments.truth(1, false)) out = out.substr(0, out.rfind(' '));
  return out + end;
}

Value filter_unique(Interpreter& self, const Value& subject, const Call& call) {
  const Arguments arguments = given(self, "unique", call, "case_sensitive attribute");
  std::vector<Value> out, keys;
  for (Value& item : self.items(subject)) {
    const Value key = folded(part_of(self, item, arguments[1]), arguments.truth(0, false));
    if (!self.spend(keys.size() + 1)) return {};
    if (may_change(key))
      return self.fail("found " + key.repr() + " for unique, expected what cannot change: no list or dict");
    if (std::any_of(keys.begin(), keys.end(), [&](const Value& known) { return known.equals(key); })) continue;
    keys.push_back(key);
    out.push_back(std::move(item));
  }
  return Value::list(std::move(out));
}

Value filter_wordcount(Interpreter&, const Value& subject, const Call&) {
  std::int64_t words = 0;
  bool inside = false;
  for (const char c : subject.str()) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                        static_cast<unsigned char>(c) >= 0x80;
    words += letter && !inside;
    inside = letter;
  }
  return words;
}

struct Named {
  std::string_view name;
  Filter filter;
};
constexpr Named kFilters[] = {{"abs", filter_abs},
                              {"attr", filter_attr},
                              {"batch", filter_batch},
                              {"capitalize", filter_capitalize},
                              {"center", filter_center},
                              {"count", filter_length},
                              {"d", filter_default},
                              {"default", filter_default},
                              {"dictsort", filter_dictsort},
                              {"e", filter_escape},
                              {"escape", filter_escape},
                              {"first", filter_first},
                              {"float", filter_float},
                              {"format", filter_format},
                              {"groupby", filter_groupby},
                              {"indent", filter_indent},
                              {"int", filter_int},
                              {"items", filter_items},
                              {"join", filter_join},
                              {"last", filter_last},
                              {"length", filter_length},
                              {"list", filter_list},
                              {"lower", filter_lower},
                              {"map", filter_map},
                              {"max", filter_max},
                              {"min", filter_min},
                              {"reject", filter_reject},
                              {"rejectattr", filter_rejectattr},
                              {"replace", filter_replace},
                              {"reverse", filter_reverse},
                              {"round", filter_round},
                              {"safe", filter_string},
                              {"select", filter_select},
                              {"selectattr", filter_selectattr},
                              {"slice", filter_slice},
                              {"sort", filter_sort},
                              {"string", filter_string},
                              {"sum", filter_sum},
                              {"title", filter_title},
                              {"tojson", filter_tojson},
                              {"trim", filter_trim},
                              {"truncate", filter_truncate},
                              {"unique", filter_unique},
                              {"upper", filter_upper},
                              {"wordcount", filter_wordcount}};

constexpr std::array kNotDone = {"filesizeformat", "forceescape", "pprint",   "random", "striptags",
                                 "urlencode",      "urlize",      "wordwrap", "xmlattr"};

}  // namespace

bool is_filter(std::string_view name) {
  return std::any_of(std::begin(kFilters), std::end(kFilters), [&](const Named& each) { return each.name == name; });
}

bool is_known_filter(std::string_view name) {
  return is_filter(name) || std::find(kNotDone.begin(), kNotDone.end(), name) != kNotDone.end();
}

std::string filter_hint(const std::string& name) {
  std::vector<std::string> names;
  for (const Named& each : kFilters) names.emplace_back(each.name);
  return did_you_mean(name, names, "; ");
}

Value apply_filter(Interpreter& interpreter, std::string_view name, const Value& subject, const Call& call) {
  if (interpreter.failed() || !interpreter.spend(1)) return {};
  for (const Named& each : kFilters)
    if (each.name == name) return each.filter(interpreter, subject, call);
  return interpreter.fail("found '" + std::string(name) + "', expected a filter");
}

}  // namespace cxlab::planner::templates
