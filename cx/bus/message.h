#pragma once
// Messages: one block of memory a message, laid out by its MessageType. No tree of variants.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/interface.h"

namespace cxlab::bus {

/// Elements of an array field that is not fixed: contiguous, of the field's element type.
struct Sequence {
  std::byte* data = nullptr;
  std::size_t size = 0;
  std::size_t capacity = 0;
};

/// A view of a message (or of a nested one inside its parent); does not own. Typed access does not check the type in
/// release builds: callers check `Field::type` once when they resolve the field.
class MessageView {
 public:
  MessageView() = default;
  MessageView(const MessageType* type, std::byte* memory) : type_(type), memory_(memory) {}

  const MessageType& type() const { return *type_; }
  std::byte* memory() const { return memory_; }
  explicit operator bool() const { return memory_ != nullptr; }

  /// Integers of any width, bool, byte, char as int64 (uint64 wraps).
  std::int64_t integer(const Field& field, std::size_t index = 0) const;
  /// float32, float64; integers are converted.
  double real(const Field& field, std::size_t index = 0) const;
  const std::string& text(const Field& field, std::size_t index = 0) const;
  MessageView nested(const Field& field, std::size_t index = 0) const;
  /// Number of elements: 1 for a single field.
  std::size_t size(const Field& field) const;

  /// Fails if the value does not fit the field's range.
  Status set_integer(const Field& field, std::int64_t value, std::size_t index = 0) const;
  void set_real(const Field& field, double value, std::size_t index = 0) const;
  Status set_text(const Field& field, std::string_view value, std::size_t index = 0) const;
  /// Resizes a dynamic array; new elements are default-initialised. Fails beyond the bound or on a fixed array.
  Status resize(const Field& field, std::size_t size) const;

  // Access by name, for code that is not on a hot path. The name must exist (asserts).
  std::int64_t integer(std::string_view field) const;
  double real(std::string_view field) const;
  const std::string& text(std::string_view field) const;
  MessageView nested(std::string_view field, std::size_t index = 0) const;
  std::size_t size(std::string_view field) const;
  const MessageView& set(std::string_view field, std::int64_t value) const;
  const MessageView& set(std::string_view field, int value) const {
    return set(field, static_cast<std::int64_t>(value));
  }
  const MessageView& set(std::string_view field, bool value) const {
    return set(field, static_cast<std::int64_t>(value));
  }
  const MessageView& set(std::string_view field, double value) const;
  const MessageView& set(std::string_view field, std::string_view value) const;
  const MessageView& set(std::string_view field, const char* value) const {
    return set(field, std::string_view(value));
  }
  /// Appends one default element to a dynamic array of messages and returns it (valid until the next append or resize).
  MessageView append(std::string_view field) const;
  /// Appends one element to a dynamic array of strings.
  const MessageView& append_text(std::string_view field, std::string_view value) const;

  void copy_from(const MessageView& other) const;  ///< same type
  bool equals(const MessageView& other) const;
  /// One value of the record: a map of all fields, in order of definition.
  void record(RecordData& data) const;
  /// YAML flow style on one line, for logs: `{x: 1.0, name: "a"}`.
  std::string to_string() const;

 private:
  const MessageType* type_ = nullptr;
  std::byte* memory_ = nullptr;
};

/// Owns one message.
class Message {
 public:
  Message() = default;
  explicit Message(const MessageType& type);   ///< default-initialised
  explicit Message(const MessageView& other);  ///< a deep copy
  Message(const Message& other) : Message(other.view()) {}
  Message(Message&& other) noexcept;
  Message& operator=(Message other) noexcept;
  ~Message();

  MessageView view() const { return MessageView(type_, memory_.get()); }
  operator MessageView() const { return view(); }
  const MessageView* operator->() const { return &(view_ = view()); }
  explicit operator bool() const { return memory_ != nullptr; }

  /// Compact bytes that `deserialize` reads back (input log); not CDR.
  void serialize(std::string& out) const;
  static Expected<Message> deserialize(const MessageType& type, std::span<const std::byte> bytes,
                                       std::size_t& position);

  /// Reads a YAML or JSON text (a map of fields, missing ones keep their default) as `ros2 topic pub` takes it.
  static Expected<Message> from_yaml(const MessageType& type, const std::string& text);

 private:
  struct FreeMemory {
    void operator()(std::byte* memory) const;
  };
  const MessageType* type_ = nullptr;
  std::unique_ptr<std::byte, FreeMemory> memory_;
  mutable MessageView view_;
};

/// What lies in an inbox: shared between receivers, never changed after posting.
using SharedMessage = std::shared_ptr<const Message>;

}  // namespace cxlab::bus
