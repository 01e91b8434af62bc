#pragma once
// Fields of messages as values of CLIPS, and back.

#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "cx/engine/function.h"
#include "cx/plugins/ros_msgs/message_store.h"

namespace cxlab::cx {

/// Why a field was not given or set. What follows from it (the line of the log, whether the rule goes on) differs
/// between the generic plugin and the bindings.
struct FieldFault {
  enum class Kind {
    kNoMessage,       ///< the handle is unknown
    kNoField,         ///< the type has no such field
    kNotMultifield,   ///< an array was set from a single value
    kUnknownMessage,  ///< a message field was set from an unknown handle
    kValue,           ///< the value does not fit
  };
  Kind kind{};
  std::string text;  ///< what was found, what was expected
};

/// The functions get-field and set-field of one plugin. Field names are looked up once a call site.
class Fields {
 public:
  /// `warn` takes the warning about a message of another type, once for each field and type; `strict`: a fault.
  Fields(MessageStore& store, bool strict, std::function<void(const std::string&)> warn)
      : store_(store), strict_(strict), warn_(std::move(warn)) {}

  /// Gives the field as the result of the call. A boolean is TRUE or FALSE, a whole number an INTEGER, any other number
  /// a FLOAT, and a char a STRING of one character. A nested message is a handle into its parent, an array a
  /// multifield. `expected`: the type that the message must have, null for any.
  std::optional<FieldFault> give(Call& call, Handle message, const ValueRef& field,
                                 const bus::MessageType* expected = nullptr);

  /// Sets the field from a value. INTEGER and FLOAT are converted where that is exact; a value that does not fit is a
  /// fault. Messages are copied in, also one of another type with the same fields, as CX takes it. Arrays take a
  /// multifield, those of fixed size one of exactly that size.
  std::optional<FieldFault> set(Handle message, const ValueRef& field, const ValueRef& value,
                                const bus::MessageType* expected = nullptr);

 private:
  using Fault = std::optional<FieldFault>;
  const bus::Field* find(const bus::MessageType& type, const ValueRef& name);
  Fault set_value(const bus::MessageView& view, const bus::Field& field, const ValueRef& value, std::size_t index);
  Fault set_array(const bus::MessageView& view, const bus::Field& field, const ValueRef& values);
  Fault set_messages(const bus::MessageView& view, const bus::Field& field, const ValueRef& values);
  /// The message behind a handle as one of the field's type; empty with a fault.
  bus::MessageView source(const bus::Field& field, const ValueRef& value, Fault& fault);

  /// The last meaning of a name. CLIPS has one atom for a name: the same one at each call of a site.
  struct Known {
    const void* atom = nullptr;
    const bus::MessageType* type = nullptr;
    const bus::Field* field = nullptr;
  };
  MessageStore& store_;
  bool strict_;
  std::function<void(const std::string&)> warn_;
  std::set<std::pair<std::string, std::string>> warned_;  ///< types that a field's type was given
  std::array<Known, 64> known_{};
};

}  // namespace cxlab::cx
