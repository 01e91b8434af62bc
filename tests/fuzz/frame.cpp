// Frames of the league's protocol, as a datagram, a stream and a message. The first byte chooses the cipher, and in how
// large pieces the stream comes.

#include <google/protobuf/message.h>

#include <optional>

#include "cx/protobuf/types.h"
#include "cx/protobuf/wire.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_frame {
namespace {

using namespace cxlab;

constexpr const char* kTypes = R"(syntax = "proto2";
message All {
  enum CompType { COMP_ID = 1; MSG_TYPE = 2; }
  optional All inner = 1;
  repeated sint64 numbers = 2 [packed = true];
  optional string text = 3;
  optional bytes raw = 4;
  required bool flag = 5;
  map<string, double> values = 6;
  optional group Part = 7 { repeated fixed32 ids = 1; }
}
)";

pb::Types& types() {
  static pb::Types known([](const std::string&) -> Expected<std::optional<pb::Types::Source>> {
    return std::optional(pb::Types::Source{kTypes, "all.proto"});
  });
  static const bool read = known.add_file("all.proto").ok();
  fuzz::promise(read, "the types are known");
  return known;
}

void read(const pb::Frame& frame) {
  const auto message = types().read(frame);
  if (!message) return;
  const auto bytes = pb::Types::write(**message);
  fuzz::promise(bytes.ok(), "a message that was read can be written");
  const auto again = pb::read_datagram(*bytes);
  fuzz::promise(again.ok() && again->key == frame.key, "a frame that was written can be read");
  fuzz::promise(types().read(*again).ok(), "and so can its message");
}

}  // namespace

FUZZ_TARGET(frame) {
  if (size == 0) return 0;
  const std::string bytes = fuzz::text_of(data + 1, size - 1);
  const auto cipher = static_cast<pb::Cipher>(data[0] % 5);
  const std::unique_ptr<pb::Crypto> crypto =
      cipher == pb::Cipher::kNone ? nullptr : *pb::Crypto::create(cipher, "randomkey");
  if (const auto frame = pb::read_datagram(bytes, crypto.get())) {
    read(*frame);
    const auto again = pb::read_datagram(pb::write_frame(frame->key, frame->content, crypto.get()), crypto.get());
    fuzz::promise(again.ok() && again->key == frame->key && again->content == frame->content, "a frame comes back");
  }
  if (const auto frame = pb::read_datagram(pb::write_frame({1, 2}, bytes))) read(*frame);
  pb::StreamReader reader;
  const std::size_t piece = 1 + data[0] / 5;
  std::size_t frames = 0;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    reader.add(std::string_view(bytes).substr(at, piece));
    auto next = reader.next();
    for (; next && *next; next = reader.next()) {
      read(**next);
      ++frames;
    }
    if (!next) break;
  }
  fuzz::promise(frames * (pb::kFrameHeader + pb::kMessageHeader) <= bytes.size(), "no more frames than bytes");
  return 0;
}

}  // namespace fuzz_frame
