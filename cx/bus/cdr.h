#pragma once
// Messages as ROS 2 sends and records them: CDR (XCDR version 1; written little-endian, read in either order), and the
// text of their types that bags carry ("ros2msg").
//
//   std::string bytes;
//   CdrWriter(bytes).message(pose);                       // a value of one message
//   CdrWriter(bytes).number(std::uint32_t{1}).text("a");  // a composed one
//   Expected<Message> again = read_cdr(pose_type, bytes);
//   CdrReader(bytes).number(count).text(name);            // a composed one

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

/// Reads one value. After the first error, which `status` keeps, nothing more is read. Errors name the field and the
/// byte. Bytes after the last field are not read.
class CdrReader {
 public:
  /// `value` has the header and outlives this.
  explicit CdrReader(std::string_view value);

  /// All fields.
  CdrReader& message(const MessageView& message);
  template <class T>
    requires std::is_arithmetic_v<T>
  CdrReader& number(T& value) {
    if (const char* const data = take(sizeof value, sizeof value)) copy_numbers(&value, data, 1, sizeof value);
    return *this;
  }
  /// The length of a sequence that has at most so many elements.
  CdrReader& size(std::uint32_t& size, std::uint32_t most);
  CdrReader& text(std::string_view& text);
  /// Bytes of a fixed array of uint8.
  CdrReader& bytes(std::string& bytes, std::size_t size);

  const Status& status() const { return status_; }

 private:
  /// `size` bytes from the next multiple of `alignment` on; nullptr, and an error, where they are not there.
  const char* take(std::size_t size, std::size_t alignment);
  /// Each number of `stride` bytes, in the order of this machine.
  void copy_numbers(void* to, const char* from, std::size_t count, std::size_t stride) const;
  void fail(const std::string& what);
  void read_field(const MessageView& message, const Field& field);
  void read_numbers(const MessageView& message, const Field& field, std::size_t count);
  void read_wide(std::string& text);

  std::string_view fields_;
  bool big_endian_ = false;
  std::size_t at_ = 0;
  std::string field_;  ///< that is being read, for errors
  Status status_;
};

/// Reads a value of that type.
Expected<Message> read_cdr(const MessageType& type, std::string_view value);

/// How definitions name a type: "geometry_msgs/Pose", "std_srvs/SetBool_Request".
std::string ros2msg_name(std::string_view type);
/// The fields and constants of a type, a line each.
std::string ros2msg_text(const MessageType& type);
/// The text, then that of each type that it needs, in order of first use. `uses`: the types that the text names.
std::string ros2msg_schema(std::string text, std::span<const MessageType* const> uses);
std::string ros2msg_schema(const MessageType& type);

}  // namespace cxlab::bus
