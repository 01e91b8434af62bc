// CDR by hand for cases of alignment; for all definitions: what is written is read again. tests/readers compares with
// what rosbags writes.

#include "cx/bus/cdr.h"

#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {

namespace {

class CdrTest : public BusTest {
 protected:
  const MessageType& type_of(const std::string& text) {
    packages_.write("p/msg/T", text);
    registry().add_package("p", packages_.folder() / "p").ok();
    const auto type = registry().message("p/msg/T");
    EXPECT_TRUE(type) << type.error().text();
    return **type;
  }
  Registry& registry() { return made_; }
  static std::string bytes_of(const MessageView& message) {
    std::string out = "what was there before";
    CdrWriter(out).message(message);
    return out;
  }

 private:
  TempPackages packages_;
  Registry made_;
};

/// "1a 00": hex digits as bytes.
std::string hex(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i + 1 < text.size(); i += 3)
    out += static_cast<char>(std::stoi(std::string(text.substr(i, 2)), nullptr, 16));
  return out;
}

struct Row {
  const char* definition;
  const char* value;
  const char* bytes;  ///< behind the header
};
constexpr Row kRows[]{
    {"uint8 a\nuint32 b\n", "{a: 1, b: 2}", "01 00 00 00 02 00 00 00"},
    {"uint8 a\nuint16 b\nuint8 c\n", "{a: 1, b: 2, c: 3}", "01 00 02 00 03"},
    {"uint32 a\nfloat64 b\n", "{a: 1, b: 1.0}", "01 00 00 00 00 00 00 00 00 00 00 00 00 00 f0 3f"},
    {"string a\nuint8 b\nint64 c\n", "{a: 'ab', b: 7, c: -1}", "03 00 00 00 61 62 00 07 ff ff ff ff ff ff ff ff"},
    {"string a\nstring b\n", "{a: '', b: 'x'}", "01 00 00 00 00 00 00 00 02 00 00 00 78 00"},
    {"float64[] a\nuint8 b\n", "{a: [], b: 5}", "00 00 00 00 05"},
    {"float64[] a\n", "{a: [1.0]}", "01 00 00 00 00 00 00 00 00 00 00 00 00 00 f0 3f"},
    {"uint8 a\nint16[2] b\n", "{a: 9, b: [1, -1]}", "09 00 01 00 ff ff"},
    {"bool[<=3] a\n", "{a: [true, false]}", "02 00 00 00 01 00"},
    {"string[] a\n", "{a: ['', 'q']}", "02 00 00 00 01 00 00 00 00 00 00 00 02 00 00 00 71 00"},
    {"float32 a\nchar b\nbyte c\nint8 d\n", "{a: 2.0, b: 1, c: 2, d: -3}", "00 00 00 40 01 02 fd"},
    {"", "{}", "00"},
    {"wstring a\n", "{a: 'a\xc3\xa9\xf0\x9f\x98\x80'}", "04 00 00 00 61 00 e9 00 3d d8 00 de"},
};

TEST_F(CdrTest, FieldsAreAlignedFromTheEndOfTheHeader) {
  int number = 0;
  for (const Row& row : kRows) {
    TempPackages packages;
    packages.write("p/msg/T", row.definition);
    Registry registry;
    ASSERT_TRUE(registry.add_package("p", packages.folder() / "p"));
    const auto type = registry.message("p/msg/T");
    ASSERT_TRUE(type);
    const auto message = Message::from_yaml(**type, row.value);
    ASSERT_TRUE(message) << message.error().text();
    const std::string bytes = bytes_of(*message);
    EXPECT_EQ(bytes, hex("00 01 00 00") + hex(row.bytes)) << "row " << number;
    const auto again = read_cdr(**type, bytes);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_TRUE(again->view().equals(*message)) << "row " << number;
    // Each prefix is an error, none a crash.
    for (std::size_t size = 0; size < bytes.size(); ++size)
      EXPECT_FALSE(read_cdr(**type, std::string_view(bytes).substr(0, size))) << "row " << number << ", " << size;
    ++number;
  }
}

/// What a machine with the other order of bytes writes: the same values, each number reversed.
TEST_F(CdrTest, BigEndianValuesAreTheSameValues) {
  const Row rows[] = {
      {"bool a\nint16 b\nfloat64 c\n", "{a: true, b: -2, c: 0.5}", "01 00 ff fe 00 00 00 00 3f e0 00 00 00 00 00 00"},
      {"string a\nuint32 b\n", "{a: 'xyz', b: 258}", "00 00 00 04 78 79 7a 00 00 00 01 02"},
      {"int16[] a\nuint8[2] b\nfloat32[2] c\n", "{a: [1, 515], b: [7, 8], c: [1.0, -2.0]}",
       "00 00 00 02 00 01 02 03 07 08 00 00 3f 80 00 00 c0 00 00 00"},
      {"wstring a\n", "{a: 'a\xc3\xa9'}", "00 00 00 02 00 61 00 e9"},
  };
  for (const Row& row : rows) {
    TempPackages packages;
    packages.write("p/msg/T", row.definition);
    Registry registry;
    ASSERT_TRUE(registry.add_package("p", packages.folder() / "p"));
    const auto type = registry.message("p/msg/T");
    ASSERT_TRUE(type);
    const auto message = Message::from_yaml(**type, row.value);
    ASSERT_TRUE(message) << message.error().text();
    const auto read = read_cdr(**type, hex("00 00 00 00") + hex(row.bytes));
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_TRUE(read->view().equals(*message)) << row.definition;
  }
}

