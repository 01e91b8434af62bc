#pragma once
// Reads MCAP from its start to its end, as `ros2 bag record` and cxlab write it. It needs no index: a file whose end is
// missing, because the recorder was killed, is read up to there.
//
//   auto file = Reader::open("floor.mcap");
//   for (;;) {
//     auto message = file->next();
//     if (!message || !*message) break;
//     use((*message)->channel->topic, (*message)->t, (*message)->bytes);
//   }

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cx/base/byte_codec.h"
#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::mcap {

struct Schema {
  std::string name, encoding, text;
};

struct Channel {
  std::string topic, message_encoding;
  const Schema* schema = nullptr;  ///< none: the messages have none
  std::map<std::string, std::string> metadata;
};

/// What it points to is there until the next call of `Reader::next`.
struct ReadMessage {
  const Channel* channel = nullptr;
  SimTime t{};  ///< when it was recorded
  std::uint32_t sequence = 0;
  std::string_view bytes;
  std::uint64_t place = 0;  ///< the byte of the file at which its chunk begins; its own record, where it is in none
  bool in_chunk = false;
};

class Reader {
 public:
  /// kInput if the file cannot be read or is no MCAP.
  static Expected<Reader> open(const std::filesystem::path& path);
  static Expected<Reader> from_bytes(std::string bytes, const std::string& name);

  /// The next message in the order of the file; none at its end. Errors name the file and the byte: what comes after a
  /// broken record is not read.
  Expected<std::optional<ReadMessage>> next();
  /// Goes on with the chunk or message at that byte, which is the `place` of a message that was read before.
  void go_to(std::uint64_t place);
  /// The file ends without its end mark: its recorder was killed.
  bool cut_off() const { return cut_off_; }
  const std::string& name() const { return name_; }

 private:
  Reader(std::string name, std::unique_ptr<std::istream> in, std::uint64_t size)
      : name_(std::move(name)), in_(std::move(in)), size_(size) {}
  static Expected<Reader> begin(Reader reader);
  Error broken(const std::string& what) const;
  /// The next record of the file; false at the end of the data.
  Expected<bool> read_record();
  Status take_schema(ByteReader content);
  Status take_channel(ByteReader content);
  Status take_chunk(ByteReader content);
  /// Into `chunk_`, which holds `size` bytes at most.
  Status unpack_zstd(std::string_view packed, std::size_t size);
  Status unpack_lz4(std::string_view packed, std::size_t size);
  Expected<ReadMessage> message_of(ByteReader content) const;

  std::string name_;
  std::unique_ptr<std::istream> in_;
  std::uint64_t size_ = 0, at_ = 0, record_start_ = 0;
  std::uint8_t opcode_ = 0;
  std::string content_;  ///< of the record
  std::string chunk_;    ///< records of the current chunk
  std::size_t chunk_at_ = 0;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  bool cut_off_ = false, ended_ = false;
};

}  // namespace cxlab::mcap
