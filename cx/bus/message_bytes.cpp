// Messages as bytes (the input log). Little-endian; texts and dynamic arrays begin with their length as uint32; a
// message without fields is one zero byte, so that a count in broken bytes cannot ask for more memory than they
// justify.

#include <bit>
#include <cstring>

#include "cx/bus/message.h"

namespace cxlab::bus {

static_assert(std::endian::native == std::endian::little);

namespace {

void put_size(std::string& out, std::size_t size) {
  const auto value = static_cast<std::uint32_t>(size);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put(const MessageView& message, std::string& out);

void put_field(const MessageView& message, const Field& field, std::string& out) {
  const std::size_t count = message.size(field);
  if (field.is_sequence()) put_size(out, count);
  if (count == 0) return;
  if (field.is_text()) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& text = message.text(field, i);
      put_size(out, text.size());
      out += text;
    }
  } else if (field.is_message()) {
    for (std::size_t i = 0; i < count; ++i) put(message.nested(field, i), out);
  } else {
    const std::byte* data = field.is_sequence()
                                ? reinterpret_cast<const Sequence*>(message.memory() + field.offset)->data
                                : message.memory() + field.offset;
    out.append(reinterpret_cast<const char*>(data), count * field.stride);
  }
}

void put(const MessageView& message, std::string& out) {
  if (message.type().fields().empty()) out += '\0';
  for (const Field& field : message.type().fields()) put_field(message, field, out);
}

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::size_t& position) : bytes_(bytes), position_(position) {}

  Status read(const MessageView& message) {
    if (message.type().fields().empty()) return skip_empty(message);
    for (const Field& field : message.type().fields())
      if (Status status = read_field(message, field); !status) return status;
    return {};
  }

 private:
  std::size_t left() const { return bytes_.size() - position_; }

  Error fail(const std::string& what, const std::string& found) const {
    return input_error(what + ": found " + found + " at byte " + std::to_string(position_) + " of " +
                       std::to_string(bytes_.size()));
  }

  Status skip_empty(const MessageView& message) {
    if (left() < 1 || bytes_[position_] != std::byte{0}) return fail(message.type().name(), "no zero byte");
    ++position_;
    return {};
  }

  Status read_size(const Field& field, std::size_t element_min, std::size_t& size) {
    std::uint32_t value = 0;
    if (left() < sizeof value) return fail(field.name, "the end");
    std::memcpy(&value, &bytes_[position_], sizeof value);
    if ((left() - sizeof value) / element_min < value)
      return fail(field.name, "the size " + std::to_string(value) + ", more than is left");
    position_ += sizeof value;
    size = value;
    return {};
  }

  Status read_field(const MessageView& message, const Field& field) {
    const std::size_t element_min = field.is_text()      ? 4
                                    : field.is_message() ? field.nested->serialized_min()
                                                         : field.stride;
    std::size_t count = message.size(field);
    if (field.is_sequence()) {
      if (Status status = read_size(field, element_min, count); !status) return status;
      if (Status status = message.resize(field, count); !status) return fail(field.name, status.error().message);
    }
    if (count == 0) return {};
    if (field.is_text()) return read_texts(message, field, count);
    if (field.is_message()) {
      for (std::size_t i = 0; i < count; ++i)
        if (Status status = read(message.nested(field, i)); !status) return status;
      return {};
    }
    return read_numbers(message, field, count);
  }

  Status read_texts(const MessageView& message, const Field& field, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::size_t size = 0;
      if (Status status = read_size(field, 1, size); !status) return status;
      const std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + position_, size);
      if (Status status = message.set_text(field, text, i); !status) return fail(field.name, status.error().message);
      position_ += size;
    }
    return {};
  }

  Status read_numbers(const MessageView& message, const Field& field, std::size_t count) {
    const std::size_t size = count * field.stride;
    if (left() < size) return fail(field.name, "the end");
    if (field.type == FieldType::kBool)
      for (std::size_t i = 0; i < count; ++i)
        if (bytes_[position_ + i] > std::byte{1}) return fail(field.name, "neither 0 nor 1");
    std::byte* data = field.is_sequence() ? reinterpret_cast<Sequence*>(message.memory() + field.offset)->data
                                          : message.memory() + field.offset;
    std::memcpy(data, bytes_.data() + position_, size);
    position_ += size;
    return {};
  }

  std::span<const std::byte> bytes_;
  std::size_t& position_;
};

}  // namespace

void Message::serialize(std::string& out) const { put(view(), out); }

Expected<Message> Message::deserialize(const MessageType& type, std::span<const std::byte> bytes,
                                       std::size_t& position) {
  Message message(type);
  if (position > bytes.size())
    return input_error("found position " + std::to_string(position) + " behind the end of the bytes");
  if (Status status = Reader(bytes, position).read(message.view()); !status) return status.error();
  return message;
}

}  // namespace cxlab::bus
