// What the writer writes is read again, and its structure is checked byte by byte: places, lengths and checksums.

#include <gtest/gtest.h>
#include <zlib.h>

#include <set>

#include "cx/base/byte_codec.h"
#include "cx/mcap/mcap_reader.h"
#include "cx/mcap/mcap_writer.h"
#include "cx/mcap/records.h"
#include "tests/support/files.h"

namespace cxlab::mcap {

namespace {

constexpr SimTime kSecond = std::chrono::seconds(1);

std::uint32_t crc(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

class McapTest : public testing::Test {
 protected:
  /// A file of several chunks: 3000 messages of 1000 bytes on two channels.
  std::string written(const std::string& name = "a.mcap") {
    auto file = Writer::create(folder_.path() / name, "ros2", "test 1");
    EXPECT_TRUE(file);
    file->metadata("about", {{"b", "2"}, {"a", "1"}});
    const SchemaId text = file->schema("p/msg/T", "string data\n");
    EXPECT_EQ(file->schema("p/msg/T", "string data\n"), text);
    EXPECT_NE(file->schema("p/msg/T", "string other\n"), text);
    const ChannelId one = file->channel("/one", text), two = file->channel("/two", text, {{"k", "v"}});
    for (int i = 0; i < 3000; ++i)
      file->message(i % 3 == 0 ? two : one, i * kSecond, std::string(1000, static_cast<char>('a' + i % 26)));
    EXPECT_EQ(file->messages(), 3000U);
    EXPECT_TRUE(file->close());
    return content_of(folder_.path() / name);
  }
  TempFolder folder_;
};

/// Records from `at` to `end`: opcode, where each begins, and its content.
struct Found {
  Opcode opcode{};
  std::size_t at = 0;
  std::string_view content;
};
std::vector<Found> records_in(std::string_view bytes, std::size_t at, std::size_t end) {
  std::vector<Found> out;
  while (at < end) {
    ByteReader in(bytes.substr(at));
    const auto opcode = in.fixed<Opcode>();
    const auto content = in.raw(in.fixed<std::uint64_t>());
    EXPECT_TRUE(in.ok());
    out.push_back({opcode, at, content});
    at += in.position();
  }
  EXPECT_EQ(at, end);
  return out;
}

TEST_F(McapTest, IsReadAsItWasWritten) {
  auto file = Reader::from_bytes(written(), "a.mcap");
  ASSERT_TRUE(file);
  for (int i = 0; i < 3000; ++i) {
    const auto message = file->next();
    ASSERT_TRUE(message) << message.error().text();
    ASSERT_TRUE(*message);
    EXPECT_EQ((*message)->t, i * kSecond);
    EXPECT_EQ((*message)->channel->topic, i % 3 == 0 ? "/two" : "/one");
    EXPECT_EQ((*message)->channel->message_encoding, "cdr");
    EXPECT_EQ((*message)->channel->schema->name, "p/msg/T");
    EXPECT_EQ((*message)->channel->schema->text, "string data\n");
    EXPECT_EQ((*message)->sequence, static_cast<std::uint32_t>(i % 3 == 0 ? i / 3 : i - i / 3 - 1));
    EXPECT_EQ((*message)->bytes, std::string(1000, static_cast<char>('a' + i % 26)));
  }
  const auto end = file->next();
  EXPECT_TRUE(end && !*end);
  EXPECT_FALSE(file->cut_off());
}

TEST_F(McapTest, TheSameCallsGiveTheSameBytes) { EXPECT_EQ(written("a.mcap"), written("b.mcap")); }

TEST_F(McapTest, PlacesAndChecksumsAreThoseOfTheFile) {
  const std::string bytes = written();
  const std::string_view magic(kMagic, kMagicSize), all = bytes;
  ASSERT_TRUE(all.starts_with(magic) && all.ends_with(magic));
  const auto records = records_in(all, kMagicSize, all.size() - kMagicSize);
  const auto first_of = [&](Opcode opcode) {
    for (const Found& record : records)
      if (record.opcode == opcode) return record;
    ADD_FAILURE();
    return Found{};
  };
  const Found data_end = first_of(Opcode::kDataEnd), footer = first_of(Opcode::kFooter);
  EXPECT_EQ(ByteReader(data_end.content).fixed<std::uint32_t>(), crc(all.substr(0, data_end.at)));
  ByteReader foot(footer.content);
  const auto summary = foot.fixed<std::uint64_t>(), offsets = foot.fixed<std::uint64_t>();
  EXPECT_EQ(summary, data_end.at + 9 + 4);
  EXPECT_EQ(foot.fixed<std::uint32_t>(), crc(all.substr(summary, footer.at + 9 + 16 - summary)));

  // Each chunk, and the indexes behind it, are where the chunk index says.
  std::size_t chunks = 0, indexed = 0;
  for (const Found& record : records) {
    if (record.opcode != Opcode::kChunkIndex) continue;
    ++chunks;
    ByteReader in(record.content);
    const auto begin = in.fixed<std::uint64_t>(), end = in.fixed<std::uint64_t>(), at = in.fixed<std::uint64_t>(),
               size = in.fixed<std::uint64_t>();
    ByteReader places(in.raw(in.fixed<std::uint32_t>()));
    const auto index_size = in.fixed<std::uint64_t>();
    const auto chunk = records_in(all, at, at + size);
    ASSERT_EQ(chunk.size(), 1U);
    EXPECT_EQ(chunk[0].opcode, Opcode::kChunk);
    ByteReader head(chunk[0].content);
    EXPECT_EQ(head.fixed<std::uint64_t>(), begin);
    EXPECT_EQ(head.fixed<std::uint64_t>(), end);
    std::set<std::uint64_t> times;
    for (const Found& index : records_in(all, at + size, at + size + index_size)) {
      const auto channel = places.fixed<std::uint16_t>();
      EXPECT_EQ(places.fixed<std::uint64_t>(), index.at);
      ByteReader entries(index.content);
      EXPECT_EQ(entries.fixed<std::uint16_t>(), channel);
      ByteReader entry(entries.raw(entries.fixed<std::uint32_t>()));
      for (; entry.left() > 0; ++indexed) {
        times.insert(entry.fixed<std::uint64_t>());
        EXPECT_LT(entry.fixed<std::uint64_t>(), std::uint64_t{2} << 20);
      }
    }
    EXPECT_EQ(places.left(), 0U);
    EXPECT_EQ(*times.begin(), begin);
    EXPECT_EQ(*times.rbegin(), end);
  }
  EXPECT_EQ(indexed, 3000U);
  EXPECT_GE(chunks, 3U);

  ByteReader statistics(first_of(Opcode::kStatistics).content);
  EXPECT_EQ(statistics.fixed<std::uint64_t>(), 3000U);
  EXPECT_EQ(statistics.fixed<std::uint16_t>(), 2U);
  EXPECT_EQ(statistics.fixed<std::uint32_t>(), 2U);
  EXPECT_EQ(statistics.fixed<std::uint32_t>(), 0U);
  EXPECT_EQ(statistics.fixed<std::uint32_t>(), 1U);
  EXPECT_EQ(statistics.fixed<std::uint32_t>(), chunks);
  EXPECT_EQ(statistics.fixed<std::uint64_t>(), 0U);
  EXPECT_EQ(statistics.fixed<std::uint64_t>(), 2999'000'000'000U);

  // The groups of the summary.
  for (const Found& record : records_in(all, offsets, footer.at)) {
    ByteReader in(record.content);
    const auto opcode = in.fixed<Opcode>();
    const auto at = in.fixed<std::uint64_t>(), size = in.fixed<std::uint64_t>();
    for (const Found& one : records_in(all, at, at + size)) EXPECT_EQ(one.opcode, opcode);
  }
}

TEST_F(McapTest, TimesOfFileAndChunkAreTheFirstAndLastOfTheirMessagesInAnyOrder) {
  auto file = Writer::create(folder_.path() / "mixed.mcap", "ros2", "test 1");
  ASSERT_TRUE(file);
  const ChannelId channel = file->channel("/one", file->schema("p/msg/T", "string data\n"));
  for (const int t : {5, 2, 9, 4}) file->message(channel, t * kSecond, "x");
  ASSERT_TRUE(file->close());
  const std::string bytes = content_of(folder_.path() / "mixed.mcap");
  for (const Found& record : records_in(bytes, kMagicSize, bytes.size() - kMagicSize)) {
    ByteReader in(record.content);
    if (record.opcode == Opcode::kStatistics)
      in.raw(8 + 2 + 4 * 4);
    else if (record.opcode != Opcode::kChunkIndex)
      continue;
    EXPECT_EQ(in.fixed<std::uint64_t>(), 2'000'000'000U);
    EXPECT_EQ(in.fixed<std::uint64_t>(), 9'000'000'000U);
  }
}

TEST_F(McapTest, CutOffFileIsReadUpToThere) {
  const std::string bytes = written();
  for (const std::size_t size : {std::size_t{8}, std::size_t{60}, bytes.size() / 2, bytes.size() - 9}) {
    auto file = Reader::from_bytes(bytes.substr(0, size), "a.mcap");
    ASSERT_TRUE(file);
    int messages = 0;
    for (;;) {
      const auto message = file->next();
      ASSERT_TRUE(message) << size << ": " << message.error().text();
      if (!*message) break;
      ++messages;
    }
    EXPECT_EQ(file->cut_off(), size + 9 < bytes.size()) << size;
    EXPECT_EQ(messages, size + 9 == bytes.size() ? 3000 : messages);
  }
}

TEST_F(McapTest, ChangedByteOfAChunkIsFound) {
  std::string bytes = written();
  const auto records = records_in(bytes, kMagicSize, bytes.size() - kMagicSize);
  for (const Found& record : records)
    if (record.opcode == Opcode::kChunk) {
      bytes[record.at + 9 + record.content.size() - 1] ^= 1;
      break;
    }
  auto file = Reader::from_bytes(bytes, "a.mcap");
  ASSERT_TRUE(file);
  for (;;) {
    const auto message = file->next();
    if (!message) {
      EXPECT_NE(message.error().message.find("the record at byte "), std::string::npos);
      EXPECT_EQ(message.error().file, "a.mcap");
      return;
    }
    ASSERT_TRUE(*message) << "nothing was found";
  }
}

TEST_F(McapTest, OtherFileIsRefused) {
  const auto file = Reader::from_bytes("#ROSBAG V2.0\n", "old.bag");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().text(),
            "old.bag: the file does not begin with the bytes of an MCAP file, 89 4d 43 41 50 30 0d 0a");
  EXPECT_FALSE(Reader::open(folder_.path()));
  EXPECT_FALSE(Reader::open(folder_.path() / "none.mcap"));
}

}  // namespace

}  // namespace cxlab::mcap
