#include "cx/mcap/mcap_writer.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>

#include "cx/base/byte_codec.h"
#include "cx/mcap/records.h"

namespace cxlab::mcap {

namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr int kLevel = 3;  // of zstd: its default

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

/// The content of a record, and the record.
class Record {
 public:
  explicit Record(Opcode opcode) : opcode_(opcode) {}
  template <class T>
  Record& number(T value) {
    ByteWriter(content_).fixed(value);
    return *this;
  }
  Record& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    content_ += text;
    return *this;
  }
  /// A map or array: its length in bytes, then the entries that `fill` writes.
  template <class Fill>
  Record& entries(Fill fill) {
    const std::size_t at = content_.size();
    number(std::uint32_t{0});
    fill();
    std::string size;
    ByteWriter(size).fixed(static_cast<std::uint32_t>(content_.size() - at - 4));
    content_.replace(at, 4, size);
    return *this;
  }
  Record& texts(const Texts& texts) {
    return entries([&] {
      for (const auto& [key, value] : texts) text(key).text(value);
    });
  }
  Record& bytes(std::string_view bytes) {
    content_ += bytes;
    return *this;
  }
  std::string whole() const {
    std::string out;
    ByteWriter(out).fixed(opcode_).fixed(static_cast<std::uint64_t>(content_.size())).raw(content_);
    return out;
  }

 private:
  Opcode opcode_;
  std::string content_;
};

}  // namespace

Expected<Writer> Writer::create(const std::filesystem::path& path, std::string_view profile, std::string_view library) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  Writer out(*std::move(file));
  out.append({kMagic, kMagicSize});
  out.append(Record(Opcode::kHeader).text(profile).text(library).whole());
  return out;
}

void Writer::append(std::string_view bytes) {
  checksum_ = crc_of(bytes, checksum_);
  if (Status s = file_.append(bytes); !s && status_) status_ = s;
}

SchemaId Writer::schema(const std::string& name, const std::string& text) {
  if (const auto known = ids_.find({name, text}); known != ids_.end()) return known->second;
  if (schemas_.size() >= std::numeric_limits<SchemaId>::max()) {
    if (status_) status_ = input_error("found more than 65535 types of messages, which is all that MCAP can hold");
    return 1;
  }
  const auto id = static_cast<SchemaId>(schemas_.size() + 1);
  ids_.emplace(std::pair(name, text), id);
  schemas_.push_back(Record(Opcode::kSchema).number(id).text(name).text("ros2msg").text(text).whole());
  chunk_ += schemas_.back();
  return id;
}

ChannelId Writer::channel(const std::string& topic, SchemaId schema, const Texts& metadata) {
  if (channels_.size() > std::numeric_limits<ChannelId>::max()) {
    if (status_) status_ = input_error("found more than 65536 topics, which is all that MCAP can hold");
    return 0;
  }
  const auto id = static_cast<ChannelId>(channels_.size());
  channels_.push_back(
      {topic, Record(Opcode::kChannel).number(id).number(schema).text(topic).text("cdr").texts(metadata).whole()});
  chunk_ += channels_.back().record;
  return id;
}

