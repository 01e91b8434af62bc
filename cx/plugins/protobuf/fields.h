#pragma once
// Messages of protobuf as rules see them: by handle, and their fields as values of CLIPS.

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "cx/engine/engine.h"
#include "cx/protobuf/types.h"

namespace cxlab::cx {

/// The messages that the rules of one environment hold. Each was created, received, or copied out of another, and
/// stays until the rules destroy it.
class ProtobufMessages {
 public:
  explicit ProtobufMessages(RuleEngine& engine) : engine_(engine) {}

  Handle add(pb::MessagePtr message);
  /// Null if unknown.
  google::protobuf::Message* find(Handle handle) const;
  void destroy(Handle handle) { messages_.erase(handle); }
  const std::map<Handle, pb::MessagePtr>& all() const { return messages_; }

 private:
  RuleEngine& engine_;
  std::map<Handle, pb::MessagePtr> messages_;
};

/// DOUBLE, INT32, MESSAGE, ...; UNKNOWN for groups.
const char* type_word(const google::protobuf::FieldDescriptor& field);
/// OPTIONAL, REQUIRED, REPEATED.
const char* label_word(const google::protobuf::FieldDescriptor& field);

/// The value of a field that is no list, or an element of one. A message is copied: the rules destroy the copy.
Value field_value(const google::protobuf::Message& message, const google::protobuf::FieldDescriptor& field,
                  ProtobufMessages& messages, std::optional<int> index = {});

/// Why a field cannot have a value.
struct FieldProblem {
  std::string text;
  bool only_warn = false;  ///< CX warns and leaves the field as it is
};
/// Sets a field that is no list, or appends to a list. Numbers are converted where nothing is lost; not with `strict`.
std::optional<FieldProblem> set_field(google::protobuf::Message& message,
                                      const google::protobuf::FieldDescriptor& field, const ValueRef& value,
                                      const ProtobufMessages& messages, bool strict);

}  // namespace cxlab::cx
