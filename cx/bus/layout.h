#pragma once
// Memory of messages: constructing, copying and destroying what a MessageType lays out. For the bus itself.

#include <cstddef>

#include "cx/bus/interface.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

/// Bytes of one element, and the alignment that it needs.
struct ElementSize {
  std::size_t size = 0, alignment = 1;
};
ElementSize element_size(const Field& field);

std::byte* allocate(std::size_t size);
void release(std::byte* memory);

/// Makes `to`, raw memory, a copy of `from`.
void construct(const MessageType& type, std::byte* to, const std::byte* from);
void destroy(const MessageType& type, std::byte* memory);

/// The same for `count` elements of a field that lie one after the other.
void construct_elements(const Field& field, std::byte* to, const std::byte* from, std::size_t count);
void construct_default_elements(const Field& field, std::byte* to, std::size_t count);
void destroy_elements(const Field& field, std::byte* memory, std::size_t count);

/// Changes the number of elements; those that stay keep their value. Does not check the field's bound.
void resize_sequence(const Field& field, Sequence& sequence, std::size_t size);

}  // namespace cxlab::bus
