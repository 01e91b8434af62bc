#include "cx/bus/message.h"

#include <cassert>
#include <cstring>
#include <new>
#include <utility>

#include "cx/bus/layout.h"
#include "cx/bus/literal.h"

namespace cxlab::bus {

namespace {

Sequence& sequence_of(const Field& field, std::byte* memory) {
  return *std::launder(reinterpret_cast<Sequence*>(memory + field.offset));
}

std::byte* element(const Field& field, std::byte* memory, std::size_t index) {
  if (field.is_sequence()) {
    const Sequence& sequence = sequence_of(field, memory);
    assert(index < sequence.size);
    return sequence.data + index * field.stride;
  }
  assert(index < (field.array == ArrayKind::kFixed ? field.size_limit : 1));
  return memory + field.offset + index * field.stride;
}

template <class T>
T load(const std::byte* memory) {
  T value;
  std::memcpy(&value, memory, sizeof value);
  return value;
}

template <class T>
void store(std::byte* memory, T value) {
  std::memcpy(memory, &value, sizeof value);
}

const Field& known_field(const MessageType& type, std::string_view name) {
  const Field* field = type.find(name);
  assert(field != nullptr && "no such field");
  return *field;
}

/// Code points of a UTF-8 text: what bounds a wstring.
std::size_t text_length(const Field& field, std::string_view text) {
  if (field.type == FieldType::kString) return text.size();
  std::size_t length = 0;
  for (const char c : text) length += (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
  return length;
}

bool equal_elements(const Field& field, const std::byte* a, const std::byte* b, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    auto* left = const_cast<std::byte*>(a + i * field.stride);
    auto* right = const_cast<std::byte*>(b + i * field.stride);
    bool same = false;
    if (field.is_text())
      same = *reinterpret_cast<std::string*>(left) == *reinterpret_cast<std::string*>(right);
    else if (field.is_message())
      same = MessageView(field.nested, left).equals(MessageView(field.nested, right));
    else if (field.type == FieldType::kFloat32)
      same = load<float>(left) == load<float>(right);
    else if (field.type == FieldType::kFloat64)
      same = load<double>(left) == load<double>(right);
    else
      same = std::memcmp(left, right, field.stride) == 0;
    if (!same) return false;
  }
  return true;
}

}  // namespace

// --- By field

std::int64_t MessageView::integer(const Field& field, std::size_t index) const {
  const std::byte* at = element(field, memory_, index);
  switch (field.type) {
    case FieldType::kBool:
    case FieldType::kByte:
    case FieldType::kChar:
    case FieldType::kUint8: return load<std::uint8_t>(at);
    case FieldType::kInt8: return load<std::int8_t>(at);
    case FieldType::kInt16: return load<std::int16_t>(at);
    case FieldType::kUint16: return load<std::uint16_t>(at);
    case FieldType::kInt32: return load<std::int32_t>(at);
    case FieldType::kUint32: return load<std::uint32_t>(at);
    case FieldType::kInt64:
    case FieldType::kUint64: return load<std::int64_t>(at);
    default: assert(false && "not an integer field"); return 0;
  }
}

double MessageView::real(const Field& field, std::size_t index) const {
  if (field.type == FieldType::kFloat64) return load<double>(element(field, memory_, index));
  if (field.type == FieldType::kFloat32) return static_cast<double>(load<float>(element(field, memory_, index)));
  const std::int64_t value = integer(field, index);
  return field.type == FieldType::kUint64 ? static_cast<double>(static_cast<std::uint64_t>(value))
                                          : static_cast<double>(value);
}

const std::string& MessageView::text(const Field& field, std::size_t index) const {
  assert(field.is_text());
  return *std::launder(reinterpret_cast<std::string*>(element(field, memory_, index)));
}

MessageView MessageView::nested(const Field& field, std::size_t index) const {
  assert(field.is_message());
  return {field.nested, element(field, memory_, index)};
}

std::size_t MessageView::size(const Field& field) const {
  if (field.is_sequence()) return sequence_of(field, memory_).size;
  return field.array == ArrayKind::kFixed ? field.size_limit : 1;
}

Status MessageView::set_integer(const Field& field, std::int64_t value, std::size_t index) const {
  std::byte* at = element(field, memory_, index);
  if (field.type == FieldType::kInt64 || field.type == FieldType::kUint64) {
    store(at, value);
    return {};
  }
  assert(field.is_integer());
  const IntegerRange range = integer_range(field.type);
  if (value < range.min || value > static_cast<std::int64_t>(range.max))
    return input_error("field '" + field.name + "': " + found_expected(std::to_string(value), range_text(field.type)));
  switch (field.stride) {
    case 1: store(at, static_cast<std::uint8_t>(value)); break;
    case 2: store(at, static_cast<std::uint16_t>(value)); break;
    default: store(at, static_cast<std::uint32_t>(value)); break;
  }
  return {};
}

void MessageView::set_real(const Field& field, double value, std::size_t index) const {
  assert(field.is_real());
  if (field.type == FieldType::kFloat64)
    store(element(field, memory_, index), value);
  else
    store(element(field, memory_, index), static_cast<float>(value));
}

Status MessageView::set_text(const Field& field, std::string_view value, std::size_t index) const {
  assert(field.is_text());
  if (field.string_limit > 0 && text_length(field, value) > field.string_limit)
    return input_error("field '" + field.name + "': " +
                       found_expected("a text of " + std::to_string(text_length(field, value)) + " characters",
                                      "at most " + std::to_string(field.string_limit)));
  reinterpret_cast<std::string*>(element(field, memory_, index))->assign(value);
  return {};
}

Status MessageView::resize(const Field& field, std::size_t size) const {
  if (!field.is_sequence())
    return input_error("field '" + field.name + "' (" + field.type_text() + ") cannot change its size to " +
                       std::to_string(size));
  if (field.array == ArrayKind::kBounded && size > field.size_limit)
    return input_error(
        "field '" + field.name +
        "': " + found_expected(std::to_string(size) + " elements", "at most " + std::to_string(field.size_limit)));
  resize_sequence(field, sequence_of(field, memory_), size);
  return {};
}

// --- By name

std::int64_t MessageView::integer(std::string_view field) const { return integer(known_field(*type_, field)); }
double MessageView::real(std::string_view field) const { return real(known_field(*type_, field)); }
const std::string& MessageView::text(std::string_view field) const { return text(known_field(*type_, field)); }
MessageView MessageView::nested(std::string_view field, std::size_t index) const {
  return nested(known_field(*type_, field), index);
}
std::size_t MessageView::size(std::string_view field) const { return size(known_field(*type_, field)); }

const MessageView& MessageView::set(std::string_view name, std::int64_t value) const {
  const Field& field = known_field(*type_, name);
  if (field.is_real()) {
    set_real(field, static_cast<double>(value));
  } else {
    [[maybe_unused]] const Status status = set_integer(field, value);
    assert(status.ok() && "out of the field's range");
  }
  return *this;
}

const MessageView& MessageView::set(std::string_view field, double value) const {
  set_real(known_field(*type_, field), value);
  return *this;
}

const MessageView& MessageView::set(std::string_view field, std::string_view value) const {
  [[maybe_unused]] const Status status = set_text(known_field(*type_, field), value);
  assert(status.ok() && "longer than the field's bound");
  return *this;
}

MessageView MessageView::append(std::string_view name) const {
  const Field& field = known_field(*type_, name);
  const std::size_t last = size(field);
  [[maybe_unused]] const Status status = resize(field, last + 1);
  assert(status.ok() && "not a dynamic array, or beyond its bound");
  return nested(field, last);
}

const MessageView& MessageView::append_text(std::string_view name, std::string_view value) const {
  const Field& field = known_field(*type_, name);
  const std::size_t last = size(field);
  [[maybe_unused]] Status status = resize(field, last + 1);
  assert(status.ok() && "not a dynamic array, or beyond its bound");
  status = set_text(field, value, last);
  assert(status.ok() && "longer than the field's bound");
  return *this;
}

// --- Whole messages

void MessageView::copy_from(const MessageView& other) const {
  assert(type_ == other.type_);
  if (memory_ == other.memory_) return;
  destroy(*type_, memory_);
  construct(*type_, memory_, other.memory_);
}

bool MessageView::equals(const MessageView& other) const {
  if (type_ != other.type_) return false;
  for (const Field& field : type_->fields()) {
    const std::size_t count = size(field);
    if (count != other.size(field)) return false;
    if (count > 0 && !equal_elements(field, element(field, memory_, 0), element(field, other.memory_, 0), count))
      return false;
  }
  return true;
}

void Message::FreeMemory::operator()(std::byte* memory) const { release(memory); }

Message::Message(const MessageType& type) : Message(MessageView(&type, const_cast<std::byte*>(type.prototype()))) {}

Message::Message(const MessageView& other) {
  if (!other) return;
  type_ = &other.type();
  memory_.reset(allocate(type_->byte_size()));
  construct(*type_, memory_.get(), other.memory());
}

Message::Message(Message&& other) noexcept
    : type_(std::exchange(other.type_, nullptr)), memory_(std::move(other.memory_)) {}

Message& Message::operator=(Message other) noexcept {
  std::swap(type_, other.type_);
  std::swap(memory_, other.memory_);
  return *this;
}

Message::~Message() {
  if (memory_) destroy(*type_, memory_.get());
}

}  // namespace cxlab::bus
