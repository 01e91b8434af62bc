#pragma once
// YAML read once into typed structs: every value knows its path and line, an unknown key is an error with the nearest
// known one. Errors are collected, so that one reading reports all of them.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"
#include "cx/base/time.h"

namespace YAML {
class Exception;
class Node;
}  // namespace YAML

namespace cxlab::yaml {

class Map;
class Reader;

/// The tree of a YAML text. Throws `YAML::Exception`, also where aliases make the tree endless or give more than a
/// million values: whoever walks through it must come to an end.
YAML::Node load(const std::string& text);

/// The error of a text that yaml-cpp does not read, with the line. It names a tab in the indentation.
Error syntax_error(const YAML::Exception& thrown, const std::string& text, const std::string& file);

/// A struct that lists its keys, for reading and for writing:
///
///   template <class Keys> void fields(Keys& keys) { keys("speed", speed); keys.required("name", name); }
template <class Struct>
concept Keyed = requires(Struct& value, Reader& keys) { value.fields(keys); };

/// One value of a document. A value that is not there is `!value`.
class Value {
 public:
  explicit operator bool() const;
  int line() const;  ///< from 1
  const std::string& path() const { return path_; }
  const std::string& file() const;
  /// The file and line, or the option that gave the value (`Document::set`).
  Origin origin() const;

  bool is_map() const;
  bool is_list() const;
  bool is_scalar() const;
  /// The scalar's text as written, without quotes.
  std::string text() const;
  /// The text in quotes, or what else stands there: "a list".
  std::string found() const;
  /// The value as YAML text, for example for a bus message.
  std::string dump() const;

  // Each reports an error with path and line if the value is not what is asked for, and then returns the default.
  std::string as_string(std::string fallback = {}) const;
  double as_number(double fallback = 0) const;
  std::int64_t as_integer(std::int64_t fallback = 0) const;
  bool as_bool(bool fallback = false) const;
  std::vector<std::string> as_strings() const;  ///< a list of scalars, or one scalar
  std::vector<Value> as_list() const;
  Map as_map() const;

  void fail(std::string what) const;  ///< adds an error at this value

 private:
  friend class Map;
  friend class Document;
  struct Shared;
  std::shared_ptr<Shared> shared_;
  std::shared_ptr<YAML::Node> node_;
  std::string path_;
  bool is_told_ = false;  ///< an error tells that it is missing; it adds no other one
};

/// A mapping that is read key by key. `finish` reports the unused keys, first those that resemble a key that was read,
/// and returns whether there are none. A near miss of a missing required key is reported in that key's error.
class Map {
 public:
  Value get(std::string_view key);      ///< may be missing
  Value require(std::string_view key);  ///< missing: an error
  bool has(std::string_view key);

  // Leave the field alone when the key is missing.
  Map& read(std::string_view key, std::string& field);
  Map& read(std::string_view key, double& field);
  Map& read(std::string_view key, int& field);
  Map& read(std::string_view key, std::int64_t& field);
  Map& read(std::string_view key, std::uint64_t& field);
  Map& read(std::string_view key, bool& field);
  Map& read(std::string_view key, std::vector<std::string>& field);
  Map& read_seconds(std::string_view key, SimTime& field);
  /// One of the words; others are an error that lists them.
  Map& read_word(std::string_view key, std::string& field, const std::vector<std::string>& words);
  /// A map of texts, in order of the document.
  Map& read(std::string_view key, std::vector<std::pair<std::string, std::string>>& field);
  Map& read(std::string_view key, SimTime& field) { return read_seconds(key, field); }
  template <class Field>
  Map& read(std::string_view key, std::optional<Field>& field) {
    if (get(key)) read(key, field.emplace());
    return *this;
  }
  template <Keyed Struct>
  Map& read(std::string_view key, Struct& value);
  /// A list of maps replaces the items. An item's member `origin` is set.
  template <Keyed Item>
  Map& read(std::string_view key, std::vector<Item>& items);
  /// The keys that the struct lists. What its `validate` finds wrong is reported at the key that it names.
  template <Keyed Struct>
  void read(Struct& value);

  std::vector<std::pair<std::string, Value>> entries();  ///< all, in order of the document
  void fail(std::string what) const { value_.fail(std::move(what)); }
  /// An error whose message begins with the path of a value below this map is reported at that value.
  void fail(const Error& error);
  const Value& value() const { return value_; }
  bool finish();

 private:
  friend class Value;
  Value value_;
  std::vector<std::string> asked_;
  std::vector<std::pair<std::string, std::size_t>> missing_;  // required keys, each with its error in the document
};

/// What `fields` of a struct is called with for reading: keys that are missing leave their field alone.
class Reader {
 public:
  explicit Reader(Map& map) : map_(map) {}
  template <class Field>
  void operator()(std::string_view key, Field& field) {
    map_.read(key, field);
  }
  template <class Field>
  void required(std::string_view key, Field& field) {
    if (map_.require(key)) map_.read(key, field);
  }
  void word(std::string_view key, std::string& field, const std::vector<std::string>& words) {
    map_.read_word(key, field, words);
  }
  /// Fields of a map below that key.
  template <class Fields>
  void below(std::string_view key, Fields fields) {
    const Value value = map_.get(key);
    if (!value) return;
    Map map = value.as_map();
    Reader keys(map);
    fields(keys);
    map.finish();
  }

 private:
  Map& map_;
};

template <Keyed Struct>
void Map::read(Struct& value) {
  Reader keys(*this);
  value.fields(keys);
  if constexpr (requires { validate(value); })
    if (const Status s = validate(value); !s) fail(s.error());
}

template <Keyed Struct>
Map& Map::read(std::string_view key, Struct& value) {
  if (const Value there = get(key)) {
    Map map = there.as_map();
    map.read(value);
    map.finish();
  }
  return *this;
}

template <Keyed Item>
Map& Map::read(std::string_view key, std::vector<Item>& items) {
  const Value list = get(key);
  if (!list) return *this;
  items.clear();
  for (const Value& value : list.as_list()) {
    Item& item = items.emplace_back();
    if constexpr (requires { item.origin; }) item.origin = value.origin();
    Map map = value.as_map();
    map.read(item);
    map.finish();
  }
  return *this;
}

/// A file or text.
class Document {
 public:
  static Expected<Document> load(const std::filesystem::path& file);
  static Expected<Document> parse(const std::string& text, const std::string& name);

  /// Sets the value at a path like `a.b[0].c`. Missing maps on the way are made, so that reading reports unknown keys.
  /// Errors in the value name `option` instead of file and line.
  Status set(const std::string& path, const std::string& yaml, const std::string& option);
  /// The same for `PATH=VALUE`; without an option of its own it is `--set PATH=VALUE`. Without '=': kUsage.
  Status set(const std::string& assignment, std::string option = {});
  /// The document's one value. Without one: an empty map.
  Value root() const;
  /// What reading reported, in order; the first one is what a caller returns.
  const std::vector<Error>& errors() const;
  Status status() const;

 private:
  Value root_;
};

}  // namespace cxlab::yaml
