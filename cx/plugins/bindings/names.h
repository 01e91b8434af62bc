#pragma once
// Names of the generated bindings of CX: plugin classes, and the prefix of their functions and facts.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/bus/interface.h"

namespace cxlab::cx {

enum class InterfaceKind { kMessage, kService, kAction };

/// One class of bindings.
struct BindingClass {
  InterfaceKind kind{};
  std::string interface;  ///< "std_msgs/msg/String"
  std::string prefix;     ///< "std-msgs-string"
};

/// "std_msgs" -> "StdMsgs".
std::string camel_case(std::string_view package);
/// "StdMsgsUInt16" -> "std-msgs-u-int16".
std::string kebab_case(std::string_view camel);
/// "std_msgs/msg/String" -> "cx::CXStdMsgsStringPlugin".
std::string binding_class_name(std::string_view interface);

/// The interface that a class such as "cx::CXStdMsgsStringPlugin" binds; only looks into packages that fit. Where a
/// package has a message, a service and an action of one name, the first of these.
std::optional<BindingClass> find_binding(std::string_view class_name, const bus::Registry& interfaces);
/// The classes of all interfaces, sorted by package.
std::vector<std::string> binding_classes(const bus::Registry& interfaces);

}  // namespace cxlab::cx
