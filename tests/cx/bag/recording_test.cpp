// Files of bags: in which order messages come, which files belong to a bag, and what is wrong with damaged ones.

#include "cx/bag/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include "cx/bag/bag_file.h"
#include "cx/base/byte_codec.h"
#include "cx/mcap/mcap_writer.h"
#include "cx/mcap/records.h"
#include "tests/support/files.h"

namespace cxlab::bag {

namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// An MCAP file by hand: records outside of chunks and in chunks, in any order of time.
class HandMadeMcap {
 public:
  HandMadeMcap() : bytes_(mcap::kMagic, mcap::kMagicSize) {
    record(bytes_, mcap::Opcode::kHeader, text("ros2") + text("hand"));
  }
  static std::string text(std::string_view value) {
    std::string out;
    ByteWriter(out).fixed(static_cast<std::uint32_t>(value.size())).raw(value);
    return out;
  }
  static void record(std::string& to, mcap::Opcode opcode, std::string_view content) {
    ByteWriter(to).fixed(opcode).fixed(std::uint64_t{content.size()}).raw(content);
  }
  static std::string channel(std::uint16_t id, std::string_view topic, std::string_view qos = "") {
    std::string content, out;
    const std::string metadata = qos.empty() ? "" : text("offered_qos_profiles") + text(qos);
    ByteWriter(content).fixed(id).fixed(std::uint16_t{0}).raw(text(topic)).raw(text("cdr")).raw(text(metadata));
    record(out, mcap::Opcode::kChannel, content);
    return out;
  }
  static std::string message(std::uint16_t channel, std::int64_t t, std::string_view bytes) {
    std::string content, out;
    ByteWriter(content).fixed(channel).fixed(std::uint32_t{0}).fixed(t).fixed(t).raw(bytes);
    record(out, mcap::Opcode::kMessage, content);
    return out;
  }
  HandMadeMcap& add(const std::string& records) {
    bytes_ += records;
    return *this;
  }
  HandMadeMcap& chunk(const std::string& records, std::uint32_t wrong = 0, std::string_view compression = "") {
    return packed_chunk(records, records, compression, wrong);
  }
  HandMadeMcap& packed_chunk(const std::string& records, const std::string& packed, std::string_view compression,
                             std::uint32_t wrong = 0) {
    std::string content;
    const auto crc =
        static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const unsigned char*>(records.data()), records.size()));
    ByteWriter(content)
        .fixed(std::uint64_t{0})
        .fixed(std::uint64_t{0})
        .fixed(std::uint64_t{records.size()})
        .fixed(crc + wrong)
        .raw(text(compression))
        .fixed(std::uint64_t{packed.size()})
        .raw(packed);
    record(bytes_, mcap::Opcode::kChunk, content);
    return *this;
  }
  std::string whole() const {
    std::string out = bytes_;
    record(out, mcap::Opcode::kDataEnd, std::string(4, '\0'));
    record(out, mcap::Opcode::kFooter, std::string(20, '\0'));
    return out + std::string(mcap::kMagic, mcap::kMagicSize);
  }
  const std::string& cut_off() const { return bytes_; }

 private:
  std::string bytes_;
};

using M = HandMadeMcap;

std::string zstd_frame(const std::string& plain) {
  std::string out(ZSTD_compressBound(plain.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), plain.data(), plain.size(), 3));
  return out;
}

std::string lz4_frame(const std::string& plain) {
  std::string out(LZ4F_compressFrameBound(plain.size(), nullptr), '\0');
  out.resize(LZ4F_compressFrame(out.data(), out.size(), plain.data(), plain.size(), nullptr));
  return out;
}

/// "topic:bytes" of each message, in the order in which they come.
std::vector<std::string> played(Recording& recording, std::vector<bool> topics = {}) {
  recording.begin(std::move(topics));
  std::vector<std::string> out;
  SimTime last{};
  while (true) {
    const auto message = recording.next();
    if (!message) {
      out.push_back(message.error().text());
      return out;
    }
    if (!*message) return out;
    EXPECT_GE((*message)->t, last);
    last = (*message)->t;
    out.push_back(recording.topics()[(*message)->topic].name + ':' + std::string((*message)->bytes));
  }
}

