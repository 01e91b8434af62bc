#include "planner/templates/value.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace cxlab::planner::templates {
namespace {

/// Values that hold each other are compared and printed to this depth.
constexpr int kDeepest = 50;

std::string string_repr(const std::string& text) {
  const bool doubled = text.find('\'') != std::string::npos && text.find('"') == std::string::npos;
  const char quote = doubled ? '"' : '\'';
  std::string out(1, quote);
  for (const char c : text) {
    if (c == quote || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\r') {
      out += "\\r";
    } else if (c == '\t') {
      out += "\\t";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      char buffer[8];
      std::snprintf(buffer, sizeof buffer, "\\x%02x", static_cast<unsigned char>(c));
      out += buffer;
    } else {
      out += c;
    }
  }
  return out + quote;
}

int sign(double difference) { return difference < 0 ? -1 : difference > 0 ? 1 : 0; }

}  // namespace

Value* ObjectData::find(std::string_view name) {
  for (auto& [field, value] : fields)
    if (field == name) return &value;
  return nullptr;
}

void ObjectData::set(const std::string& name, Value value) {
  if (Value* known = find(name)) {
    *known = std::move(value);
  } else {
    fields.emplace_back(name, std::move(value));
  }
}

bool may_change(const Value& value) {
  if (value.as_dict() != nullptr) return true;
  const ListData* list = value.as_list();
  if (list == nullptr || !list->shown.empty()) return false;
  return !list->tuple || std::any_of(list->items.begin(), list->items.end(), may_change);
}

Value* find(DictData& dict, const Value& key) {
  for (auto& [known, value] : dict.entries)
    if (known.equals(key)) return &value;
  return nullptr;
}

void assign(DictData& dict, const Value& key, Value value) {
  if (Value* known = find(dict, key)) {
    *known = std::move(value);
  } else {
    dict.entries.emplace_back(key, std::move(value));
  }
}

std::string float_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  char buffer[64];
  const double size = std::abs(value);
  if (size != 0 && (size < 1e-4 || size >= 1e16)) {
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific).ptr;
    return {buffer, end};
  }
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed).ptr;
  std::string text(buffer, end);
  if (text.find('.') == std::string::npos) text += ".0";
  return text;
}

bool Value::truth() const {
  if (is_undefined() || is_none()) return false;
  if (is_float()) return as_float() != 0;
  if (is_whole()) return as_int() != 0;
  if (is_string()) return !as_string().empty();
  if (const ListData* list = as_list()) return !list->items.empty();
  if (const DictData* dict = as_dict()) return !dict->entries.empty();
  return true;
}

const char* Value::type_name() const {
  if (is_undefined()) return "Undefined";
  if (is_none()) return "NoneType";
  if (is_bool()) return "bool";
  if (is_int()) return "int";
  if (is_float()) return "float";
  if (is_string()) return "str";
  if (const ListData* list = as_list()) return list->tuple ? "tuple" : "list";
  if (as_dict() != nullptr) return "dict";
  if (as_object() != nullptr) return as_object()->kind.c_str();
  return "function";
}

std::string Value::str() const {
  if (is_string()) return as_string();
  if (as_object() != nullptr && as_object()->text) return *as_object()->text;
  return repr();
}

std::string Value::repr() const {
  std::string out;
  append_repr(out, 0);
  return out;
}

