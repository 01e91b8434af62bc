#pragma once
// The messages that the rules of one environment hold, by handle.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "cx/base/flat_table.h"
#include "cx/bus/message.h"
#include "cx/executive/environment.h"

namespace cxlab::cx {

/// Every message that was created or received stays until the rules destroy it. A nested message is a handle into its
/// parent and dies with it. Messages that others hold, too, are copied before the first change. All plugins of an
/// environment share the store (`environment.common<MessageStore>()`), so that any of them reads what another nested;
/// each message has an owner, whose leak it would be.
class MessageStore {
 public:
  enum class Owner : std::uint32_t {};

  explicit MessageStore(Environment& environment) : engine_(environment.engine()) {}

  RuleEngine& engine() const { return engine_; }
  Owner new_owner();
  Handle create(const bus::MessageType& type, Owner owner);
  Handle receive(bus::SharedMessage message, Owner owner);
  /// With all that is nested in it; false if unknown.
  bool destroy(Handle handle);
  /// All of that owner.
  void destroy_all(Owner owner);

  /// Empty if the handle is unknown, or the array that it pointed into has become shorter.
  bus::MessageView view(Handle handle) const;
  /// The same for changing it.
  bus::MessageView writable(Handle handle);
  /// To post it: no copy until the rules change it. Null if the handle is unknown.
  bus::SharedMessage share(Handle handle) const;
  /// The handle of a message in a field of `parent`, which must be known; the same each time.
  Handle nested(Handle parent, const bus::Field& field, std::size_t index);

  /// Messages of that owner, nested ones not counted.
  std::size_t size(Owner owner) const { return sizes_[static_cast<std::size_t>(owner)]; }
  std::size_t size(Owner owner, const bus::MessageType& type) const;

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;  // no entry

  struct Entry {
    Handle handle = Handle::kNone;  // none: free, `next` is the next free one
    bus::SharedMessage message;     // of a root
    bool own = false;               // made here: may be changed while nobody else holds it
    Owner owner{};
    std::uint32_t parent = kNone;  // of a nested one, with its place there:
    const bus::Field* field = nullptr;
    std::size_t index = 0;
    std::uint32_t first = kNone, last = kNone;  // children, a list through `next`
    std::uint32_t found = kNone;                // the child that was asked for last
    std::size_t beyond = 0;                     // one more than the largest index of a child
    std::uint32_t next = kNone;
  };
  struct Place {
    Handle key = Handle::kNone;
    std::uint32_t entry = 0;
  };

  std::uint32_t add();
  Handle add_root(bus::SharedMessage message, bool own, Owner owner);
  void erase(std::uint32_t entry);
  std::uint32_t find(Handle handle) const;
  std::uint32_t find_child(std::uint32_t from, std::uint32_t end, const bus::Field& field, std::size_t index) const;
  bus::MessageView view_of(const Entry& entry) const;

  RuleEngine& engine_;
  std::vector<Entry> entries_;
  std::uint32_t free_ = kNone;
  FlatTable<Place> places_;
  std::vector<std::size_t> sizes_;  // by owner
};

}  // namespace cxlab::cx
