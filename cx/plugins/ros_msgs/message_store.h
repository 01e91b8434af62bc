#pragma once
// The messages that the rules of one environment hold, by handle.

#include <cstddef>
#include <memory>
#include <unordered_map>
#include <vector>

#include "cx/bus/message.h"
#include "cx/engine/engine.h"

namespace cxlab::cx {

/// Every message that was created or received stays until the rules destroy it. A nested message is a handle into its
/// parent and dies with it. Messages that others hold, too, are copied before the first change.
class MessageStore {
 public:
  explicit MessageStore(RuleEngine& engine) : engine_(engine) {}

  Handle create(const bus::MessageType& type);
  Handle receive(bus::SharedMessage message);
  /// With all that is nested in it; false if unknown.
  bool destroy(Handle handle);

  /// Empty if the handle is unknown, or the array that it pointed into has become shorter.
  bus::MessageView view(Handle handle) const;
  /// The same for changing it.
  bus::MessageView writable(Handle handle);
  /// To post it: no copy until the rules change it. Null if the handle is unknown.
  bus::SharedMessage share(Handle handle) const;
  /// The handle of a message in a field; the same each time.
  Handle nested(Handle parent, const bus::Field& field, std::size_t index);

  /// Messages, nested ones not counted.
  std::size_t size() const { return roots_; }

 private:
  struct Entry {
    std::shared_ptr<const bus::Message> message;  // of a root
    bool own = false;                             // made here: may be changed while nobody else holds it
    Handle parent = Handle::kNone;                // of a nested one, with its place there:
    const bus::Field* field = nullptr;
    std::size_t index = 0;
    std::vector<Handle> children;
  };
  Handle add(Entry entry);
  void erase(Handle handle);

  RuleEngine& engine_;
  std::unordered_map<Handle, Entry> entries_;
  std::size_t roots_ = 0;
};

}  // namespace cxlab::cx
