#pragma once
// Structs with one list of their fields, `template <class Keys> void fields(Keys& keys)`, to JSON and back. In the list
//
//   keys.required("name", name);     is always written, and missing it is an error;
//   keys("name", name);              is always written; without it the field keeps its value;
//   keys.unless_empty("name", name); is written if it has something, and read like the last;
//   keys.time("name", name);         is required, in s: a number or, if it is optional, null.
//
// A field is what JSON has, an enumeration with its words (`named`), another such struct, or a list of these.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>
#include "cx/base/json.h"

#include "cx/base/expected.h"
#include "cx/base/named_value.h"

namespace cxlab::lab {

/// The object in a text, which is that of `file`.
Expected<Json> parse_object(const std::string& text, const std::filesystem::path& file);
/// The object in a file.
Expected<Json> read_json(const std::filesystem::path& file);

/// What the library says, without its code.
std::string without_code(const Json::exception& e);

/// Throws where no run is so long; `time` in s.
void check_time(const char* name, double time, const Json& in);

Json::other_error unknown_word(const char* name, const Json& found, const std::vector<std::string>& words);

/// Writes each field under its name, in order.
class JsonWriter {
 public:
  template <class T>
  static Json json(T& value) {
    Json out;
    if constexpr (requires(JsonWriter keys) { value.fields(keys); }) {
      JsonWriter keys(out = Json::object());
      value.fields(keys);
    } else {
      out = value;
    }
    return out;
  }
  template <class T>
  static Json json(std::vector<T>& values) {
    auto out = Json::array();
    for (T& value : values) out.push_back(json(value));
    return out;
  }
  template <class Enum>
  static Json json(NamedValue<Enum>& named) {
    return named.word();
  }

  template <class T>
  void required(const char* name, T&& value) {
    out_[name] = json(value);
  }
  template <class T>
  void operator()(const char* name, T&& value) {
    required(name, value);
  }
  template <class T>
  void unless_empty(const char* name, T& value) {
    if (!value.empty()) required(name, value);
  }
  void time(const char* name, double& time) { required(name, time); }
  void time(const char* name, std::optional<double>& time) { out_[name] = time ? Json(*time) : Json(nullptr); }

 private:
  explicit JsonWriter(Json& out) : out_(out) {}

  Json& out_;
};

/// Reads each field from its name. Throws Json::exception.
class JsonReader {
 public:
  explicit JsonReader(const Json& in) : in_(in) {}

  template <class T>
  void required(const char* name, T&& value) {
    read(name, in_.at(name), value);
  }
  template <class T>
  void operator()(const char* name, T&& value) {
    if (const auto found = in_.find(name); found != in_.end()) read(name, *found, value);
  }
  template <class T>
  void unless_empty(const char* name, T& value) {
    (*this)(name, value);
  }
  void time(const char* name, double& time) {
    required(name, time);
    check_time(name, time, in_);
  }
  void time(const char* name, std::optional<double>& time) {
    time.reset();
    if (!in_.at(name).is_null()) this->time(name, time.emplace());
  }

 private:
  template <class T>
  static void read(const char*, const Json& in, T& value) {
    if constexpr (requires(JsonReader keys) { value.fields(keys); }) {
      JsonReader keys(in);
      value.fields(keys);
    } else {
      value = in.get<T>();
    }
  }
  template <class T>
  static void read(const char* name, const Json& in, std::vector<T>& values) {
    values.clear();
    for (const Json& item : in.get<std::vector<Json>>()) read(name, item, values.emplace_back());
  }
  template <class Enum>
  static void read(const char* name, const Json& in, NamedValue<Enum>& named) {
    if (!named.set(in.get<std::string>())) throw unknown_word(name, in, {named.begin, named.end});
  }

  const Json& in_;
};

/// The error is what is missing, or has another type.
template <class T>
Status read_fields(const Json& in, T& value) {
  try {
    JsonReader keys(in);
    value.fields(keys);
    return {};
  } catch (const Json::exception& e) {
    return input_error(without_code(e));
  }
}

}  // namespace cxlab::lab
