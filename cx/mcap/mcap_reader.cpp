#include "cx/mcap/mcap_reader.h"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <sstream>

#include "cx/mcap/records.h"

namespace cxlab::mcap {

namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;  // of a record, or of a chunk that is unpacked
constexpr std::size_t kRecordHead = 9;

std::string_view text_of_record(ByteReader& in) { return in.raw(in.fixed<std::uint32_t>()); }

}  // namespace

Expected<Reader> Reader::open(const std::filesystem::path& path) {
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = *file ? static_cast<std::streamoff>(file->tellg()) : -1;
  if (size < 0 || !std::filesystem::is_regular_file(path)) return input_error("the file cannot be read", path.string());
  file->seekg(0);
  return begin(Reader(path.string(), std::move(file), static_cast<std::uint64_t>(size)));
}

Expected<Reader> Reader::from_bytes(std::string bytes, const std::string& name) {
  const std::uint64_t size = bytes.size();
  return begin(Reader(name, std::make_unique<std::istringstream>(std::move(bytes)), size));
}

Expected<Reader> Reader::begin(Reader reader) {
  char magic[kMagicSize] = {};
  reader.in_->read(magic, kMagicSize);
  if (!*reader.in_ || std::string_view(magic, kMagicSize) != std::string_view(kMagic, kMagicSize))
    return input_error("the file does not begin with the bytes of an MCAP file, 89 4d 43 41 50 30 0d 0a", reader.name_);
  reader.at_ = kMagicSize;
  return reader;
}

Error Reader::broken(const std::string& what) const {
  return input_error("the record at byte " + std::to_string(record_start_) + ": " + what, name_);
}

Expected<bool> Reader::read_record() {
  record_start_ = at_;
  const std::uint64_t left = size_ - at_;
  char head[kRecordHead];
  if (left < kRecordHead || !in_->read(head, kRecordHead)) {
    cut_off_ = true;
    return false;
  }
  ByteReader in(std::string_view(head, kRecordHead));
  opcode_ = in.fixed<std::uint8_t>();
  const auto size = in.fixed<std::uint64_t>();
  if (size > left - kRecordHead) {
    cut_off_ = true;
    return false;
  }
  if (size > kMostBytes)
    return broken(found_expected(std::to_string(size) + " bytes", "at most " + std::to_string(kMostBytes)));
  content_.resize(size);
  in_->read(content_.data(), static_cast<std::streamsize>(size));
  if (!*in_) return broken("the file cannot be read");
  at_ += kRecordHead + size;
  return true;
}

Status Reader::take_schema(ByteReader content) {
  const auto id = content.fixed<std::uint16_t>();
  Schema schema;
  schema.name = text_of_record(content);
  schema.encoding = text_of_record(content);
  schema.text = text_of_record(content);
  if (!content.ok() || id == 0) return broken("the schema is malformed");
  schemas_.emplace(id, std::move(schema));
  return {};
}

Status Reader::take_channel(ByteReader content) {
  const auto id = content.fixed<std::uint16_t>();
  const auto schema = content.fixed<std::uint16_t>();
  Channel channel;
  channel.topic = text_of_record(content);
  channel.message_encoding = text_of_record(content);
  ByteReader texts(text_of_record(content));
  while (content.ok() && texts.left() > 0) {
    const std::string key(text_of_record(texts));
    channel.metadata[key] = text_of_record(texts);
    if (!texts.ok()) content.refuse();
  }
  if (!content.ok()) return broken("the channel is malformed");
  if (schema != 0) {
    const auto known = schemas_.find(schema);
    if (known == schemas_.end())
      return broken("the channel of " + channel.topic + " names schema " + std::to_string(schema) +
                    ", which did not come before");
    channel.schema = &known->second;
  }
  channels_.emplace(id, std::move(channel));
  return {};
}

Status Reader::unpack_zstd(std::string_view packed, std::size_t size) {
  // A size that is a lie asks for memory only where the frame tells the same one, or none.
  const unsigned long long told = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (told == ZSTD_CONTENTSIZE_ERROR || (told != ZSTD_CONTENTSIZE_UNKNOWN && told > size))
    return broken("the chunk is no zstd of " + std::to_string(size) + " bytes");
  chunk_.resize(size);
  const std::size_t found = ZSTD_decompress(chunk_.data(), chunk_.size(), packed.data(), packed.size());
  if (ZSTD_isError(found)) return broken(std::string("the chunk cannot be unpacked: ") + ZSTD_getErrorName(found));
  chunk_.resize(found);
  return {};
}

