#pragma once
// Interface definitions (.msg, .srv, .action), read at run time and compiled once to memory layouts.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::bus {

/// Primitive types of the ROS 2 interface language, and nested messages.
enum class FieldType : std::uint8_t {
  kBool,
  kByte,
  kChar,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,
  kWstring,
  kMessage
};

/// As definitions write it: "bool", "float64", ...; "message" for nested ones.
std::string_view to_string(FieldType type);

enum class ArrayKind : std::uint8_t { kSingle, kFixed, kBounded, kUnbounded };

class MessageType;
struct Section;

/// One field: where it lies in a message's memory and how to read it there.
struct Field {
  std::string name;
  FieldType type{};
  ArrayKind array = ArrayKind::kSingle;
  std::size_t size_limit = 0;    ///< of a fixed or bounded array
  std::size_t string_limit = 0;  ///< of a bounded string, 0 = none
  const MessageType* nested = nullptr;
  std::size_t offset = 0;    ///< in bytes from the start of the message
  std::size_t stride = 0;    ///< bytes of one element
  std::string default_text;  ///< as written in the definition, empty = zero

  bool is_integer() const { return type < FieldType::kFloat32; }  ///< bool, byte and char too
  bool is_real() const { return type == FieldType::kFloat32 || type == FieldType::kFloat64; }
  bool is_text() const { return type == FieldType::kString || type == FieldType::kWstring; }
  bool is_message() const { return type == FieldType::kMessage; }
  bool is_sequence() const { return array == ArrayKind::kBounded || array == ArrayKind::kUnbounded; }
  /// For example "float64", "string<=5[<=3]", "geometry_msgs/msg/Point[]".
  std::string type_text() const;
};

struct Constant {
  std::string name;
  FieldType type{};
  std::string value_text;  ///< strings without their quotes
};

/// A message's layout. Owned by the registry, lives as long as it.
class MessageType {
 public:
  MessageType() = default;
  MessageType(const MessageType&) = delete;
  MessageType& operator=(const MessageType&) = delete;
  ~MessageType();

  const std::string& name() const { return name_; }  ///< e.g. "geometry_msgs/msg/Twist", "std_srvs/srv/SetBool_Request"
  const std::vector<Field>& fields() const { return fields_; }
  const std::vector<Constant>& constants() const { return constants_; }
  std::size_t byte_size() const { return byte_size_; }
  std::size_t alignment() const { return alignment_; }
  /// The field of that name, or nullptr. Resolve once a call site, then keep the pointer.
  const Field* find(std::string_view field) const;
  std::vector<std::string> field_names() const;
  /// Whether names and types of all fields agree, in order, recursively: then the layouts agree too.
  bool has_fields_of(const MessageType& other) const;

  /// The memory of a message with all defaults, from which new ones are copied.
  const std::byte* prototype() const { return prototype_; }
  /// No strings or dynamic arrays inside: copied byte by byte.
  bool plain() const { return plain_; }
  /// The fewest bytes that `Message::serialize` writes, at least 1.
  std::size_t serialized_min() const { return serialized_min_; }

 private:
  friend class Registry;
  std::string name_;
  std::vector<Field> fields_;
  std::vector<Constant> constants_;
  std::size_t byte_size_ = 0;
  std::size_t alignment_ = 1;
  std::size_t serialized_min_ = 1;
  bool plain_ = true;
  std::byte* prototype_ = nullptr;
};

struct ServiceType {
  std::string name;
  const MessageType* request = nullptr;
  const MessageType* response = nullptr;
};

struct ActionType {
  std::string name;
  const MessageType* goal = nullptr;
  const MessageType* result = nullptr;
  const MessageType* feedback = nullptr;
};

/// Whether the folder of a package has definitions; one of rules or plugins only has none.
bool holds_definitions(const std::filesystem::path& package);

/// Packages of definition files: `<folder>/{msg,srv,action}/*.{msg,srv,action}`. A type is read when first asked for.
class Registry {
 public:
  Registry();
  ~Registry();
  Registry(Registry&&) noexcept;
  Registry& operator=(Registry&&) noexcept;

  /// Makes the package known; a later folder of the same name replaces an earlier one that was not read yet.
  Status add_package(const std::string& package, const std::filesystem::path& folder);
  /// Adds each subfolder that holds definitions, named like the subfolder.
  Status add_packages_in(const std::filesystem::path& folder);
  std::vector<std::string> packages() const;
  /// Names of all definitions of a package, for example "std_msgs/msg/String", sorted.
  std::vector<std::string> interfaces(const std::string& package) const;
  /// Every definition file that was read so far (for the run's copy of its inputs).
  std::vector<std::filesystem::path> files_read() const;

  /// "pkg/msg/T" (or "pkg/T"); also "pkg/srv/T_Request", "pkg/action/T_Goal" and their kin. Errors carry file:line and
  /// the nearest known name.
  Expected<const MessageType*> message(const std::string& name);
  Expected<const ServiceType*> service(const std::string& name);  ///< "pkg/srv/T"
  Expected<const ActionType*> action(const std::string& name);    ///< "pkg/action/T"

  /// One sentence for each thing that a node could not offer (`can_offer` of cx/bus/needed.h), in order.
  const std::vector<std::string>& not_offered() const { return not_offered_; }
  /// Notes it, once.
  void note_not_offered(const std::string& text);

 private:
  struct State;
  Status read(const std::string& package, const std::string& folder, const std::string& name);
  Status compile(MessageType& type, const Section& section, const std::string& package, const std::string& file);
  std::unique_ptr<State> state_;
  std::vector<std::string> not_offered_;
};

}  // namespace cxlab::bus
