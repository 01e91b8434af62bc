#pragma once
// The interface language of ROS 2: the text of one .msg, .srv or .action file to its sections.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/interface.h"

namespace cxlab::bus {

struct FieldSpec {
  Field field;              ///< without offset and nested type
  std::string nested_name;  ///< as written: "Pose", "geometry_msgs/Pose" or "geometry_msgs/msg/Pose"
  int line = 0;
};

/// A message, a request, a goal, ...
struct Section {
  std::vector<FieldSpec> fields;
  std::vector<Constant> constants;
};

/// `sections`: 1 of a .msg, 2 of a .srv, 3 of an .action, divided by lines of "---". Default values are read later,
/// with the layout.
Expected<std::vector<Section>> parse_definition(std::string_view text, const std::string& file, std::size_t sections);

}  // namespace cxlab::bus
