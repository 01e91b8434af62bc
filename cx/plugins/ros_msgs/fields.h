#pragma once
// Fields of messages as values of CLIPS, and back.

#include <array>
#include <optional>
#include <string>
#include <string_view>

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
  explicit Fields(MessageStore& store) : store_(store) {}

  /// Gives the field as the result of the call: booleans are TRUE and FALSE, whole numbers INTEGER, others FLOAT, a
  /// char is a STRING of one character, a nested message a handle into its parent, an array a multifield. `expected`:
  /// the type that the message must have, null for any.
  std::optional<FieldFault> give(Call& call, Handle message, const ValueRef& field,
                                 const bus::MessageType* expected = nullptr);

  /// Sets the field from a value. INTEGER and FLOAT are converted where that is exact; a value that does not fit is a
  /// fault. Messages are copied in. Arrays take a multifield, those of fixed size one of exactly that size.
  std::optional<FieldFault> set(Handle message, const ValueRef& field, const ValueRef& value,
                                const bus::MessageType* expected = nullptr);

 private:
  const bus::Field* find(const bus::MessageType& type, const ValueRef& name);

  /// The last meaning of a name. CLIPS has one atom for a name: the same one at each call of a site.
  struct Known {
    const void* atom = nullptr;
    const bus::MessageType* type = nullptr;
    const bus::Field* field = nullptr;
  };
  MessageStore& store_;
  std::array<Known, 64> known_{};
};

}  // namespace cxlab::cx
