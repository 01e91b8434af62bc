#include "cx/bus/message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::HasSubstr;

class Messages : public ::testing::Test {
 protected:
  void SetUp() override {
    packages_.write("pkg/msg/Point", "float64 x\nfloat32 y 2.5\n");
    packages_.write("pkg/msg/Nothing", "");
    packages_.write("pkg/msg/All",
                    "bool flag\nbyte b\nchar c\nint8 i8\nuint8 u8\nint16 i16\nuint16 u16\nint32 i32\nuint32 u32\nint64 "
                    "i64\nuint64 u64\n"
                    "float32 f32\nfloat64 f64\nstring s\nstring<=3 short\nwstring<=3 wide\nint32[3] three\nuint8[<=2] "
                    "two\nfloat64[] many\n"
                    "string[] names\nstring[2] pair\nPoint point\nPoint[] points\nPoint[2] corners\nNothing "
                    "nothing\nNothing[] nothings\nbool[] flags\n");
    add_interfaces(registry_);
    ASSERT_TRUE(registry_.add_packages_in(packages_.folder()).ok());
    const auto type = registry_.message("pkg/msg/All");
    ASSERT_TRUE(type.ok()) << type.error().text();
    type_ = *type;
  }

  Message filled() const {
    Message message(*type_);
    message->set("flag", true)
        .set("b", 255)
        .set("c", 65)
        .set("i8", -128)
        .set("i16", -5)
        .set("u16", 65535)
        .set("i32", -7)
        .set("u32", std::int64_t{4294967295});
    message->set("i64", std::int64_t{INT64_MIN})
        .set("u64", std::int64_t{-1})
        .set("f32", 0.1)
        .set("f64", 0.1)
        .set("s", "a \"quoted\"\n text that is long enough for the heap");
    message->set("short", "abc").set("wide", "\xc3\xa4\xc3\xb6\xc3\xbc");
    EXPECT_TRUE(message->set_integer(*type_->find("three"), 9, 2).ok());
    EXPECT_TRUE(message->resize(*type_->find("many"), 2).ok());
    message->set_real(*type_->find("many"), 1e300, 1);
    message->append_text("names", "one").append_text("names", "a second name that does not fit into the string itself");
    EXPECT_TRUE(message->set_text(*type_->find("pair"), "right", 1).ok());
    message->append("points").set("x", 1.0);
    message->append("points").set("x", 2.0);
    message->nested("corners", 1).set("y", 7.5);
    message->append("nothings");
    EXPECT_TRUE(message->resize(*type_->find("flags"), 2).ok());
    EXPECT_TRUE(message->set_integer(*type_->find("flags"), 1, 1).ok());
    return message;
  }

  TempPackages packages_;
  Registry registry_;
  const MessageType* type_ = nullptr;
};

TEST_F(Messages, WhatIsSetIsRead) {
  const Message message = filled();
  EXPECT_EQ(message->integer("b"), 255);
  EXPECT_EQ(message->integer("i8"), -128);
  EXPECT_EQ(message->integer("u32"), 4294967295);
  EXPECT_EQ(message->integer("u64"), -1);
  EXPECT_EQ(message->real("f32"), static_cast<double>(0.1F));
  EXPECT_EQ(message->real("i16"), -5.0);
  EXPECT_EQ(message->size("points"), 2u);
  EXPECT_EQ(message->nested("points", 1).real("x"), 2.0);
  EXPECT_EQ(message->nested("points", 1).real("y"), 2.5);
  EXPECT_EQ(message->size("corners"), 2u);
  EXPECT_EQ(message->text(*type_->find("pair"), 1), "right");
  EXPECT_EQ(message->to_string(),
            "{flag: true, b: 255, c: 65, i8: -128, u8: 0, i16: -5, u16: 65535, i32: -7, u32: 4294967295, i64: "
            "-9223372036854775808, "
            "u64: 18446744073709551615, f32: 0.1, f64: 0.1, s: \"a \\\"quoted\\\"\\n text that is long enough for the "
            "heap\", short: \"abc\", "
            "wide: \"\xc3\xa4\xc3\xb6\xc3\xbc\", three: [0, 0, 9], two: [], many: [0.0, 1e+300], names: [\"one\", \"a "
            "second name that does not "
            "fit into the string itself\"], pair: [\"\", \"right\"], point: {x: 0.0, y: 2.5}, points: [{x: 1.0, y: "
            "2.5}, {x: 2.0, y: 2.5}], "
            "corners: [{x: 0.0, y: 2.5}, {x: 0.0, y: 7.5}], nothing: {}, nothings: [{}], flags: [false, true]}");
}

