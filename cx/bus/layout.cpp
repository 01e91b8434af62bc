#include "cx/bus/layout.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <string>

namespace cxlab::bus {

namespace {

std::string& text_at(std::byte* memory) { return *std::launder(reinterpret_cast<std::string*>(memory)); }
const std::string& text_at(const std::byte* memory) {
  return *std::launder(reinterpret_cast<const std::string*>(memory));
}
Sequence& sequence_at(std::byte* memory) { return *std::launder(reinterpret_cast<Sequence*>(memory)); }
const Sequence& sequence_at(const std::byte* memory) {
  return *std::launder(reinterpret_cast<const Sequence*>(memory));
}

bool plain_element(const Field& field) { return field.is_message() ? field.nested->plain() : !field.is_text(); }

std::size_t inline_count(const Field& field) { return field.array == ArrayKind::kFixed ? field.size_limit : 1; }

/// Moves elements to raw memory; what stays behind is destroyed.
void relocate_elements(const Field& field, std::byte* to, std::byte* from, std::size_t count) {
  if (field.is_text()) {
    for (std::size_t i = 0; i < count; ++i) {
      std::string& old = text_at(from + i * field.stride);
      new (to + i * field.stride) std::string(std::move(old));
      std::destroy_at(&old);
    }
  } else if (plain_element(field)) {
    if (count > 0) std::memcpy(to, from, count * field.stride);
  } else {
    construct_elements(field, to, from, count);
    destroy_elements(field, from, count);
  }
}

}  // namespace

ElementSize element_size(const Field& field) {
  switch (field.type) {
    case FieldType::kBool:
    case FieldType::kByte:
    case FieldType::kChar:
    case FieldType::kInt8:
    case FieldType::kUint8: return {1, 1};
    case FieldType::kInt16:
    case FieldType::kUint16: return {2, 2};
    case FieldType::kInt32:
    case FieldType::kUint32:
    case FieldType::kFloat32: return {4, 4};
    case FieldType::kInt64:
    case FieldType::kUint64:
    case FieldType::kFloat64: return {8, 8};
    case FieldType::kString:
    case FieldType::kWstring: return {sizeof(std::string), alignof(std::string)};
    case FieldType::kMessage: return {field.nested->byte_size(), field.nested->alignment()};
  }
  return {};
}

std::byte* allocate(std::size_t size) { return static_cast<std::byte*>(::operator new(size)); }
void release(std::byte* memory) { ::operator delete(memory); }

void construct(const MessageType& type, std::byte* to, const std::byte* from) {
  std::memcpy(to, from, type.byte_size());
  if (type.plain()) return;
  for (const Field& field : type.fields()) {
    if (field.is_sequence()) {
      const Sequence& old = sequence_at(from + field.offset);
      auto* copy = new (to + field.offset) Sequence{};
      if (old.size == 0) continue;
      copy->data = allocate(old.size * field.stride);
      copy->capacity = copy->size = old.size;
      construct_elements(field, copy->data, old.data, old.size);
    } else if (!plain_element(field)) {
      construct_elements(field, to + field.offset, from + field.offset, inline_count(field));
    }
  }
}

void destroy(const MessageType& type, std::byte* memory) {
  if (type.plain()) return;
  for (const Field& field : type.fields()) {
    if (field.is_sequence()) {
      Sequence& sequence = sequence_at(memory + field.offset);
      destroy_elements(field, sequence.data, sequence.size);
      release(sequence.data);
    } else {
      destroy_elements(field, memory + field.offset, inline_count(field));
    }
  }
}

void construct_elements(const Field& field, std::byte* to, const std::byte* from, std::size_t count) {
  if (field.is_text()) {
    for (std::size_t i = 0; i < count; ++i) new (to + i * field.stride) std::string(text_at(from + i * field.stride));
  } else if (plain_element(field)) {
    if (count > 0) std::memcpy(to, from, count * field.stride);
  } else {
    for (std::size_t i = 0; i < count; ++i) construct(*field.nested, to + i * field.stride, from + i * field.stride);
  }
}

void construct_default_elements(const Field& field, std::byte* to, std::size_t count) {
  if (field.is_text()) {
    for (std::size_t i = 0; i < count; ++i) new (to + i * field.stride) std::string();
  } else if (field.is_message()) {
    for (std::size_t i = 0; i < count; ++i) construct(*field.nested, to + i * field.stride, field.nested->prototype());
  } else if (count > 0) {
    std::memset(to, 0, count * field.stride);
  }
}

void destroy_elements(const Field& field, std::byte* memory, std::size_t count) {
  if (plain_element(field)) return;
  for (std::size_t i = 0; i < count; ++i) {
    if (field.is_text())
      std::destroy_at(&text_at(memory + i * field.stride));
    else
      destroy(*field.nested, memory + i * field.stride);
  }
}

void resize_sequence(const Field& field, Sequence& sequence, std::size_t size) {
  if (size > sequence.capacity) {
    const std::size_t capacity = std::max(size, 2 * sequence.capacity);
    std::byte* data = allocate(capacity * field.stride);
    relocate_elements(field, data, sequence.data, sequence.size);
    release(sequence.data);
    sequence.data = data;
    sequence.capacity = capacity;
  }
  if (size > sequence.size)
    construct_default_elements(field, sequence.data + sequence.size * field.stride, size - sequence.size);
  else
    destroy_elements(field, sequence.data + size * field.stride, sequence.size - size);
  sequence.size = size;
}

}  // namespace cxlab::bus
