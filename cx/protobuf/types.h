#pragma once
// Types of messages, read from .proto files at run time, and messages of them without generated code.
//
//   pb::Types types([](const std::string& file) { return read_file("proto/" + file); });
//   if (Status s = types.add_file("BeaconSignal.proto"); !s) ...       // file:line: what is wrong
//   auto message = types.make("llsf_msgs.BeaconSignal");

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/protobuf/wire.h"

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace cxlab::pb {

using MessagePtr = std::unique_ptr<google::protobuf::Message>;

class Types {
 public:
  /// A .proto file's text and where it lies, for errors.
  struct Source {
    std::string text, path;
  };
  /// Finds what `import` names; an error, or nothing where there is no such file.
  using Open = std::function<Expected<std::optional<Source>>(const std::string& file)>;

  explicit Types(Open open);
  ~Types();
  Types(const Types&) = delete;
  Types& operator=(const Types&) = delete;

  /// Reads a file with all that it imports. Messages that carry `enum CompType { COMP_ID = ..; MSG_TYPE = ..; }` are
  /// known by these numbers from now on; of two with the same numbers the first.
  Status add_file(const std::string& file);

  /// By full name; null if there is none.
  const google::protobuf::Descriptor* find(std::string_view full_name) const;
  /// Null if there is none, or it was not registered.
  const google::protobuf::Descriptor* find(MessageKey key) const;
  /// Its numbers; none if it does not carry them.
  static std::optional<MessageKey> key_of(const google::protobuf::Descriptor& type);
  /// Makes the type known by its numbers. Fails if there is no such type, it has no numbers, or others have them.
  Status register_type(std::string_view full_name);
  /// Full names of all messages of the files, sorted.
  std::vector<std::string> names() const;

  /// A new message.
  MessagePtr make(const google::protobuf::Descriptor& type) const;
  /// Null if there is no such type.
  MessagePtr make(std::string_view full_name) const;

  /// The message in a frame. Fails if its type is not known, its bytes are none of that type, or lack required fields.
  Expected<MessagePtr> read(const Frame& frame) const;
  /// A frame of the message. Fails if its type has no numbers or the message lacks required fields.
  static Expected<std::string> write(const google::protobuf::Message& message, Crypto* crypto = nullptr);

 private:
  struct Reader;
  std::unique_ptr<Reader> reader_;
  std::map<MessageKey, const google::protobuf::Descriptor*> keys_;
};

}  // namespace cxlab::pb
