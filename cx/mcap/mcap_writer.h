#pragma once
// Writes MCAP (https://mcap.dev/spec), the container of ROS 2 bags: chunks compressed with zstd, indexed, with
// checksums. It knows nothing of what messages hold.
//
//   auto file = Writer::create("game.mcap", "ros2", "cxlab 0.1.0");
//   const auto schema = file->schema("std_msgs/msg/String", "string data\n");
//   const auto channel = file->channel("/chatter", schema);
//   file->message(channel, t, cdr_bytes);
//   if (Status s = file->close(); !s) ...

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/append_file.h"
#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::mcap {

using SchemaId = std::uint16_t;   ///< from 1
using ChannelId = std::uint16_t;  ///< from 0, in order of coming
using Texts = std::map<std::string, std::string>;

/// The same calls give the same bytes, with the same version of zstd. The first error stays, and `close` returns it.
class Writer {
 public:
  static Expected<Writer> create(const std::filesystem::path& path, std::string_view profile, std::string_view library);

  /// The schema of that name and text (encoding "ros2msg"), which is written once.
  SchemaId schema(const std::string& name, const std::string& text);
  /// A new channel, of messages in CDR.
  ChannelId channel(const std::string& topic, SchemaId schema, const Texts& metadata = {});
  /// Times should not decrease. One before 0 counts as 0.
  void message(ChannelId channel, SimTime t, std::string_view bytes);
  void metadata(std::string_view name, const Texts& texts);
  /// Ends the last chunk and writes the summary.
  Status close();

  std::uint64_t messages() const { return messages_; }
  std::uint64_t bytes() const { return file_.size(); }
  const Status& status() const { return status_; }

 private:
  struct Channel {
    std::string topic, record;
    std::uint32_t sent = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index = {};  ///< in the current chunk: time, place
  };
  struct Chunk {
    std::uint64_t begin = 0, end = 0, start = 0, size = 0, index_size = 0, compressed = 0, uncompressed = 0;
    std::vector<std::pair<ChannelId, std::uint64_t>> indexes;  ///< where that of each channel is
  };
  explicit Writer(AppendFile file) : file_(std::move(file)) {}
  void end_chunk();
  void append(std::string_view bytes);

  AppendFile file_;
  Status status_;
  std::string chunk_, compressed_;
  Chunk under_way_;
  std::map<std::pair<std::string, std::string>, SchemaId> ids_;
  std::vector<std::string> schemas_;  ///< records
  std::vector<Channel> channels_;
  std::vector<Chunk> chunks_;
  std::vector<std::string> metadata_;  ///< records of their index
  std::uint64_t messages_ = 0, first_ = 0, last_ = 0;
  std::uint32_t checksum_ = 0;  ///< of the file so far
};

}  // namespace cxlab::mcap
