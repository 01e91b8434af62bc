#include "cx/protobuf/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::pb {
namespace {

using ::testing::HasSubstr;

constexpr MessageKey kKey{2000, 101};

std::string hex(std::string_view bytes) {
  std::string out;
  for (const char c : bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    out += kDigits[byte / 16];
    out += kDigits[byte % 16];
  }
  return out;
}

std::unique_ptr<Crypto> crypto(const std::string& name, const std::string& key = "randomkey") {
  return *Crypto::create(*cipher_of(name), key);
}

std::string message_of(const Expected<Frame>& frame) { return frame ? "a frame" : frame.error().message; }

TEST(Wire, AFrameHasTwoHeaders) {
  EXPECT_EQ(hex(write_frame({2000, 20}, "ab")),
            "0200000000000006"
            "07d00014"
            "6162");
  const auto frame = read_datagram(write_frame(kKey, "content"));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->key, kKey);
  EXPECT_EQ(frame->content, "content");
}

// Made with the command line of OpenSSL and Python's hashlib from the description of the format.
TEST(Wire, EncryptedFramesAreThoseOfOtherPrograms) {
  EXPECT_EQ(hex(write_frame(kKey, "content", crypto("aes-128-ecb").get())),
            "020100000000001009b5491d78c5c43b8d84b8bca9a25497");
  EXPECT_EQ(hex(write_frame(kKey, "content", crypto("aes-128-cbc").get())),
            "0202000000000020cd2662154e6d76b2b2b92e70c0cac3cc12ec8941b91d67843416e9d56c8800ff");
  EXPECT_EQ(hex(write_frame(kKey, "content", crypto("aes-256-ecb").get())),
            "02030000000000104571f3804425aae5d9a14e236274ab27");
  EXPECT_EQ(hex(write_frame(kKey, "content", crypto("aes-256-cbc").get())),
            "0204000000000020cd2662154e6d76b2b2b92e70c0cac3cce1f38a55d240f73fb2e795deec22fc23");
}

TEST(Wire, AllCiphersComeBack) {
  for (const std::string name : {"aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"}) {
    const auto mine = crypto(name), theirs = crypto(name);
    const std::string first = write_frame(kKey, "content", mine.get()),
                      second = write_frame(kKey, "content", mine.get());
    EXPECT_EQ(first == second, name.ends_with("ecb")) << name;  // the others have a new IV each time
    for (const std::string& bytes : {first, second}) {
      const auto frame = read_datagram(bytes, theirs.get());
      ASSERT_TRUE(frame.ok()) << name << ": " << frame.error().message;
      EXPECT_EQ(frame->content, "content");
      const auto other = read_datagram(bytes, crypto(name, "another key").get());
      EXPECT_TRUE(!other.ok() || other->key != kKey) << name;
    }
  }
  EXPECT_EQ(cipher_of("rot13").error().message,
            "Unknown cipher 'rot13', expected aes-128-ecb, aes-128-cbc, aes-256-ecb or aes-256-cbc");
}

TEST(Wire, TheSizeOfAnEncryptedFrameMayLeaveOutTheIv) {
  std::string bytes = write_frame(kKey, "content", crypto("aes-128-cbc").get());
  bytes[7] = static_cast<char>(bytes[7] - 16);
  EXPECT_TRUE(read_datagram(bytes, crypto("aes-128-cbc").get()).ok());
  bytes[7] = static_cast<char>(bytes[7] + 1);
  EXPECT_THAT(message_of(read_datagram(bytes, crypto("aes-128-cbc").get())), HasSubstr("Invalid number of bytes"));
}

TEST(Wire, BrokenDatagramsAreRefused) {
  const std::string good = write_frame(kKey, "content");
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_THAT(message_of(read_datagram(good.substr(0, size))), HasSubstr("Invalid number of bytes")) << size;
  EXPECT_THAT(message_of(read_datagram(good + "x")), HasSubstr("Invalid number of bytes: found 20, expected 19"));
  std::string old = good;
  old[0] = 1;
  EXPECT_EQ(message_of(read_datagram(old)), "found frame header version 1, expected 2");
  std::string unknown = good;
  unknown[1] = 5;
  EXPECT_EQ(message_of(read_datagram(unknown)), "found cipher 5, expected 0 to 4");
  std::string empty = good.substr(0, kFrameHeader);
  empty[7] = 0;
  EXPECT_EQ(message_of(read_datagram(empty)), "found a payload of 0 bytes, expected at least 4");
}

TEST(Wire, BothSidesHaveTheSameCipher) {
  const auto cbc = crypto("aes-128-cbc");
  EXPECT_EQ(message_of(read_datagram(write_frame(kKey, "x"), cbc.get())),
            "Received plain text message, but encryption is enabled");
  EXPECT_EQ(message_of(read_datagram(write_frame(kKey, "x", cbc.get()))),
            "Received encrypted message, but encryption is disabled");
  EXPECT_EQ(message_of(read_datagram(write_frame(kKey, "x", cbc.get()), crypto("aes-128-ecb").get())),
            "Received message with cipher aes-128-cbc, expected aes-128-ecb");
  const std::string whole = write_frame(kKey, "x", cbc.get());
  std::string cut = whole.substr(0, kFrameHeader + 16);
  cut[7] = 16;
  EXPECT_THAT(message_of(read_datagram(cut, cbc.get())), HasSubstr("Decryption failed"));
  cut = whole.substr(0, whole.size() - 1);
  cut[7] = static_cast<char>(whole[7] - 1);
  EXPECT_THAT(message_of(read_datagram(cut, cbc.get())), HasSubstr("Decryption failed"));
}

TEST(Wire, AStreamIsReadInAnyPieces) {
  std::string stream;
  for (const char* content : {"one", "", "three"}) stream += write_frame(kKey, content);
  for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
    StreamReader reader;
    std::vector<std::string> read;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      reader.add(std::string_view(stream).substr(at, piece));
      while (true) {
        const auto frame = reader.next();
        ASSERT_TRUE(frame.ok());
        if (!*frame) break;
        read.push_back((*frame)->content);
      }
    }
    EXPECT_THAT(read, ::testing::ElementsAre("one", "", "three")) << piece;
  }
}

TEST(Wire, ABrokenStreamIsRefused) {
  StreamReader huge;
  huge.add(std::string("\x02\0\0\0\x01\0\0\x01", 8));
  EXPECT_EQ(huge.next().error().message, "found a payload of 16777217 bytes, expected at most 16777216");
  StreamReader encrypted;
  encrypted.add(write_frame(kKey, "x", crypto("aes-128-ecb").get()));
  EXPECT_EQ(encrypted.next().error().message, "Received encrypted message, but encryption is disabled");
  StreamReader garbage;
  garbage.add("GET / HTTP/1.0\r\n");
  EXPECT_EQ(garbage.next().error().message, "found frame header version 71, expected 2");
}

}  // namespace
}  // namespace cxlab::pb
