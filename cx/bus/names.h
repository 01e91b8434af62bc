#pragma once
// Names of topics, services and actions as ROS has them.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::bus {

/// The fault of a name as a participant writes it, for example "has an empty part"; empty if the name is valid.
std::string name_fault(std::string_view written);
/// The same for a namespace, "/" or "/cyan/one".
std::string namespace_fault(std::string_view name_space);
/// The fault of a remap FROM := TO, with what was expected; empty if the remap is valid.
std::string remap_fault(const std::pair<std::string, std::string>& remap);
/// Whether a node can have that namespace and these remaps; the error begins with its key, "namespace" or "remap.FROM".
Status check_node(const std::string& name_space, const std::vector<std::pair<std::string, std::string>>& remaps);

}  // namespace cxlab::bus