TEST_F(CdrTest, AllDefinitionsAreReadAsTheyWereWritten) {
  int types = 0;
  for (const std::string& package : registry_.packages())
    for (const std::string& name : registry_.interfaces(package)) {
      if (name.find("/msg/") == name.npos) continue;
      const auto type = registry_.message(name);
      ASSERT_TRUE(type) << type.error().text();
      const Message message(**type);
      const auto again = read_cdr(**type, bytes_of(message));
      ASSERT_TRUE(again) << name << ": " << again.error().text();
      EXPECT_TRUE(again->view().equals(message)) << name;
      ++types;
    }
  EXPECT_GT(types, 100);
}

TEST_F(CdrTest, ErrorsNameTheFieldAndTheByte) {
  const MessageType& text = **registry_.message("std_msgs/msg/String");
  const MessageType& list = **registry_.message("std_msgs/msg/Float64MultiArray");
  const MessageType& flag = **registry_.message("std_msgs/msg/Bool");
  const auto error = [](const MessageType& type, std::string_view bytes) {
    const auto read = read_cdr(type, bytes);
    return read ? std::string("none") : read.error().message;
  };
  EXPECT_EQ(error(text, ""), "found 0 bytes, expected CDR with its header of 4");
  EXPECT_EQ(error(text, hex("00 07 00 00 00 00")),
            "found the representation 0 7, expected 0 0 or 0 1, which is big-endian or little-endian CDR");
  EXPECT_EQ(error(text, hex("00 01 00 00 09 00 00 00 61")), "field 'data': found the end of the bytes, at byte 8");
  EXPECT_EQ(error(flag, hex("00 01 00 00 02")), "field 'data': found 2, expected 0 or 1 for a bool, at byte 4");
  EXPECT_EQ(error(list, hex("00 01 00 00 ff ff ff ff 00 00 00 00")),
            "field 'dim': found 4294967295 elements, more than the bytes hold, at byte 8");
}

TEST_F(CdrTest, TextThatIsNoUtf8BecomesTheReplacementCharacter) {
  const MessageType& type = type_of("wstring a\n");
  const auto units = [&](std::string_view text) {
    Message message(type);
    message->set("a", text);
    return bytes_of(message).substr(8);
  };
  const std::string unknown = hex("fd ff");
  EXPECT_EQ(units("\xc3\xa9"), hex("e9 00"));
  EXPECT_EQ(units("\xe0\xa0\x80"), hex("00 08")) << "the first of three bytes";
  EXPECT_EQ(units("\xf0\x90\x80\x80"), hex("00 d8 00 dc")) << "the first of four bytes";
  // Longer than needed, half of a pair, cut off, and beyond the last.
  EXPECT_EQ(units("\xc0\xaf"), unknown + unknown);
  EXPECT_EQ(units("\xe0\x9f\xbf"), unknown + unknown + unknown);
  EXPECT_EQ(units("\xf0\x8f\xbf\xbf"), unknown + unknown + unknown + unknown);
  EXPECT_EQ(units("\xed\xa0\x80"), unknown + unknown + unknown);
  EXPECT_EQ(units("\xe2\x82"), unknown + unknown);
  EXPECT_EQ(units("\xf4\x90\x80\x80"), unknown + unknown + unknown + unknown);
}

TEST_F(CdrTest, ComposedValueIsReadPartByPart) {
  const MessageType& point = **registry_.message("geometry_msgs/msg/Point");
  Message value(point);
  value->set("y", 2.5);
  std::string bytes;
  CdrWriter(bytes).number(std::uint8_t{7}).bytes("abc").text("hello").size(1).message(value).number(std::int16_t{-3});
  const auto read = [&](std::size_t size, std::uint32_t most) {
    std::uint8_t first = 0;
    std::string three;
    std::string_view hello;
    std::uint32_t count = 0;
    std::int16_t last = 0;
    Message again(point);
    CdrReader in(std::string_view(bytes).substr(0, size));
    in.number(first).bytes(three, 3).text(hello).size(count, most).message(again.view()).number(last);
    if (in.status()) {
      EXPECT_EQ(first, 7);
      EXPECT_EQ(three, "abc");
      EXPECT_EQ(hello, "hello");
      EXPECT_EQ(count, 1U);
      EXPECT_EQ(again->real("y"), 2.5);
      EXPECT_EQ(last, -3);
    }
    return in.status() ? std::string() : in.status().error().message;
  };
  EXPECT_EQ(read(bytes.size(), 1), "");
  EXPECT_EQ(read(bytes.size(), 0), "found 1 elements, expected at most 0, at byte 24");
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_NE(read(size, 1), "") << size;
}

TEST_F(CdrTest, SchemaHasEachTypeOnce) {
  const std::string line(80, '=');
  EXPECT_EQ(ros2msg_schema(**registry_.message("geometry_msgs/msg/PoseStamped")),
            "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + line +
                "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + line +
                "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + line +
                "\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n" +
                line + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" + line +
                "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  EXPECT_EQ(ros2msg_text(type_of("string<=3[<=2] a\nint8[4] b\nint8 C=-3\nstring D=\"x\\\"y\"\n")),
            "int8 C=-3\nstring D=\"x\\\"y\"\nstring<=3[<=2] a\nint8[4] b\n");
}

}  // namespace

}  // namespace cxlab::bus
