#pragma once
// How messages travel between programs of the league (protobuf_comm): frames, and what encrypts them.
//
//   frame header   u8 version = 2, u8 cipher, u8 0, u8 0, u32 payload size     all integers big-endian
//   payload        u16 component id, u16 message type, protobuf bytes
//
// Encrypted: the payload is, for the CBC ciphers, 16 bytes of IV and then what stands above, encrypted. A datagram
// holds one frame; a stream is frames one after the other.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cx/base/expected.h"

namespace cxlab::pb {

/// What identifies a type of messages on the wire.
struct MessageKey {
  std::uint16_t component_id = 0, message_type = 0;
  auto operator<=>(const MessageKey&) const = default;
};

enum class Cipher : std::uint8_t { kNone, kAes128Ecb, kAes128Cbc, kAes256Ecb, kAes256Cbc };

/// "aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc".
Expected<Cipher> cipher_of(std::string_view name);

/// Encrypts what one peer sends and decrypts what it receives.
class Crypto {
 public:
  /// The key of the cipher is made from the pass phrase. Not for kNone.
  static Expected<std::unique_ptr<Crypto>> create(Cipher cipher, std::string_view pass_phrase);
  ~Crypto();
  Crypto(const Crypto&) = delete;
  Crypto& operator=(const Crypto&) = delete;

  Cipher cipher() const { return cipher_; }
  /// With its IV, which is another one each time but the same in each run.
  std::string encrypt(std::string_view plain);
  /// Fails if it was not encrypted with this key, as far as that can be seen.
  Expected<std::string> decrypt(std::string_view encrypted) const;

 private:
  struct Context;
  explicit Crypto(Cipher cipher);

  Cipher cipher_;
  std::unique_ptr<Context> context_;
  std::uint64_t count_ = 0;  ///< messages encrypted so far
};

/// A frame that was read.
struct Frame {
  MessageKey key;
  std::string content;  ///< protobuf bytes
};

inline constexpr std::size_t kFrameHeader = 8, kMessageHeader = 4;
/// The largest accepted payload of a stream's frame.
inline constexpr std::size_t kLargestPayload = 16 << 20;
/// The largest datagram.
inline constexpr std::size_t kLargestDatagram = 65507;

/// The bytes of a frame; `crypto` may be none.
std::string write_frame(MessageKey key, std::string_view content, Crypto* crypto = nullptr);

/// Reads a datagram. Without `crypto` an encrypted one is refused, with it one that is not.
Expected<Frame> read_datagram(std::string_view bytes, const Crypto* crypto = nullptr);

/// Reads the frames of a stream, which are never encrypted.
class StreamReader {
 public:
  void add(std::string_view bytes);
  /// The next frame, or none until more bytes come. After an error nothing that follows can be read.
  Expected<std::optional<Frame>> next();

 private:
  std::string bytes_;
  std::size_t read_ = 0;
};

}  // namespace cxlab::pb
