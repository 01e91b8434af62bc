#pragma once
// Messages as ROS 2 sends and records them: CDR (XCDR version 1, little-endian), and the text of their types that bags
// carry ("ros2msg").
//
//   std::string bytes;
//   CdrWriter(bytes).message(pose);                       // a value of one message
//   CdrWriter(bytes).number(std::uint32_t{1}).text("a");  // a composed one
//   Expected<Message> again = read_cdr(pose_type, bytes);

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "cx/base/expected.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

/// Makes one value: a header of 4 bytes, then fields, each aligned to its size as counted from the end of the header.
class CdrWriter {
 public:
  /// Empties `out` and begins the value there.
  explicit CdrWriter(std::string& out);

  /// All fields. A message without any is one zero byte, as ROS 2 has it.
  CdrWriter& message(const MessageView& message);
  template <class T>
    requires std::is_arithmetic_v<T>
  CdrWriter& number(T value) {
    return raw(&value, sizeof value, sizeof value);
  }
  /// The length of a sequence, before its elements.
  CdrWriter& size(std::size_t size) { return number(static_cast<std::uint32_t>(size)); }
  CdrWriter& text(std::string_view text);
  /// Bytes of a fixed array of uint8.
  CdrWriter& bytes(std::string_view bytes) { return raw(bytes.data(), bytes.size(), 1); }

 private:
  CdrWriter& raw(const void* data, std::size_t size, std::size_t alignment);
  void wide_text(std::string_view text);

  std::string& out_;
};

/// Reads a value of that type. Errors name the field and the byte. What comes after the last field is left alone.
Expected<Message> read_cdr(const MessageType& type, std::string_view value);

/// How definitions name a type: "geometry_msgs/Pose", "std_srvs/SetBool_Request".
std::string ros2msg_name(std::string_view type);
/// The fields and constants of a type, a line each.
std::string ros2msg_text(const MessageType& type);
/// The text, then that of each type that it needs, in order of first use. `uses`: the types that the text names.
std::string ros2msg_schema(std::string text, std::span<const MessageType* const> uses);
std::string ros2msg_schema(const MessageType& type);

}  // namespace cxlab::bus
