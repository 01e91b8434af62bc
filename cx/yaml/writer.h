#pragma once
// Writes YAML: `fields` of a struct lists its keys for `yaml::Map` and for this alike.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/time.h"

namespace YAML {
class Node;
}

namespace cxlab::yaml {

/// A node as YAML. Scalars that were quoted, which makes them strings, stay so.
std::string to_text(const YAML::Node& node);

/// One mapping. Keys are written in the order of the calls.
class Writer {
 public:
  Writer();

  void operator()(std::string_view key, const std::string& value);
  void operator()(std::string_view key, const char* value) { (*this)(key, std::string(value)); }
  void operator()(std::string_view key, double value);
  void operator()(std::string_view key, int value) { (*this)(key, std::int64_t{value}); }
  void operator()(std::string_view key, std::int64_t value);
  void operator()(std::string_view key, std::uint64_t value);
  void operator()(std::string_view key, bool value);
  void operator()(std::string_view key, SimTime value) { (*this)(key, to_seconds(value)); }
  void operator()(std::string_view key, const std::vector<std::string>& values);
  void operator()(std::string_view key, const std::vector<std::pair<std::string, std::string>>& map);
  template <class Field>
  void operator()(std::string_view key, const std::optional<Field>& value) {
    if (value) (*this)(key, *value);
  }
  /// A struct that lists its keys.
  template <class Struct>
    requires requires(Struct value, Writer keys) { value.fields(keys); }
  void operator()(std::string_view key, const Struct& value) {
    put(key, of(value));
  }
  template <class Struct>
    requires requires(Struct value, Writer keys) { value.fields(keys); }
  void operator()(std::string_view key, const std::vector<Struct>& items) {
    for (const Struct& item : items) append(key, of(item));
  }
  template <class Field>
  void required(std::string_view key, const Field& value) {
    (*this)(key, value);
  }
  void word(std::string_view key, const std::string& value, const std::vector<std::string>&) { (*this)(key, value); }
  template <class Fields>
  void below(std::string_view key, Fields fields) {
    Writer map;
    fields(map);
    put(key, map);
  }

  /// A value that is YAML already; text that is not becomes a scalar.
  void put_yaml(std::string_view key, const std::string& yaml);
  void put(std::string_view key, const Writer& map);
  /// Takes over all keys of another.
  void add(const Writer& other);
  /// Adds an item to the list of that key.
  void append(std::string_view key, const Writer& item);

  /// All keys of a struct.
  template <class Struct>
  static Writer of(Struct value) {
    Writer out;
    value.fields(out);
    return out;
  }
  /// Those whose values are not the defaults.
  template <class Struct>
  static Writer changed(const Struct& value) {
    Writer out = of(value);
    out.remove_equal(of(Struct()));
    return out;
  }

  bool empty() const;
  std::string text() const;

 private:
  void remove_equal(const Writer& other);
  std::shared_ptr<YAML::Node> node_;
};

}  // namespace cxlab::yaml
