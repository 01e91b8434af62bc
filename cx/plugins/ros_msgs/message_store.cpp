#include "cx/plugins/ros_msgs/message_store.h"

#include <algorithm>

namespace cxlab::cx {

Handle MessageStore::add(Entry entry) {
  const Handle handle = engine_.new_handle();
  if (entry.parent == Handle::kNone) ++roots_;
  entries_.emplace(handle, std::move(entry));
  return handle;
}

Handle MessageStore::create(const bus::MessageType& type) {
  Entry entry;
  entry.message = std::make_shared<bus::Message>(type);
  entry.own = true;
  return add(std::move(entry));
}

Handle MessageStore::receive(bus::SharedMessage message) {
  Entry entry;
  entry.message = std::move(message);
  return add(std::move(entry));
}

void MessageStore::erase(Handle handle) {
  const auto found = entries_.find(handle);
  if (found == entries_.end()) return;
  const std::vector<Handle> children = std::move(found->second.children);
  if (found->second.parent == Handle::kNone) --roots_;
  entries_.erase(found);
  for (const Handle child : children) erase(child);
}

bool MessageStore::destroy(Handle handle) {
  const auto found = entries_.find(handle);
  if (found == entries_.end()) return false;
  if (const auto parent = entries_.find(found->second.parent); parent != entries_.end()) std::erase(parent->second.children, handle);
  erase(handle);
  return true;
}

bus::MessageView MessageStore::view(Handle handle) const {
  const auto found = entries_.find(handle);
  if (found == entries_.end()) return {};
  const Entry& entry = found->second;
  if (entry.message) return entry.message->view();
  const bus::MessageView parent = view(entry.parent);
  if (!parent || entry.index >= parent.size(*entry.field)) return {};
  return parent.nested(*entry.field, entry.index);
}

bus::MessageView MessageStore::writable(Handle handle) {
  auto root = entries_.find(handle);
  while (root != entries_.end() && !root->second.message) root = entries_.find(root->second.parent);
  if (root == entries_.end()) return {};
  Entry& entry = root->second;
  if (!entry.own || entry.message.use_count() > 1) {
    entry.message = std::make_shared<bus::Message>(entry.message->view());
    entry.own = true;
  }
  return view(handle);
}

bus::SharedMessage MessageStore::share(Handle handle) const {
  const auto found = entries_.find(handle);
  if (found == entries_.end()) return nullptr;
  if (found->second.message) return found->second.message;
  const bus::MessageView part = view(handle);
  return part ? std::make_shared<bus::Message>(part) : nullptr;
}

Handle MessageStore::nested(Handle parent, const bus::Field& field, std::size_t index) {
  for (const Handle child : entries_.at(parent).children) {
    const Entry& entry = entries_.at(child);
    if (entry.field == &field && entry.index == index) return child;
  }
  Entry entry;
  entry.parent = parent;
  entry.field = &field;
  entry.index = index;
  const Handle handle = add(std::move(entry));
  entries_.at(parent).children.push_back(handle);
  return handle;
}

}  // namespace cxlab::cx