TEST_F(Messages, ValuesOutsideTheRangeAreRefused) {
  const Message message(*type_);
  EXPECT_THAT(message->set_integer(*type_->find("u8"), 256).error().message,
              HasSubstr("found 256, expected uint8 from 0 to 255"));
  EXPECT_THAT(message->set_integer(*type_->find("i8"), -129).error().message, HasSubstr("'i8'"));
  EXPECT_FALSE(message->set_integer(*type_->find("flag"), 2).ok());
  EXPECT_THAT(message->set_text(*type_->find("short"), "abcd").error().message, HasSubstr("at most 3"));
  EXPECT_FALSE(message->set_text(*type_->find("wide"), "abcd").ok());
  EXPECT_THAT(message->resize(*type_->find("two"), 3).error().message, HasSubstr("at most 2"));
  EXPECT_THAT(message->resize(*type_->find("three"), 2).error().message, HasSubstr("cannot change its size"));
  EXPECT_TRUE(message->equals(Message(*type_)));
}

TEST_F(Messages, CopiesAreDeep) {
  Message message = filled();
  Message copy = message;
  EXPECT_TRUE(copy->equals(message));
  copy->nested("points", 0).set("x", 9.0);
  EXPECT_FALSE(copy->equals(message));
  EXPECT_EQ(message->nested("points", 0).real("x"), 1.0);
  copy->copy_from(message);
  EXPECT_TRUE(copy->equals(message));
  EXPECT_TRUE(copy->resize(*type_->find("names"), 0).ok());
  EXPECT_FALSE(copy->equals(message));
  message = copy;
  EXPECT_TRUE(message->equals(copy));
  message->nested("point").copy_from(copy->nested("points", 1));
  EXPECT_EQ(message->nested("point").real("x"), 2.0);
  const Message moved = std::move(message);
  EXPECT_EQ(moved->nested("point").real("x"), 2.0);
  EXPECT_FALSE(Message());
}

TEST_F(Messages, AreEqualIfAllFieldsAre) {
  packages_.write("pkg/msg/Named", "string name\nint32[] numbers\n");
  packages_.write("pkg/msg/Nest", "Named one\nNamed[2] two\nNamed[] many\nfloat32 f\nfloat64 d\nint8[3] bytes\n");
  const MessageType& type = **registry_.message("pkg/msg/Nest");
  const auto made = [&type](const char* yaml) { return *Message::from_yaml(type, yaml); };
  const char* texts[] = {"{}",
                         "{one: {name: a}}",
                         "{one: {name: b}}",
                         "{one: {numbers: [1]}}",
                         "{two: [{name: a}, {}]}",
                         "{two: [{}, {name: a}]}",
                         "{many: [{}]}",
                         "{many: [{name: a, numbers: [1, 2]}]}",
                         "{many: [{name: a, numbers: [1, 3]}]}",
                         "{f: 0.5}",
                         "{d: 0.5}",
                         "{bytes: [0, 0, 1]}",
                         "{bytes: [1, 0, 0]}"};
  for (const char* a : texts)
    for (const char* b : texts) EXPECT_EQ(made(a)->equals(made(b)), a == b) << a << ' ' << b;
  EXPECT_TRUE(made("{f: -0.0, d: -0.0}")->equals(made("{}")));
  EXPECT_FALSE(made("{f: .nan}")->equals(made("{f: .nan}")));
  EXPECT_FALSE(Message(type)->equals(Message(*type_))) << "of another type";
}

TEST_F(Messages, ElementsSurviveGrowthAndShrinking) {
  Message message(*type_);
  for (int i = 0; i < 100; ++i)
    message->append_text("names", "name number " + std::to_string(i) + ", long enough for the heap");
  for (int i = 0; i < 100; ++i) message->append("points").set("x", i);
  ASSERT_TRUE(message->resize(*type_->find("names"), 50).ok());
  ASSERT_TRUE(message->resize(*type_->find("names"), 60).ok());
  EXPECT_EQ(message->text(*type_->find("names"), 49), "name number 49, long enough for the heap");
  EXPECT_EQ(message->text(*type_->find("names"), 59), "");
  EXPECT_EQ(message->nested("points", 99).real("x"), 99.0);
}

TEST_F(Messages, BytesReadBackAsTheSameMessage) {
  const Message message = filled();
  std::string bytes = "xx";
  message.serialize(bytes);
  Message(*type_).serialize(bytes);
  std::size_t position = 2;
  const auto span = std::as_bytes(std::span(bytes));
  const auto first = Message::deserialize(*type_, span, position);
  ASSERT_TRUE(first.ok()) << first.error().text();
  EXPECT_TRUE((*first)->equals(message));
  const auto second = Message::deserialize(*type_, span, position);
  ASSERT_TRUE(second.ok());
  EXPECT_TRUE((*second)->equals(Message(*type_)));
  EXPECT_EQ(position, bytes.size());
  EXPECT_EQ(bytes.size() - 2 > type_->serialized_min(), true);
}

TEST_F(Messages, CutBytesAreAnError) {
  std::string bytes;
  filled().serialize(bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::size_t position = 0;
    EXPECT_FALSE(Message::deserialize(*type_, std::as_bytes(std::span(bytes.data(), size)), position).ok()) << size;
  }
}

