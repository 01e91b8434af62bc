#include "cx/plugins/ros_msgs/message_store.h"

#include <algorithm>

namespace cxlab::cx {

MessageStore::Owner MessageStore::new_owner() {
  sizes_.push_back(0);
  return static_cast<Owner>(sizes_.size() - 1);
}

std::size_t MessageStore::size(Owner owner, const bus::MessageType& type) const {
  return static_cast<std::size_t>(std::ranges::count_if(entries_, [&](const Entry& entry) {
    return entry.message && entry.owner == owner && &entry.message->view().type() == &type;
  }));
}

std::uint32_t MessageStore::find(Handle handle) const {
  const Place* place = places_.find(handle);
  return place == nullptr ? kNone : place->entry;
}

// --- Entries

std::uint32_t MessageStore::add() {
  std::uint32_t at = free_;
  if (at == kNone) {
    at = static_cast<std::uint32_t>(entries_.size());
    entries_.emplace_back();
  } else {
    free_ = entries_[at].next;
    entries_[at].next = kNone;
  }
  entries_[at].handle = engine_.new_handle();
  places_.insert(entries_[at].handle).entry = at;
  return at;
}

Handle MessageStore::add_root(bus::SharedMessage message, bool own, Owner owner) {
  Entry& entry = entries_[add()];
  entry.message = std::move(message);
  entry.own = own;
  entry.owner = owner;
  ++sizes_[static_cast<std::size_t>(owner)];
  return entry.handle;
}

Handle MessageStore::create(const bus::MessageType& type, Owner owner) {
  return add_root(std::make_shared<bus::Message>(type), true, owner);
}

Handle MessageStore::receive(bus::SharedMessage message, Owner owner) {
  return add_root(std::move(message), false, owner);
}

void MessageStore::erase(std::uint32_t at) {
  for (std::uint32_t child = entries_[at].first; child != kNone;) {
    const std::uint32_t next = entries_[child].next;
    erase(child);
    child = next;
  }
  Entry& entry = entries_[at];
  places_.erase(entry.handle);
  if (entry.parent == kNone) --sizes_[static_cast<std::size_t>(entry.owner)];
  entry = {};
  entry.next = free_;
  free_ = at;
}

bool MessageStore::destroy(Handle handle) {
  const std::uint32_t at = find(handle);
  if (at == kNone) return false;
  if (entries_[at].parent != kNone) {
    Entry& parent = entries_[entries_[at].parent];
    std::uint32_t before = kNone;
    for (std::uint32_t child = parent.first; child != at; child = entries_[child].next) before = child;
    (before == kNone ? parent.first : entries_[before].next) = entries_[at].next;
    if (parent.last == at) parent.last = before;
    parent.found = kNone;
  }
  erase(at);
  return true;
}

void MessageStore::destroy_all(Owner owner) {
  for (std::uint32_t at = 0; at < entries_.size(); ++at) {
    const Entry& entry = entries_[at];
    if (entry.handle != Handle::kNone && entry.parent == kNone && entry.owner == owner) erase(at);
  }
}

// --- Messages

bus::MessageView MessageStore::view_of(const Entry& entry) const {
  if (entry.message) return entry.message->view();
  const bus::MessageView parent = view_of(entries_[entry.parent]);
  if (!parent || entry.index >= parent.size(*entry.field)) return {};
  return parent.nested(*entry.field, entry.index);
}

bus::MessageView MessageStore::view(Handle handle) const {
  const std::uint32_t at = find(handle);
  return at == kNone ? bus::MessageView() : view_of(entries_[at]);
}

bus::MessageView MessageStore::writable(Handle handle) {
  const std::uint32_t at = find(handle);
  if (at == kNone) return {};
  Entry* root = &entries_[at];
  while (!root->message) root = &entries_[root->parent];
  if (!root->own || root->message.use_count() > 1) {
    root->message = std::make_shared<bus::Message>(root->message->view());
    root->own = true;
  }
  return view_of(entries_[at]);
}

bus::SharedMessage MessageStore::share(Handle handle) const {
  const std::uint32_t at = find(handle);
  if (at == kNone) return nullptr;
  if (entries_[at].message) return entries_[at].message;
  const bus::MessageView part = view_of(entries_[at]);
  return part ? std::make_shared<bus::Message>(part) : nullptr;
}

std::uint32_t MessageStore::find_child(std::uint32_t from, std::uint32_t end, const bus::Field& field,
                                       std::size_t index) const {
  for (std::uint32_t child = from; child != end && child != kNone; child = entries_[child].next)
    if (entries_[child].field == &field && entries_[child].index == index) return child;
  return kNone;
}

Handle MessageStore::nested(Handle handle, const bus::Field& field, std::size_t index) {
  const std::uint32_t parent = find(handle);
  std::uint32_t child = kNone;
  if (index < entries_[parent].beyond) {
    // Elements of an array are asked for one after the other.
    const std::uint32_t start = entries_[parent].found;
    child = find_child(start, kNone, field, index);
    if (child == kNone) child = find_child(entries_[parent].first, start, field, index);
  }
  if (child == kNone) {
    child = add();
    Entry& entry = entries_[child];
    entry.parent = parent;
    entry.field = &field;
    entry.index = index;
    Entry& above = entries_[parent];
    (above.first == kNone ? above.first : entries_[above.last].next) = child;
    above.last = child;
    above.beyond = std::max(above.beyond, index + 1);
  }
  entries_[parent].found = child;
  return entries_[child].handle;
}

}  // namespace cxlab::cx