std::vector<std::string> played_from(const std::string& bytes) {
  auto recording = Recording::from_bytes(bytes, "hand.mcap");
  return recording ? played(*recording) : std::vector{recording.error().text()};
}

TEST(Recording, MessagesComeInOrderOfTimeWhateverTheFileHas) {
  const std::string channels = M::channel(1, "/a") + M::channel(2, "/b");
  // In one chunk, over chunks that overlap, outside of chunks, and between both.
  EXPECT_THAT(played_from(HandMadeMcap().add(channels).chunk(M::message(1, 3, "3") + M::message(2, 1, "1")).whole()),
              ElementsAre("/b:1", "/a:3"));
  EXPECT_THAT(played_from(HandMadeMcap()
                              .add(channels)
                              .chunk(M::message(1, 5, "5") + M::message(1, 20, "20"))
                              .chunk(M::message(1, 30, "30"))
                              .chunk(M::message(1, 10, "10") + M::message(1, 1, "1") + M::message(1, 20, "20b"))
                              .whole()),
              ElementsAre("/a:1", "/a:5", "/a:10", "/a:20", "/a:20b", "/a:30"));
  EXPECT_THAT(played_from(HandMadeMcap()
                              .add(channels + M::message(1, 7, "7") + M::message(2, 2, "2"))
                              .chunk(M::message(1, 4, "4"))
                              .add(M::message(2, 3, "3"))
                              .whole()),
              ElementsAre("/b:2", "/b:3", "/a:4", "/a:7"));
}

TEST(Recording, MessagesOfOneTimeComeInTheOrderOfTheFile) {
  EXPECT_THAT(played_from(HandMadeMcap()
                              .add(M::channel(1, "/a"))
                              .chunk(M::message(1, 20, "first"))
                              .chunk(M::message(1, 5, "5") + M::message(1, 20, "second"))
                              .whole()),
              ElementsAre("/a:5", "/a:first", "/a:second"));
}

TEST(Recording, ManyMessagesOutsideOfChunksAreReadInParts) {
  HandMadeMcap file;
  file.add(M::channel(1, "/a"));
  const std::string big(300'000, 'x');
  for (std::int64_t i = 0; i < 20; ++i) file.add(M::message(1, 100 - i, std::to_string(i) + big));
  const auto all = played_from(file.whole());
  ASSERT_EQ(all.size(), 20U);
  EXPECT_TRUE(all.front().starts_with("/a:19x"));
  EXPECT_TRUE(all.back().starts_with("/a:0x"));
}

TEST(Recording, OnlyWantedTopicsCome) {
  auto recording = Recording::from_bytes(HandMadeMcap()
                                             .add(M::channel(1, "/a") + M::channel(2, "/b"))
                                             .chunk(M::message(1, 1, "1") + M::message(2, 2, "2"))
                                             .chunk(M::message(1, 3, "3"))
                                             .whole(),
                                         "hand.mcap");
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->topics().size(), 2U);
  EXPECT_EQ(recording->topics()[0].messages, 2U);
  EXPECT_EQ(recording->messages(), 3U);
  EXPECT_EQ(recording->first(), SimTime(1));
  EXPECT_EQ(recording->last(), SimTime(3));
  EXPECT_THAT(played(*recording, {false, true}), ElementsAre("/b:2"));
  EXPECT_THAT(played(*recording, {true, false}), ElementsAre("/a:1", "/a:3"));
  EXPECT_THAT(played(*recording), ElementsAre("/a:1", "/b:2", "/a:3"));
}

