#pragma once
// The definitions that a bag carries, compared with those of the workspace.

#include <string>
#include <string_view>

#include "cx/bus/interface.h"

namespace cxlab::bag {

/// The definition of one topic in the encoding ros2msg: the text of the type, then those that it needs, each under a
/// line of "=" and its name. Recorders write the .srv or .action file of events.
class Schema {
 public:
  explicit Schema(std::string_view text) : text_(text) {}

  /// Where the type of the topic itself, "std_msgs/msg/String", differs: "field 1 is 'float32 data' in the bag and
  /// 'float64 data' in the workspace"; empty: nowhere, or the bag has no definition of it.
  std::string difference(const bus::MessageType& type) const;
  /// The same for a part of a service or an action, "std_srvs/srv/SetBool_Request", by whose name it is found.
  std::string difference_of_part(const bus::MessageType& type) const;

 private:
  std::string_view text_;
};

}  // namespace cxlab::bag
