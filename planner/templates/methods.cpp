// Methods of strings, lists and dicts, as Python has them.

#include <algorithm>
#include <array>

#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {
namespace {

constexpr std::array kStringMethods = {"upper",    "lower",      "strip",     "lstrip",  "rstrip",       "split",
                                       "rsplit",   "splitlines", "join",      "replace", "startswith",   "endswith",
                                       "find",     "index",      "count",     "format",  "title",        "capitalize",
                                       "isdigit",  "isalpha",    "isalnum",   "isupper", "islower",      "isspace",
                                       "zfill",    "ljust",      "rjust",     "center",  "removeprefix", "removesuffix",
                                       "swapcase", "partition",  "rpartition"};
constexpr std::array kListMethods = {"append",  "extend", "insert", "pop",   "index", "count",
                                     "reverse", "sort",   "remove", "clear", "copy"};
constexpr std::array kTupleMethods = {"index", "count"};
constexpr std::array kDictMethods = {"items", "keys", "values", "get", "update", "pop", "setdefault", "copy", "clear"};

template <class Names>
bool is_one_of(std::string_view name, const Names& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool may_hold(Interpreter& interpreter, const Value& value, const void* container) {
  if (!reaches(value, container)) return true;
  interpreter.fail("a list or dict cannot hold itself");
  return false;
}

std::vector<std::string> split(const std::string& text, const Value* separator, std::int64_t most, bool from_right) {
  std::vector<std::string> parts;
  if (separator == nullptr || separator->is_none()) {
    std::size_t at = 0;
    while ((at = text.find_first_not_of(kWhitespace, at)) != std::string::npos) {
      if (most >= 0 && static_cast<std::int64_t>(parts.size()) == most && !from_right) {
        parts.push_back(trim(text.substr(at), kWhitespace, false, true));
        return parts;
      }
      const std::size_t end = std::min(text.find_first_of(kWhitespace, at), text.size());
      parts.push_back(text.substr(at, end - at));
      at = end;
    }
    return parts;
  }
  const std::string by = separator->str();
  std::string rest = text;
  while (most < 0 || static_cast<std::int64_t>(parts.size()) < most) {
    const std::size_t at = from_right ? rest.rfind(by) : rest.find(by);
    if (at == std::string::npos || by.empty()) break;
    parts.push_back(from_right ? rest.substr(at + by.size()) : rest.substr(0, at));
    rest = from_right ? rest.substr(0, at) : rest.substr(at + by.size());
  }
  parts.push_back(rest);
  if (from_right) std::reverse(parts.begin(), parts.end());
  return parts;
}

Value to_list(std::vector<std::string> parts) {
  std::vector<Value> values;
  for (std::string& part : parts) values.emplace_back(std::move(part));
  return Value::list(std::move(values));
}

Value justified(Interpreter& interpreter, const std::string& text, std::int64_t width, const std::string& fill,
                char where) {
  const auto size = static_cast<std::int64_t>(length_of(text));
  if (width <= size) return text;
  const auto missing = static_cast<std::size_t>(width - size);
  if (!interpreter.spend(1, missing)) return {};
  const std::size_t left = where == 'l'   ? 0
                           : where == 'r' ? missing
                                          : missing / 2 + (missing & static_cast<std::size_t>(width) & 1);
  std::string out;
  for (std::size_t i = 0; i < left; ++i) out += fill;
  out += text;
  for (std::size_t i = left; i < missing; ++i) out += fill;
  return out;
}

bool all_of(const std::string& text, bool (*wanted)(char)) {
  return !text.empty() && std::all_of(text.begin(), text.end(), wanted);
}
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_small(char c) { return c >= 'a' && c <= 'z'; }
bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_letter(char c) { return is_small(c) || is_capital(c) || static_cast<unsigned char>(c) >= 0x80; }

/// First letters of words large, the others small, as str.title does.
std::string title(const std::string& text) {
  std::string out = lower(text);
  bool inside = false;
  for (char& c : out) {
    if (!inside && is_small(c)) c = static_cast<char>(c - 'a' + 'A');
    inside = is_letter(c);
  }
  return out;
}

bool starts_or_ends(const std::string& text, const Value& with, bool starts) {
  const auto one = [&](const Value& each) {
    return starts ? text.starts_with(each.str()) : text.ends_with(each.str());
  };
  if (const ListData* list = with.as_list()) return std::any_of(list->items.begin(), list->items.end(), one);
  return one(with);
}

std::int64_t position(const std::string& text, const std::string& part) {
  const std::size_t at = text.find(part);
  return at == std::string::npos ? -1 : static_cast<std::int64_t>(length_of(std::string_view(text).substr(0, at)));
}

Value replaced(Interpreter& interpreter, const std::string& text, const std::string& from, const std::string& to,
               std::int64_t most) {
  std::string out;
  std::size_t at = 0;
  for (std::int64_t done = 0; most < 0 || done < most; ++done) {
    const std::size_t found =
        from.empty() ? (at < text.size() || done == 0 ? at : std::string::npos) : text.find(from, at);
    if (found == std::string::npos) break;
    out.append(text, at, found - at);
    out += to;
    if (!interpreter.spend(1, to.size())) return {};
    at = found + from.size();
    if (from.empty()) {
      if (at >= text.size()) break;
      out += text[at++];
      if (at == text.size() && (most < 0 || done + 1 < most)) {
        out += to;
        break;
      }
    }
  }
  if (at < text.size()) out.append(text, at, std::string::npos);
  return interpreter.spend(1, out.size()) ? Value(std::move(out)) : Value{};
}

Value string_method(Interpreter& self, const std::string& text, std::string_view name, const Call& call) {
  const auto arguments = [&](std::string_view names) {
    return Arguments(self, "str." + std::string(name), call, names);
  };
  if (name == "upper") return upper(text);
  if (name == "lower") return lower(text);
  if (name == "title") return title(text);
  if (name == "capitalize")
    return text.empty() ? text : upper(code_points(text)[0]) + lower(text.substr(code_points(text)[0].size()));
  if (name == "strip" || name == "lstrip" || name == "rstrip") {
    const Arguments given = arguments("chars");
    const std::string characters = given.has(0) && !given[0]->is_none() ? given[0]->str() : std::string(kWhitespace);
    return trim(text, characters, name != "rstrip", name != "lstrip");
  }
  if (name == "split" || name == "rsplit") {
    Arguments given = arguments("sep maxsplit");
    if (given.has(0) && given[0]->is_string() && given[0]->as_string().empty()) return self.fail("empty separator");
    return to_list(split(text, given[0], given.integer(1, -1), name == "rsplit"));
  }
  if (name == "splitlines") {
    const Value newline("\n");
    std::vector<std::string> lines = split(text, &newline, -1, false);
    if (!lines.empty() && lines.back().empty()) lines.pop_back();
    return to_list(std::move(lines));
  }
  if (name == "join") {
    const Arguments given = arguments("iterable");
    std::string out;
    bool first = true;
    for (const Value& item : self.items(given.get(0, Value::list({})))) {
      if (!item.is_string()) return self.fail("found " + item.repr() + " to join, expected a string");
      if (!first) out += text;
      first = false;
      out += item.as_string();
      if (!self.spend(1, item.as_string().size() + text.size())) return {};
    }
    return out;
  }
  if (name == "replace") {
    Arguments given = arguments("old new count");
    return replaced(self, text, given.text(0, ""), given.text(1, ""), given.integer(2, -1));
  }
  if (name == "startswith" || name == "endswith")
    return starts_or_ends(text, arguments("prefix").get(0, Value("")), name == "startswith");
  if (name == "find" || name == "index") {
    const std::int64_t at = position(text, arguments("sub").text(0, ""));
    return at < 0 && name == "index" ? self.fail("substring not found") : Value(at);
  }
  if (name == "count") {
    const std::string part = arguments("sub").text(0, "");
    if (part.empty()) return static_cast<std::int64_t>(length_of(text) + 1);
    std::int64_t found = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++found;
    return found;
  }
  if (name == "format") return format_braces(self, text, call);
  if (name == "isdigit") return all_of(text, is_digit);
  if (name == "isalpha") return all_of(text, is_letter);
  if (name == "isalnum") return all_of(text, [](char c) { return is_letter(c) || is_digit(c); });
  if (name == "isspace") return all_of(text, [](char c) { return kWhitespace.find(c) != std::string_view::npos; });
  if (name == "isupper")
    return std::any_of(text.begin(), text.end(), is_capital) && std::none_of(text.begin(), text.end(), is_small);
  if (name == "islower")
    return std::any_of(text.begin(), text.end(), is_small) && std::none_of(text.begin(), text.end(), is_capital);
  if (name == "zfill") {
    const std::int64_t width = arguments("width").integer(0, 0);
    const bool sign = text.starts_with('-') || text.starts_with('+');
    const Value filled = justified(self, text.substr(sign ? 1 : 0), width - (sign ? 1 : 0), "0", 'r');
    return sign ? Value(text.substr(0, 1) + filled.str()) : filled;
  }
  if (name == "ljust" || name == "rjust" || name == "center") {
    Arguments given = arguments("width fillchar");
    return justified(self, text, given.integer(0, 0), given.text(1, " "), name[0]);
  }
  if (name == "swapcase") {
    std::string out;
    for (const std::string& character : code_points(text))
      out += is_capital(character[0]) ? lower(character) : upper(character);
    return out;
  }
  if (name == "partition" || name == "rpartition") {
    const std::string by = arguments("sep").text(0, "");
    if (by.empty()) return self.fail("empty separator");
    const std::size_t at = name == "partition" ? text.find(by) : text.rfind(by);
    if (at != std::string::npos) return Value::tuple({text.substr(0, at), by, text.substr(at + by.size())});
    return name == "partition" ? Value::tuple({text, "", ""}) : Value::tuple({"", "", text});
  }
  const std::string affix = arguments("affix").text(0, "");
  if (name == "removeprefix") return text.starts_with(affix) ? text.substr(affix.size()) : text;
  return text.ends_with(affix) ? text.substr(0, text.size() - affix.size()) : text;
}

Value list_method(Interpreter& self, ListData& list, std::string_view name, const Call& call) {
  Arguments given(self, "list." + std::string(name), call,
                  name == "insert" ? "index item"
                  : name == "sort" ? "key reverse"
                                   : "item");
  const auto size = static_cast<std::int64_t>(list.items.size());
  const auto wanted = std::find_if(list.items.begin(), list.items.end(),
                                   [&](const Value& item) { return given.has(0) && item.equals(*given[0]); });
  if (self.failed() || !self.spend(list.items.size())) return {};
  if (name == "append" || name == "insert") {
    const Value item = given.get(name == "append" ? 0 : 1, Value{});
    if (!may_hold(self, item, &list)) return {};
    std::int64_t at = name == "append" ? size : given.integer(0, 0);
    if (at < 0) at += size;
    list.items.insert(list.items.begin() + std::clamp<std::int64_t>(at, 0, size), item);
  } else if (name == "extend") {
    for (Value& item : self.items(given.get(0, Value{}))) {
      if (!may_hold(self, item, &list)) return {};
      list.items.push_back(std::move(item));
    }
  } else if (name == "pop") {
    std::int64_t at = given.integer(0, -1);
    if (at < 0) at += size;
    if (at < 0 || at >= size) return self.fail("pop index out of range");
    Value item = list.items[static_cast<std::size_t>(at)];
    list.items.erase(list.items.begin() + at);
    return item;
  } else if (name == "index") {
    return wanted == list.items.end() ? self.fail("the item is not in the list")
                                      : Value(static_cast<std::int64_t>(wanted - list.items.begin()));
  } else if (name == "count") {
    return static_cast<std::int64_t>(std::count_if(list.items.begin(), list.items.end(), [&](const Value& item) {
      return given.has(0) && item.equals(*given[0]);
    }));
  } else if (name == "reverse") {
    std::reverse(list.items.begin(), list.items.end());
  } else if (name == "sort") {
    if (given.has(0)) return self.fail_unsupported("found list.sort with a key: not supported, use the filter sort");
    std::vector<Value> sorted = list.items;
    std::stable_sort(sorted.begin(), sorted.end(), [&](const Value& a, const Value& b) {
      return given.truth(1, false) ? self.less(b, a) : self.less(a, b);
    });
    list.items = std::move(sorted);
  } else if (name == "remove") {
    if (wanted == list.items.end()) return self.fail("the item is not in the list");
    list.items.erase(wanted);
  } else if (name == "clear") {
    list.items.clear();
  } else {
    return Value::list(list.items);
  }
  return Value::none();
}

Value dict_method(Interpreter& self, DictData& dict, std::string_view name, const Call& call) {
  std::vector<Value> out;
  if (name == "items" || name == "keys" || name == "values") {
    for (const auto& [key, value] : dict.entries)
      out.push_back(name == "items" ? Value::tuple({key, value}) : name == "keys" ? key : value);
    return self.spend(out.size()) ? Value::list(std::move(out)) : Value{};
  }
  if (name == "copy" || name == "clear") {
    Value copy = Value::dict();
    if (name == "copy") copy.as_dict()->entries = dict.entries;
    if (name == "clear") dict.entries.clear();
    return name == "copy" ? copy : Value::none();
  }
  if (name == "update") {
    DictData more;
    for (const Value& from : call.positional) {
      if (const DictData* other = from.as_dict()) {
        more.entries.insert(more.entries.end(), other->entries.begin(), other->entries.end());
        continue;
      }
      for (const Value& pair : self.items(from)) {
        std::vector<Value> two = self.items(pair);
        if (self.failed() || two.size() != 2 || may_change(two[0]))
          return self.fail("found " + pair.repr() + " for a dict, expected a key and its value");
        more.entries.emplace_back(std::move(two[0]), std::move(two[1]));
      }
    }
    if (self.failed()) return {};
    for (const auto& [key, value] : call.named) more.entries.emplace_back(key, value);
    for (const auto& [key, value] : more.entries) {
      if (!may_hold(self, value, &dict)) return {};
      assign(dict, key, value);
    }
    return Value::none();
  }
  const Arguments given(self, "dict." + std::string(name), call, "key default");
  if (self.failed() || !given.has(0)) return self.fail("found no key for dict." + std::string(name));
  const Value* known = find(dict, *given[0]);
  if (name == "get") return known != nullptr ? *known : given.get(1, Value::none());
  if (name == "setdefault") {
    if (known != nullptr) return *known;
    if (!may_hold(self, given.get(1, Value::none()), &dict)) return {};
    assign(dict, *given[0], given.get(1, Value::none()));
    return given.get(1, Value::none());
  }
  if (known == nullptr)
    return given.has(1) ? *given[1] : self.fail("found no key " + given[0]->repr() + " in the dict");
  Value popped = *known;
  std::erase_if(dict.entries, [&](const auto& entry) { return entry.first.equals(*given[0]); });
  return popped;
}

Value make_range(Interpreter& self, const Call& call) {
  Arguments given(self, "range", call, "start stop step");
  const bool one = !given.has(1);
  const std::int64_t first = one ? 0 : given.integer(0, 0), last = one ? given.integer(0, 0) : given.integer(1, 0),
                     step = given.integer(2, 1);
  if (step == 0) return self.fail("range step cannot be zero");
  constexpr std::int64_t kMost = 100000;  // as the sandbox of Jinja
  std::vector<Value> numbers;
  for (std::int64_t i = first; step > 0 ? i < last : i > last;) {
    numbers.emplace_back(i);
    if (static_cast<std::int64_t>(numbers.size()) > kMost)
      return self.fail("range is longer than " + std::to_string(kMost));
    if (__builtin_add_overflow(i, step, &i)) break;
  }
  if (!self.spend(numbers.size())) return {};
  Value range = Value::tuple(std::move(numbers));  // which nobody can change
  range.as_list()->shown = "range(" + std::to_string(first) + ", " + std::to_string(last) +
                           (step == 1 ? "" : ", " + std::to_string(step)) + ")";
  return range;
}

Value make_dict(Interpreter& self, const Call& call) {
  Value dict = Value::dict();
  dict_method(self, *dict.as_dict(), "update", call);
  return dict;
}

Value make_namespace(Interpreter& self, const Call& call) {
  const Value fields = make_dict(self, call);
  Value space = Value::object("Namespace");
  for (const auto& [key, value] : fields.as_dict()->entries) space.as_object()->set(key.str(), value);
  return space;
}

Value make_cycler(Interpreter& self, const Call& call) {
  if (call.positional.empty()) return self.fail("cycler takes at least one argument");
  Value cycler = Value::object("Cycler");
  auto at = std::make_shared<std::size_t>(0);
  const std::vector<Value> values = call.positional;
  const auto turn_to = [at, values, weak = cycler.weak_object()](std::size_t next) {
    *at = next % values.size();
    if (const auto object = weak.lock()) object->set("current", values[*at]);
  };
  turn_to(0);
  cycler.as_object()->set("next", Value::function("next", [at, values, turn_to](Interpreter&, const Call&) {
                            const Value now = values[*at];
                            turn_to(*at + 1);
                            return now;
                          }));
  cycler.as_object()->set("reset", Value::function("reset", [turn_to](Interpreter&, const Call&) {
                            turn_to(0);
                            return Value::none();
                          }));
  return cycler;
}

Value make_joiner(Interpreter& self, const Call& call) {
  const std::string separator = Arguments(self, "joiner", call, "sep").text(0, ", ");
  auto used = std::make_shared<bool>(false);
  return Value::function("joiner", [used, separator](Interpreter&, const Call&) {
    const bool first = !*used;
    *used = true;
    return Value(first ? std::string{} : separator);
  });
}

}  // namespace

bool reaches(const Value& value, const void* container, int depth) {
  const ListData* list = value.as_list();
  const DictData* dict = value.as_dict();
  const ObjectData* object = value.as_object();
  if (list == nullptr && dict == nullptr && object == nullptr) return false;
  if (depth > 100 || list == container || dict == container || object == container) return true;
  if (list != nullptr)
    return std::any_of(list->items.begin(), list->items.end(),
                       [&](const Value& item) { return reaches(item, container, depth + 1); });
  if (dict != nullptr)
    return std::any_of(dict->entries.begin(), dict->entries.end(),
                       [&](const auto& entry) { return reaches(entry.second, container, depth + 1); });
  return std::any_of(object->fields.begin(), object->fields.end(),
                     [&](const auto& field) { return reaches(field.second, container, depth + 1); });
}

bool has_method(const Value& subject, std::string_view name) {
  if (subject.is_string()) return is_one_of(name, kStringMethods);
  if (const ListData* list = subject.as_list())
    return list->tuple ? is_one_of(name, kTupleMethods) : is_one_of(name, kListMethods);
  return subject.as_dict() != nullptr && is_one_of(name, kDictMethods);
}

Value call_method(Interpreter& interpreter, const Value& subject, std::string_view name, const Call& call) {
  if (interpreter.failed()) return {};
  if (subject.is_string()) return string_method(interpreter, subject.as_string(), name, call);
  if (subject.as_list() != nullptr) return list_method(interpreter, *subject.as_list(), name, call);
  return dict_method(interpreter, *subject.as_dict(), name, call);
}

std::vector<std::pair<std::string, Value>> global_functions() {
  return {{"range", Value::function("range", make_range)},
          {"dict", Value::function("dict", make_dict)},
          {"namespace", Value::function("namespace", make_namespace)},
          {"cycler", Value::function("cycler", make_cycler)},
          {"joiner", Value::function("joiner", make_joiner)}};
}

}  // namespace cxlab::planner::templates