Status Reader::unpack_lz4(std::string_view packed, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)))
    return resource_error("no memory to unpack a chunk of lz4");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owned(context,
                                                                                   &LZ4F_freeDecompressionContext);
  // The frame need not tell its size, so memory grows with what comes out, as far as the chunk says.
  chunk_.clear();
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  while (true) {
    const std::size_t filled = chunk_.size();
    chunk_.resize(std::min(size, filled + kPiece));
    std::size_t made = chunk_.size() - filled, taken = packed.size();
    const std::size_t left = LZ4F_decompress(context, chunk_.data() + filled, &made, packed.data(), &taken, nullptr);
    if (LZ4F_isError(left)) return broken(std::string("the chunk cannot be unpacked: ") + LZ4F_getErrorName(left));
    chunk_.resize(filled + made);
    packed.remove_prefix(taken);
    if (left == 0) return {};
    if (made == 0 && taken == 0) return broken("the chunk is no lz4 of " + std::to_string(size) + " bytes");
  }
}

Status Reader::take_chunk(ByteReader content) {
  content.fixed<std::uint64_t>();
  content.fixed<std::uint64_t>();
  const auto size = content.fixed<std::uint64_t>();
  const auto checksum = content.fixed<std::uint32_t>();
  const std::string_view compression = text_of_record(content);
  const std::string_view records = content.raw(content.fixed<std::uint64_t>());
  if (!content.ok()) return broken("the chunk is malformed");
  if (size > kMostBytes)
    return broken("the chunk has " + std::to_string(size) + " bytes, expected at most " + std::to_string(kMostBytes));
  chunk_at_ = 0;
  if (compression.empty()) {
    chunk_ = records;
  } else if (compression == "zstd") {
    if (Status s = unpack_zstd(records, size); !s) return s;
  } else if (compression == "lz4") {
    if (Status s = unpack_lz4(records, size); !s) return s;
  } else {
    return broken("the chunk is compressed with '" + std::string(compression.substr(0, 40)) +
                  "', expected zstd, lz4 or nothing: mcap compress --compression zstd converts it");
  }
  if (chunk_.size() != size)
    return broken("the chunk has " + std::to_string(chunk_.size()) + " bytes, expected " + std::to_string(size));
  const auto found =
      static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const unsigned char*>(chunk_.data()), chunk_.size()));
  if (checksum != 0 && checksum != found) return broken("the checksum of the chunk is not that of its bytes");
  return {};
}

Expected<ReadMessage> Reader::message_of(ByteReader content) const {
  const auto id = content.fixed<std::uint16_t>();
  ReadMessage out;
  out.sequence = content.fixed<std::uint32_t>();
  const auto time = content.fixed<std::uint64_t>();
  content.fixed<std::uint64_t>();
  if (!content.ok()) return broken("the message is malformed");
  const auto known = channels_.find(id);
  if (known == channels_.end())
    return broken("a message names channel " + std::to_string(id) + ", which did not come before");
  if (time > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    return broken("a message of " + known->second.topic + " has the time " + std::to_string(time) +
                  " ns, after the year 2262");
  out.channel = &known->second;
  out.t = SimTime(static_cast<std::int64_t>(time));
  out.bytes = content.raw(content.left());
  out.place = record_start_;
  return out;
}

void Reader::go_to(std::uint64_t place) {
  in_->clear();
  in_->seekg(static_cast<std::streamoff>(place));
  at_ = place;
  chunk_.clear();
  chunk_at_ = 0;
  ended_ = false;
}

Expected<std::optional<ReadMessage>> Reader::next() {
  while (!ended_) {
    const bool in_chunk = chunk_at_ < chunk_.size();
    std::uint8_t opcode = 0;
    std::string_view content;
    if (in_chunk) {
      ByteReader in(std::string_view(chunk_).substr(chunk_at_));
      opcode = in.fixed<std::uint8_t>();
      content = in.raw(in.fixed<std::uint64_t>());
      if (!in.ok()) {
        ended_ = true;
        return broken("a record within the chunk is longer than the chunk");
      }
      chunk_at_ += in.position();
    } else {
      const auto more = read_record();
      if (!more || !*more) {
        ended_ = true;
        if (!more) return more.error();
        break;
      }
      opcode = opcode_;
      content = content_;
    }
    Status status;
    switch (static_cast<Opcode>(opcode)) {
      case Opcode::kSchema: status = take_schema(ByteReader(content)); break;
      case Opcode::kChannel: status = take_channel(ByteReader(content)); break;
      case Opcode::kMessage: {
        auto message = message_of(ByteReader(content));
        if (message) {
          message->in_chunk = in_chunk;
          return std::optional(*message);
        }
        status = message.error();
        break;
      }
      case Opcode::kChunk:
        status = in_chunk ? Status(broken("found a chunk within a chunk")) : take_chunk(ByteReader(content));
        break;
      case Opcode::kDataEnd:
      case Opcode::kFooter: ended_ = true; break;
      default: break;  // indexes and what later versions add
    }
    if (!status) {
      ended_ = true;
      return status.error();
    }
  }
  return std::optional<ReadMessage>();
}

}  // namespace cxlab::mcap
