// Messages as YAML, and as bytes: what is read is the same again after a way through bytes and through its own text.

#include <span>

#include "cx/bus/literal.h"
#include "cx/bus/message.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/types.h"

namespace fuzz_message {
namespace {

std::string bytes_of(const cxlab::bus::Message& message) {
  std::string bytes;
  message.serialize(bytes);
  return bytes;
}

}  // namespace

FUZZ_TARGET(message) {
  using namespace cxlab;
  if (size == 0) return 0;
  const char* names[] = {"every/msg/Kind", "rcll_interfaces/msg/MachineInfo", "geometry_msgs/msg/PoseStamped"};
  const auto type = fuzz::types().message(names[data[0] / 2 % 3]);
  fuzz::promise(type.ok(), "the types are known");
  const std::string text = fuzz::text_of(data + 1, size - 1);
  (void)bus::parse_list(text);
  (void)bus::parse_text(text);
  (void)bus::parse_real(text);
  if (data[0] % 2 == 0) {
    std::size_t position = 0;
    const auto message = bus::Message::deserialize(**type, std::as_bytes(std::span(text)), position);
    fuzz::promise(position <= text.size(), "nothing is read beyond the end");
    if (message) (void)(*message)->to_string();
    return 0;
  }
  const auto message = bus::Message::from_yaml(**type, text);
  if (!message) return 0;
  const std::string bytes = bytes_of(*message);
  std::size_t position = 0;
  const auto again = bus::Message::deserialize(**type, std::as_bytes(std::span(bytes)), position);
  fuzz::promise(again.ok() && position == bytes.size() && bytes_of(*again) == bytes,
                "a message comes back from its bytes");
  const auto read = bus::Message::from_yaml(**type, (*message)->to_string());
  fuzz::promise(read.ok(), "the text of a message reads: " + (read ? std::string() : read.error().message));
  return 0;
}

}  // namespace fuzz_message