TEST_F(Messages, BytesOfAFlagAreZeroOrOne) {
  packages_.write("pkg/msg/Flags", "bool one\nbool[2] two\nbool[] many\n");
  const MessageType& type = **registry_.message("pkg/msg/Flags");
  std::string bytes;
  (*Message::from_yaml(type, "{one: true, two: [false, true], many: [true, false, true]}")).serialize(bytes);
  int flags = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = 2;
    std::size_t position = 0;
    const auto message = Message::deserialize(type, std::as_bytes(std::span(changed)), position);
    if (message.ok() || message.error().message.find("neither 0 nor 1") == std::string::npos) continue;
    ++flags;
    EXPECT_EQ(message.error().kind, ErrorKind::kInput);
  }
  EXPECT_EQ(flags, 6);
  std::size_t behind = bytes.size() + 1;
  EXPECT_THAT(Message::deserialize(type, std::as_bytes(std::span(bytes)), behind).error().message,
              HasSubstr("behind the end of the bytes"));
}

TEST_F(Messages, YamlAndJsonGiveTheSame) {
  const auto yaml = Message::from_yaml(*type_,
                                       "flag: true\ni8: -3\nu64: 18446744073709551615\nf64: .inf\ns: 12\npoint: {x: "
                                       "1}\npoints:\n- y: 3\n- {}\ntwo: [1, 0x2]\n");
  ASSERT_TRUE(yaml.ok()) << yaml.error().text();
  const auto json = Message::from_yaml(
      *type_, R"({"flag": true, "i8": -3, "u64": 18446744073709551615, "f64": .inf, "s": "12", "point": {"x": 1},
                                                   "points": [{"y": 3}, {}], "two": [1, 2]})");
  ASSERT_TRUE(json.ok()) << json.error().text();
  EXPECT_TRUE((*yaml)->equals(*json));
  EXPECT_EQ((*yaml)->nested("points", 1).real("y"), 2.5);
  EXPECT_TRUE((*Message::from_yaml(*type_, ""))->equals(Message(*type_)));
}

TEST_F(Messages, WhatToStringSaysIsReadAgain) {
  const Message message = filled();
  const auto again = Message::from_yaml(*type_, message->to_string());
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_TRUE((*again)->equals(message)) << (*again)->to_string();
}

TEST_F(Messages, BadYamlNamesFieldLineAndNearest) {
  const struct {
    const char* text;
    int line;
    const char* message;
  } cases[] = {{"flag: true\nshrt: abc\n", 2, "pkg/msg/All has no field 'shrt'; nearest is 'short'"},
               {"point:\n  z: 1\n", 2, "pkg/msg/Point has no field 'z'"},
               {"i8: 1\nu8: 256\n", 2, "field 'u8': found 256, expected uint8 from 0 to 255"},
               {"u64: -1\n", 1, "expected uint64 from 0"},
               {"i32: 1.5\n", 1, "found '1.5', expected an integer"},
               {"flag: maybe\n", 1, "expected true or false"},
               {"f64: fast\n", 1, "field 'f64': found 'fast', expected a number"},
               {"f32: 1e200\n", 1, "float32 can hold"},
               {"point: 3\n", 1, "field 'point': found '3', expected a map"},
               {"points:\n- x: 1\n- x: [1]\n", 3, "field 'points[1].x': found a list of 1"},
               {"three: [1, 2]\n", 1, "found 2 elements, expected 3"},
               {"two: [1, 2, 3]\n", 1, "at most 2"},
               {"many: 3\n", 1, "expected a list (float64[])"},
               {"short: abcd\n", 1, "at most 3"},
               {"i8: 1\ni8: 2\n", 2, "given twice"},
               {"[1, 2]", 1, "expected a map of the fields of pkg/msg/All"},
               {"a: [1\n", 2, ""}};
  for (const auto& c : cases) {
    const auto message = Message::from_yaml(*type_, c.text);
    ASSERT_FALSE(message.ok()) << c.text;
    EXPECT_EQ(message.error().line, c.line) << c.text;
    EXPECT_THAT(message.error().message, HasSubstr(c.message));
    EXPECT_EQ(message.error().message.find("field '"), message.error().message.rfind("field '"))
        << "the field is named once";
  }
}

TEST_F(Messages, RecordsHoldAllFieldsInOrder) {
  Message message(**registry_.message("geometry_msgs/msg/Vector3"));
  message->set("y", 1.0);
  RecordData data, expected;
  data.begin().name("msg");
  message->record(data);
  expected.begin().name("msg").open_map(3);
  expected.text_key("x").value(0.0).text_key("y").value(1.0).text_key("z").value(0.0);
  EXPECT_EQ(data.bytes(), expected.bytes());
}

TEST_F(Messages, RecordsHoldTheWholeRangeOfUint64) {
  Message message(**registry_.message("std_msgs/msg/UInt64"));
  message->set("data", std::int64_t{-1});
  RecordData data, expected;
  data.begin().name("msg");
  message->record(data);
  expected.begin().name("msg").open_map(1).text_key("data").value(std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(data.bytes(), expected.bytes());
  EXPECT_EQ(message->to_string(), "{data: 18446744073709551615}");
}

}  // namespace
}  // namespace cxlab::bus
