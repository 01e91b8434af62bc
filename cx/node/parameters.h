#pragma once
// Parameters of one ROS node, read from YAML as `--params-file` does: `<node>` or `/**`, `ros__parameters`, then names
// that are nested or written with dots.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"

namespace cxlab::cx {

/// One value. Quoted scalars are strings, as ROS has it.
struct Parameter {
  enum class Type : std::uint8_t { kNone, kBool, kInteger, kDouble, kString, kList };
  Type type = Type::kNone;
  std::string text;              ///< a scalar as written
  std::vector<Parameter> items;  ///< of a list
  std::string file;
  int line = 0;
  bool at_run_time = false;  ///< set by a service or by rules
  bool given = false;        ///< beside the file
  mutable bool asked_for = false;
};
/// "a bool", "an integer", ...
std::string_view to_string(Parameter::Type type);

/// A parameter that is given beside the file.
struct GivenParameter {
  std::string name;   ///< NODE.NAME
  std::string value;  ///< as YAML
  Origin origin{};
};

class Parameters {
 public:
  /// Reads the sections that apply to the node; the more special one wins. A file without any such section is an error.
  static Expected<Parameters> load(const std::filesystem::path& file, const std::string& node,
                                   const std::string& name_space);

  /// The parameter, which is asked for from now on, or nullptr.
  const Parameter* find(std::string_view name) const;
  /// Sets a parameter; `yaml` is its value as YAML.
  Status set(const std::string& name, const std::string& yaml, const Origin& origin);
  void put(const std::string& name, Parameter value) { values_[name] = std::move(value); }
  /// The given parameters that nothing read: the place of each, and the nearest of the other names.
  std::vector<Error> in_vain() const;
  /// All names, sorted.
  std::vector<std::string> names() const;
  /// Names of the parameters (or groups) directly below `group` ("" = all), sorted.
  std::vector<std::string> below(std::string_view group) const;
  /// Where the group begins, for errors: file and the first line of its parameters.
  Error error_at(std::string_view name_or_group, std::string message) const;

  // Each leaves the field alone when the parameter is missing, and fails with file:line when it has another type.
  Status read(std::string_view name, bool& field) const;
  Status read(std::string_view name, std::int64_t& field) const;
  Status read(std::string_view name, double& field) const;  ///< takes integers, too
  Status read(std::string_view name, std::string& field) const;
  Status read(std::string_view name, std::vector<std::string>& field) const;

  /// As a node declares a parameter: reads it, and where it is missing it is there from now on with the field's value.
  template <class T>
  Status declare(const std::string& name, T& field) {
    if (!find(name)) put(name, default_of(field));
    return read(name, field);
  }

 private:
  static Parameter default_of(bool value);
  static Parameter default_of(std::int64_t value);
  static Parameter default_of(double value);
  static Parameter default_of(const std::string& value);
  static Parameter default_of(const std::vector<std::string>& value);

  std::string file_;
  std::map<std::string, Parameter, std::less<>> values_;  // by dotted name
};

}  // namespace cxlab::cx
