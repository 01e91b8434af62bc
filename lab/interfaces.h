#pragma once
// The interface definitions that agents can use, as text for people.

#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/interface.h"

namespace cxlab::lab {

/// Definitions that come with cxlab, and those of these packages (name -> folder).
class Interfaces {
 public:
  static Expected<Interfaces> load(const std::map<std::string, std::string>& packages);

  bus::Registry& registry() { return registry_; }
  /// Full names, for example "std_msgs/msg/String", sorted.
  std::vector<std::string> names() const;
  /// The definition as `ros2 interface show` prints it: with its comments, and below a field of a nested type the
  /// fields of that type, indented. The name may lack "msg". kInput if there is no such interface.
  Expected<std::string> show(const std::string& name);

 private:
  Status append(const std::string& name, const std::string& indent, std::string& out);

  bus::Registry registry_;
  std::map<std::string, std::vector<std::filesystem::path>>
      folders_;  // of a package, those that are asked first in front
};

}  // namespace cxlab::lab