TEST(Recording, KilledRecorderIsReadUpToItsLastWholeRecord) {
  const HandMadeMcap file =
      HandMadeMcap().add(M::channel(1, "/a")).chunk(M::message(1, 1, "1")).chunk(M::message(1, 2, "2"));
  for (const std::size_t missing : {std::size_t{0}, std::size_t{3}}) {
    const std::string bytes = file.cut_off().substr(0, file.cut_off().size() - missing);
    auto recording = Recording::from_bytes(bytes, "hand.mcap");
    ASSERT_TRUE(recording);
    EXPECT_EQ(played(*recording).size(), missing == 0 ? 2U : 1U);
    ASSERT_EQ(recording->warnings().size(), 1U);
    EXPECT_THAT(recording->warnings()[0], HasSubstr("hand.mcap: the file has no end"));
  }
  EXPECT_TRUE(Recording::from_bytes(file.whole(), "hand.mcap")->warnings().empty());
}

TEST(Recording, ChunksOfLz4AreRead) {
  std::string records = M::channel(1, "/a");
  for (int i = 0; i < 3; ++i) records += M::message(1, i, std::string(700'000, static_cast<char>('a' + i)));
  auto recording =
      Recording::from_bytes(HandMadeMcap().packed_chunk(records, lz4_frame(records), "lz4").whole(), "hand.mcap");
  ASSERT_TRUE(recording) << recording.error().text();
  const auto messages = played(*recording);
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[2], "/a:" + std::string(700'000, 'c'));
}

TEST(Recording, DamageIsFoundBeforeItIsPlayed) {
  const auto error = [](const std::string& bytes) {
    const auto recording = Recording::from_bytes(bytes, "hand.mcap");
    return recording ? std::string("none") : recording.error().text();
  };
  const std::string one = M::channel(1, "/a") + M::message(1, 1, "1");
  EXPECT_THAT(error(""), HasSubstr("hand.mcap: the file does not begin with the bytes of an MCAP file"));
  EXPECT_THAT(error(HandMadeMcap().chunk(one, 1).whole()),
              HasSubstr("hand.mcap: the record at byte 33: the checksum of the chunk is not that of its bytes"));
  EXPECT_THAT(error(HandMadeMcap().chunk(one, 0, "bz2").whole()),
              HasSubstr("the chunk is compressed with 'bz2', expected zstd, lz4 or nothing: mcap compress"));
  EXPECT_THAT(error(HandMadeMcap().chunk(one, 0, "lz4").whole()), HasSubstr("the chunk cannot be unpacked: ERROR"));
  EXPECT_THAT(error(HandMadeMcap().packed_chunk(one, lz4_frame(one + one), "lz4").whole()),
              HasSubstr("the chunk is no lz4 of " + std::to_string(one.size()) + " bytes"));
  EXPECT_THAT(error(HandMadeMcap().packed_chunk(one + one, lz4_frame(one), "lz4").whole()),
              HasSubstr("the chunk has " + std::to_string(one.size()) + " bytes, expected "));
  const std::string cut = lz4_frame(one).substr(0, lz4_frame(one).size() / 2);
  EXPECT_THAT(error(HandMadeMcap().packed_chunk(one, cut, "lz4").whole()), HasSubstr("the chunk is no lz4 of "));
  EXPECT_THAT(error(HandMadeMcap().chunk(one, 0, "zstd").whole()), HasSubstr("the chunk is no zstd of "));
  EXPECT_THAT(error(HandMadeMcap().add(M::message(7, 1, "1")).whole()),
              HasSubstr("a message names channel 7, which did not come before"));
  EXPECT_THAT(error(HandMadeMcap().add(M::channel(1, "/a") + M::message(1, -1, "1")).whole()),
              HasSubstr("after the year 2262"));
  std::string huge = HandMadeMcap().cut_off();
  ByteWriter(huge).fixed(mcap::Opcode::kChunk).fixed(std::uint64_t{1} << 62);
  EXPECT_EQ(error(huge), "none") << "a record that is longer than the file is its end";
}

TEST(Recording, ErrorsNameTopicTimeAndPlace) {
  auto recording =
      Recording::from_bytes(HandMadeMcap()
                                .add(M::channel(1, "/a"))
                                .chunk(M::message(1, 1'000'000'000, "1") + M::message(1, 3'500'000'000, "2"))
                                .whole(),
                            "hand.mcap");
  ASSERT_TRUE(recording);
  recording->begin({});
  ASSERT_TRUE(recording->next());
  const auto second = recording->next();
  ASSERT_TRUE(second && *second);
  EXPECT_THAT(recording->at(**second, input_error("no")).text(),
              ::testing::MatchesRegex("hand.mcap: the message of /a at 2.5 s \\(byte [0-9]+\\): no"));
}

TEST(QosProfiles, KeepTheLastMessageWhereTheirDurabilityIsTransientLocal) {
  for (const char* kept :
       {"durability: 1", "- depth: 1\n  durability: 1\n  deadline: 0\n", "durability: transient_local",
        "- durability: volatile\n- durability:   transient_local\n", "- durability: 2\n- durability: 1"})
    EXPECT_TRUE(keeps_last(kept)) << kept;
  for (const char* not_kept : {"", "durability:", "durability: ", "durability: 2", "durability: 10",
                               "durability: volatile", "- history: 1\n  durability: 2\n  depth: 1\n"})
    EXPECT_FALSE(keeps_last(not_kept)) << not_kept;
}

class BagFolder : public testing::Test {
 protected:
  static std::string bag(std::int64_t t) {
    return HandMadeMcap().add(M::channel(1, "/a")).chunk(M::message(1, t, std::to_string(t))).whole();
  }
  std::vector<std::string> all() const {
    auto recording = Recording::open(folder_.path() / "floor");
    return recording ? played(*recording) : std::vector{recording.error().text()};
  }
  std::string file(const char* name) const { return (folder_.path() / "floor" / name).string(); }
  TempFolder folder_;
};

TEST_F(BagFolder, IsOneBagInTheOrderOfTime) {
  folder_.write("floor/floor_10.mcap", bag(30));
  folder_.write("floor/floor_9.mcap", bag(20));
  folder_.write("floor/floor_0.mcap", bag(10));
  folder_.write("floor/notes.txt", "not of the bag");
  EXPECT_THAT(all(), ElementsAre("/a:10", "/a:20", "/a:30"));
  auto recording = Recording::open(folder_.path() / "floor/");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->name(), "floor");
  EXPECT_EQ(recording->topics().size(), 1U) << "one topic, whatever the number of files";
}

TEST_F(BagFolder, MessagesOfOneTimeComeInTheOrderOfTheFiles) {
  for (const int number : {10, 9, 0}) {
    const std::string name = std::to_string(number);
    folder_.write("floor/floor_" + name + ".mcap",
                  HandMadeMcap()
                      .add(M::channel(1, "/a"))
                      .chunk(M::message(1, 5, name) + M::message(1, 10 + number, name) + M::message(1, 30, name))
                      .whole());
  }
  EXPECT_THAT(all(), ElementsAre("/a:0", "/a:9", "/a:10", "/a:0", "/a:9", "/a:10", "/a:0", "/a:9", "/a:10"));
}

TEST_F(BagFolder, ATopicKeepsItsLastMessageIfItDoesInOneOfTheFiles) {
  for (const int kept : {0, 1, 2, 3}) {
    for (const int file : {0, 1, 2})
      folder_.write("floor/floor_" + std::to_string(file) + ".mcap",
                    HandMadeMcap()
                        .add(M::channel(1, "/a", file == kept ? "durability: 1" : "durability: 2"))
                        .chunk(M::message(1, 10, "x"))
                        .whole());
    auto recording = Recording::open(folder_.path() / "floor");
    ASSERT_TRUE(recording);
    ASSERT_EQ(recording->topics().size(), 1U);
    EXPECT_EQ(recording->topics().front().latched, kept < 3) << "file " << kept;
  }
}

TEST_F(BagFolder, HasTheFilesThatItsMetadataNames) {
  folder_.write("floor/a.mcap", bag(30));
  folder_.write("floor/b.mcap", bag(20));
  folder_.write("floor/c.mcap", bag(10));
  folder_.write("floor/metadata.yaml",
                "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  relative_file_paths:\n"
                "    - a.mcap\n    - b.mcap\n  compression_format: ''\n  compression_mode: ''\n");
  EXPECT_THAT(all(), ElementsAre("/a:20", "/a:30"));
}

TEST_F(BagFolder, WholeFilesMayBeCompressed) {
  folder_.write("floor/floor_0.mcap.zstd", zstd_frame(bag(20)));
  const std::string two = zstd_frame(bag(10).substr(0, 40)) + zstd_frame(bag(10).substr(40));
  folder_.write("floor/floor_1.mcap.zstd", two);
  // As many bytes as a buffer of the decoder has: nothing is left when it is full.
  for (const std::size_t size : {ZSTD_DStreamOutSize(), 2 * ZSTD_DStreamOutSize()}) {
    HandMadeMcap exact = HandMadeMcap().add(M::channel(1, "/a"));
    const std::size_t rest = exact.whole().size() + M::message(1, 5, "").size();
    exact.add(M::message(1, 5, std::string(size - rest, 'x')));
    ASSERT_EQ(exact.whole().size(), size);
    folder_.write("exact/exact_0.mcap.zstd", zstd_frame(exact.whole()));
    EXPECT_TRUE(Recording::open(folder_.path() / "exact")) << size;
  }
  EXPECT_THAT(all(), ElementsAre("/a:10", "/a:20"));
  auto recording = Recording::open(folder_.path() / "floor");
  recording->begin({});
  const auto first = recording->next();
  ASSERT_TRUE(first && *first);
  EXPECT_THAT(recording->at(**first, input_error("no")).text(),
              StartsWith(file("floor_1.mcap.zstd") + ": the message"));
}

TEST_F(BagFolder, MessagesMayBeCompressed) {
  const auto packed = [&](const std::string& bytes) {
    return HandMadeMcap().add(M::channel(1, "/a")).chunk(M::message(1, 5, bytes)).whole();
  };
  folder_.write("floor/metadata.yaml",
                "rosbag2_bagfile_information:\n  relative_file_paths: [a.mcap, b.mcap]\n"
                "  compression_format: zstd\n  compression_mode: MESSAGE\n");
  const std::string big(100'000, 'b');
  folder_.write("floor/a.mcap", packed(zstd_frame("one")));
  folder_.write("floor/b.mcap", packed(zstd_frame(big)));
  EXPECT_THAT(all(), ElementsAre("/a:one", "/a:" + big));
  folder_.write("floor/b.mcap", packed("plain"));
  EXPECT_THAT(all()[0], HasSubstr("b.mcap: the compressed message (byte "));
  EXPECT_THAT(all()[0], HasSubstr(") cannot be unpacked: found no zstd"));
}

TEST_F(BagFolder, WhatCannotBeReadHasARemedy) {
  EXPECT_THAT(all(), ElementsAre((folder_.path() / "floor").string() + ": there is no such file or folder"));
  folder_.write("floor/notes.txt", "");
  EXPECT_THAT(all()[0], HasSubstr("no file of a bag is in this folder, expected those of ros2 bag record"));
  folder_.write("floor/floor_0.mcap.zstd", "not zstd");
  EXPECT_THAT(all(), ElementsAre(file("floor_0.mcap.zstd") +
                                 ": the compressed file cannot be unpacked: Unknown frame descriptor"));
  const std::string packed = zstd_frame(bag(10));
  folder_.write("floor/floor_0.mcap.zstd", packed.substr(0, packed.size() - 1));
  EXPECT_THAT(all(),
              ElementsAre(file("floor_0.mcap.zstd") + ": the compressed file cannot be unpacked: it ends too early"));
  folder_.write("floor/floor_0.mcap.zstd", zstd_frame("no bag"));
  EXPECT_THAT(all()[0], StartsWith(file("floor_0.mcap.zstd") + ": the file does not begin with the bytes of an MCAP"));
  const std::string head = "rosbag2_bagfile_information:\n  relative_file_paths: ";
  folder_.write("floor/metadata.yaml", head + "[../secret.mcap]\n");
  EXPECT_THAT(all()[0], HasSubstr("metadata.yaml:2: "));
  EXPECT_THAT(all()[0], HasSubstr("found '../secret.mcap', expected the name of a file in this folder"));
  folder_.write("floor/metadata.yaml", head + "[a.mcap]\n  compression_format: lzma\n  compression_mode: MESSAGE\n");
  EXPECT_THAT(all()[0],
              HasSubstr("found the compression 'lzma', expected zstd: rewrite the bag with ros2 bag convert"));
  folder_.write("floor/metadata.yaml", head + "[gone.mcap]\n");
  EXPECT_THAT(all(), ElementsAre(file("gone.mcap") + ": the file cannot be read"));
}

TEST_F(BagFolder, DigestIsThatOfTheBytes) {
  folder_.write("floor/floor_0.mcap", bag(10));
  folder_.write("floor/floor_1.mcap", bag(20));
  const auto digest = [this] { return *digest_of(folder_.path() / "floor"); };
  const std::string before = digest();
  EXPECT_EQ(before.size(), 32U);
  EXPECT_EQ(digest(), before);
  folder_.write("floor/floor_1.mcap", bag(21));
  EXPECT_NE(digest(), before);
  EXPECT_FALSE(digest_of(folder_.path() / "none"));
}

class SqliteBag : public BagFolder {
 protected:
  void write(const std::string& sql) {
    std::filesystem::create_directories(folder_.path() / "floor");
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file("floor_0.db3").c_str(), &database), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
  static constexpr const char* kTables =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT "
      "NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT "
      "NULL);"
      "INSERT INTO topics VALUES(3, '/a', 'std_msgs/msg/String', 'cdr', '- durability: 1\n'),"
      " (4, '/b', 'std_msgs/msg/String', 'cdr', '');";
};

TEST_F(SqliteBag, IsReadInOrderOfTime) {
  write(std::string(kTables) + "INSERT INTO messages VALUES(1, 3, 20, x'78'), (2, 4, 10, x'79'), (3, 3, 20, x'7a');");
  EXPECT_THAT(all(), ElementsAre("/b:y", "/a:x", "/a:z"));
  auto recording = Recording::open(file("floor_0.db3"));
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->topics()[0].type, "std_msgs/msg/String");
  EXPECT_TRUE(recording->topics()[0].latched);
  EXPECT_FALSE(recording->topics()[1].latched);
  EXPECT_THAT(played(*recording, {true, false}), ElementsAre("/a:x", "/a:z"));
  EXPECT_THAT(played(*recording, {true, false}), ElementsAre("/a:x", "/a:z")) << "from the start again";
}

TEST_F(SqliteBag, HasDefinitions) {
  write(std::string(kTables) +
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, "
        "encoded_message_definition TEXT, type_description_hash TEXT);"
        "INSERT INTO message_definitions VALUES(1, 'std_msgs/msg/String', 'ros2msg', 'string data', '');"
        "INSERT INTO messages VALUES(1, 3, 20, x'78');");
  auto recording = Recording::open(file("floor_0.db3"));
  ASSERT_TRUE(recording) << recording.error().text();
  EXPECT_EQ(recording->topics()[0].definition, "string data");
}

TEST_F(SqliteBag, DamageIsFoundBeforeItIsPlayed) {
  write(std::string(kTables) + "INSERT INTO messages VALUES(7, 9, 20, x'78');");
  EXPECT_THAT(all(), ElementsAre(file("floor_0.db3") +
                                 ": row 7 of the table messages: found topic 9, expected one of the table topics"));
  folder_.write("floor/floor_0.db3", "no database");
  EXPECT_THAT(all()[0], HasSubstr("floor_0.db3: the file cannot be read as a bag of SQLite: "));
  std::filesystem::remove(file("floor_0.db3"));
  write("CREATE TABLE other(a)");
  EXPECT_THAT(all()[0], HasSubstr("no such table: topics"));
}

}  // namespace

}  // namespace cxlab::bag