void Writer::message(ChannelId channel, SimTime t, std::string_view bytes) {
  const auto time = static_cast<std::uint64_t>(std::max<std::int64_t>(0, t.count()));
  Channel& of = channels_[channel];
  const bool first_of_chunk = under_way_.indexes.empty();
  if (of.index.empty()) under_way_.indexes.emplace_back(channel, 0);
  of.index.emplace_back(time, chunk_.size());
  // Built here, without a copy.
  ByteWriter(chunk_)
      .fixed(Opcode::kMessage)
      .fixed(static_cast<std::uint64_t>(22 + bytes.size()))
      .fixed(channel)
      .fixed(of.sent++)
      .fixed(time)
      .fixed(time)
      .raw(bytes);
  const bool first_of_all = messages_++ == 0;
  first_ = first_of_all ? time : std::min(first_, time);
  last_ = std::max(last_, time);
  under_way_.begin = first_of_chunk ? time : std::min(under_way_.begin, time);
  under_way_.end = std::max(under_way_.end, time);
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void Writer::end_chunk() {
  if (chunk_.empty()) return;
  compressed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size = ZSTD_compress(compressed_.data(), compressed_.size(), chunk_.data(), chunk_.size(), kLevel);
  if (ZSTD_isError(size)) {
    if (status_) status_ = resource_error(std::string("zstd: ") + ZSTD_getErrorName(size));
    for (Channel& channel : channels_) channel.index.clear();
    under_way_ = {};
    chunk_.clear();
    return;
  }
  Chunk chunk = std::exchange(under_way_, {});
  chunk.start = file_.size();
  chunk.compressed = size;
  chunk.uncompressed = chunk_.size();
  Record record(Opcode::kChunk);
  record.number(chunk.begin).number(chunk.end).number(chunk.uncompressed).number(crc_of(chunk_)).text("zstd");
  record.number(chunk.compressed).bytes(std::string_view(compressed_).substr(0, size));
  append(record.whole());
  chunk.size = file_.size() - chunk.start;
  const std::uint64_t indexes = file_.size();
  std::ranges::sort(chunk.indexes);
  for (auto& [channel, place] : chunk.indexes) {
    place = file_.size();
    auto& index = channels_[channel].index;
    Record record_of_index(Opcode::kMessageIndex);
    record_of_index.number(channel).entries([&] {
      for (const auto& [time, at] : index) record_of_index.number(time).number(at);
    });
    append(record_of_index.whole());
    index.clear();
  }
  chunk.index_size = file_.size() - indexes;
  chunks_.push_back(std::move(chunk));
  chunk_.clear();
}

void Writer::metadata(std::string_view name, const Texts& texts) {
  end_chunk();
  const std::uint64_t start = file_.size();
  append(Record(Opcode::kMetadata).text(name).texts(texts).whole());
  metadata_.push_back(Record(Opcode::kMetadataIndex).number(start).number(file_.size() - start).text(name).whole());
}

Status Writer::close() {
  end_chunk();
  append(Record(Opcode::kDataEnd).number(checksum_).whole());
  checksum_ = 0;
  const std::uint64_t summary = file_.size();

  std::string offsets;
  const auto group = [&](Opcode opcode, const std::vector<std::string>& records) {
    const std::uint64_t start = file_.size();
    for (const std::string& record : records) append(record);
    if (file_.size() > start)
      offsets += Record(Opcode::kSummaryOffset).number(opcode).number(start).number(file_.size() - start).whole();
  };
  group(Opcode::kSchema, schemas_);
  std::vector<std::string> channels, chunks;
  for (const Channel& channel : channels_) channels.push_back(channel.record);
  group(Opcode::kChannel, channels);
  Record statistics(Opcode::kStatistics);
  statistics.number(messages_).number(static_cast<std::uint16_t>(schemas_.size()));
  statistics.number(static_cast<std::uint32_t>(channels_.size())).number(std::uint32_t{0});
  statistics.number(static_cast<std::uint32_t>(metadata_.size())).number(static_cast<std::uint32_t>(chunks_.size()));
  statistics.number(first_).number(last_).entries([&] {
    for (std::size_t id = 0; id < channels_.size(); ++id)
      if (channels_[id].sent > 0)
        statistics.number(static_cast<ChannelId>(id)).number(std::uint64_t{channels_[id].sent});
  });
  group(Opcode::kStatistics, {statistics.whole()});
  for (const Chunk& chunk : chunks_) {
    Record record(Opcode::kChunkIndex);
    record.number(chunk.begin).number(chunk.end).number(chunk.start).number(chunk.size).entries([&] {
      for (const auto& [channel, place] : chunk.indexes) record.number(channel).number(place);
    });
    record.number(chunk.index_size).text("zstd").number(chunk.compressed).number(chunk.uncompressed);
    chunks.push_back(record.whole());
  }
  group(Opcode::kChunkIndex, chunks);
  group(Opcode::kMetadataIndex, metadata_);
  const std::uint64_t summary_offsets = file_.size();
  append(offsets);
  // The checksum of the summary covers the footer up to the checksum itself.
  std::string footer = Record(Opcode::kFooter).number(summary).number(summary_offsets).number(std::uint32_t{0}).whole();
  footer.resize(footer.size() - sizeof checksum_);
  append(footer);
  std::string end;
  ByteWriter(end).fixed(checksum_).raw({kMagic, kMagicSize});
  append(end);
  if (Status s = file_.close(); !s && status_) status_ = s;
  return status_;
}

}  // namespace cxlab::mcap