void Value::append_repr(std::string& out, int depth) const {
  if (depth > kDeepest) {
    out += "...";
  } else if (is_undefined()) {
    if (depth > 0) out += "Undefined";
  } else if (is_none()) {
    out += "None";
  } else if (is_bool()) {
    out += as_int() != 0 ? "True" : "False";
  } else if (is_int()) {
    out += std::to_string(as_int());
  } else if (is_float()) {
    out += float_text(as_float());
  } else if (is_string()) {
    out += string_repr(as_string());
  } else if (as_list() != nullptr && !as_list()->shown.empty()) {
    out += as_list()->shown;
  } else if (const ListData* list = as_list()) {
    out += list->tuple ? '(' : '[';
    for (std::size_t i = 0; i < list->items.size(); ++i) {
      if (i > 0) out += ", ";
      list->items[i].append_repr(out, depth + 1);
    }
    if (list->tuple && list->items.size() == 1) out += ',';
    out += list->tuple ? ')' : ']';
  } else if (const DictData* dict = as_dict()) {
    out += '{';
    for (std::size_t i = 0; i < dict->entries.size(); ++i) {
      if (i > 0) out += ", ";
      dict->entries[i].first.append_repr(out, depth + 1);
      out += ": ";
      dict->entries[i].second.append_repr(out, depth + 1);
    }
    out += '}';
  } else if (const ObjectData* object = as_object()) {
    out += "<" + object->kind + ">";
  } else {
    out += "<function " + as_function()->name + ">";
  }
}

bool Value::equals(const Value& other) const { return equals(other, 0); }

bool Value::equals(const Value& other, int depth) const {
  if (depth > kDeepest) return false;
  if (is_number() && other.is_number()) {
    if (is_float() || other.is_float()) return as_float() == other.as_float();
    return as_int() == other.as_int();
  }
  if (is_string() && other.is_string()) return as_string() == other.as_string();
  if (is_none() || is_undefined()) return data_.index() == other.data_.index();
  if (const ListData *a = as_list(), *b = other.as_list(); a != nullptr && b != nullptr) {
    if (a->tuple != b->tuple || a->items.size() != b->items.size()) return false;
    for (std::size_t i = 0; i < a->items.size(); ++i)
      if (!a->items[i].equals(b->items[i], depth + 1)) return false;
    return true;
  }
  if (DictData* a = as_dict(), *b = other.as_dict(); a != nullptr && b != nullptr) {
    if (a->entries.size() != b->entries.size()) return false;
    for (const auto& [key, value] : a->entries) {
      const Value* match = find(*b, key);
      if (match == nullptr || !value.equals(*match, depth + 1)) return false;
    }
    return true;
  }
  if (as_object() != nullptr) return as_object() == other.as_object();
  if (as_function() != nullptr) return as_function() == other.as_function();
  return false;
}

std::optional<int> Value::order(const Value& other) const {
  if (is_number() && other.is_number()) {
    if (is_float() || other.is_float()) return sign(as_float() - other.as_float());
    return as_int() < other.as_int() ? -1 : as_int() > other.as_int() ? 1 : 0;
  }
  if (is_string() && other.is_string()) {
    const int compared = as_string().compare(other.as_string());
    return compared < 0 ? -1 : compared > 0 ? 1 : 0;
  }
  const ListData *a = as_list(), *b = other.as_list();
  if (a == nullptr || b == nullptr || a->tuple != b->tuple || a == b) return std::nullopt;
  for (std::size_t i = 0; i < std::min(a->items.size(), b->items.size()); ++i) {
    if (a->items[i].equals(b->items[i])) continue;
    return a->items[i].order(b->items[i]);
  }
  return a->items.size() < b->items.size() ? -1 : a->items.size() > b->items.size() ? 1 : 0;
}

std::size_t length_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::vector<std::string> code_points(std::string_view text) {
  std::vector<std::string> points;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xc0) == 0x80 && !points.empty()) {
      points.back() += c;
    } else {
      points.emplace_back(1, c);
    }
  }
  return points;
}

std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string trim(std::string_view text, std::string_view characters, bool left, bool right) {
  if (left) {
    const std::size_t first = text.find_first_not_of(characters);
    text = first == std::string_view::npos ? std::string_view{} : text.substr(first);
  }
  if (right) {
    const std::size_t last = text.find_last_not_of(characters);
    text = last == std::string_view::npos ? std::string_view{} : text.substr(0, last + 1);
  }
  return std::string(text);
}

}  // namespace cxlab::planner::templates
