// Messages as bytes (the input log). Little-endian; texts and dynamic arrays begin with their length as uint32; a
// message without fields is one zero byte, so that a count in broken bytes cannot ask for more memory than they
// justify.

#include <cstring>

#include "cx/base/byte_codec.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

namespace {

void put(const MessageView& message, ByteWriter& out);

void put_size(std::size_t size, ByteWriter& out) { out.fixed(static_cast<std::uint32_t>(size)); }

void put_field(const MessageView& message, const Field& field, ByteWriter& out) {
  const std::size_t count = message.size(field);
  if (field.is_sequence()) put_size(count, out);
  if (count == 0) return;
  if (field.is_text()) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& text = message.text(field, i);
      put_size(text.size(), out);
      out.raw(text);
    }
  } else if (field.is_message()) {
    for (std::size_t i = 0; i < count; ++i) put(message.nested(field, i), out);
  } else {
    const std::byte* data = field.is_sequence()
                                ? reinterpret_cast<const Sequence*>(message.memory() + field.offset)->data
                                : message.memory() + field.offset;
    out.raw({reinterpret_cast<const char*>(data), count * field.stride});
  }
}

void put(const MessageView& message, ByteWriter& out) {
  if (message.type().fields().empty()) out.fixed('\0');
  for (const Field& field : message.type().fields()) put_field(message, field, out);
}

class MessageReader {
 public:
  MessageReader(std::string_view bytes, std::size_t position) : in_(bytes), size_(bytes.size()) { in_.raw(position); }
  std::size_t position() const { return in_.position(); }

  Status read(const MessageView& message) {
    if (message.type().fields().empty())
      return in_.fixed<char>() == 0 && in_.ok() ? Status() : fail(message.type().name(), "no zero byte");
    for (const Field& field : message.type().fields())
      if (Status status = read_field(message, field); !status) return status;
    return {};
  }

 private:
  Status fail(const std::string& what, const std::string& found) const {
    return input_error(what + ": found " + found + " at byte " + std::to_string(in_.position()) + " of " +
                       std::to_string(size_));
  }

  /// Reads the number of elements or characters of a field. Fails if fewer bytes are left than `element_min` for each.
  Status read_size(const Field& field, std::size_t element_min, std::size_t& size) {
    size = in_.fixed<std::uint32_t>();
    if (!in_.ok()) return fail(field.name, "the end");
    if (in_.left() / element_min < size)
      return fail(field.name, "the size " + std::to_string(size) + ", more than is left");
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
      if (Status status = message.set_text(field, in_.raw(size), i); !status)
        return fail(field.name, status.error().message);
    }
    return {};
  }

  Status read_numbers(const MessageView& message, const Field& field, std::size_t count) {
    const std::string_view bytes = in_.raw(count * field.stride);
    if (!in_.ok()) return fail(field.name, "the end");
    if (field.type == FieldType::kBool && bytes.find_first_not_of(std::string_view("\0\1", 2)) != bytes.npos)
      return fail(field.name, "neither 0 nor 1");
    std::byte* data = field.is_sequence() ? reinterpret_cast<Sequence*>(message.memory() + field.offset)->data
                                          : message.memory() + field.offset;
    std::memcpy(data, bytes.data(), bytes.size());
    return {};
  }

  ByteReader in_;
  std::size_t size_;
};

}  // namespace

void Message::serialize(std::string& out) const {
  ByteWriter writer(out);
  put(view(), writer);
}

Expected<Message> Message::deserialize(const MessageType& type, std::span<const std::byte> bytes,
                                       std::size_t& position) {
  Message message(type);
  if (position > bytes.size())
    return input_error("found position " + std::to_string(position) + " behind the end of the bytes");
  MessageReader reader({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, position);
  const Status status = reader.read(message.view());
  position = reader.position();
  if (!status) return status.error();
  return message;
}

}  // namespace cxlab::bus
