#include "cx/bus/interface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "cx/bus/message.h"
#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

TEST(Interfaces, EveryDefinitionOfTheProjectCompiles) {
  Registry registry;
  add_interfaces(registry);
  std::size_t count = 0;
  for (const std::string& package : registry.packages()) {
    for (const std::string& name : registry.interfaces(package)) {
      Status status;
      if (name.find("/srv/") != std::string::npos) {
        const auto type = registry.service(name);
        if (!type) status = type.error();
      } else if (name.find("/action/") != std::string::npos) {
        const auto type = registry.action(name);
        if (!type) status = type.error();
      } else {
        const auto type = registry.message(name);
        if (!type) status = type.error();
      }
      EXPECT_TRUE(status.ok()) << name << ": " << status.error().text();
      ++count;
    }
  }
  EXPECT_GT(count, 200u);
  EXPECT_EQ(registry.files_read().size(), count);
}

TEST(Interfaces, FieldsKeepOrderTypesAndDefaults) {
  Registry registry;
  add_interfaces(registry);
  const MessageType& quaternion = **registry.message("geometry_msgs/Quaternion");
  EXPECT_EQ(quaternion.name(), "geometry_msgs/msg/Quaternion");
  EXPECT_THAT(quaternion.field_names(), ElementsAre("x", "y", "z", "w"));
  EXPECT_EQ(Message(quaternion)->to_string(), "{x: 0.0, y: 0.0, z: 0.0, w: 1.0}");
  EXPECT_EQ(quaternion.byte_size(), 32u);
  EXPECT_TRUE(quaternion.plain());
  const MessageType& pose = **registry.message("geometry_msgs/msg/PoseStamped");
  EXPECT_FALSE(pose.plain());
  EXPECT_EQ(Message(pose)->nested("pose").nested("orientation").real("w"), 1.0);
}

TEST(Interfaces, SectionsOfServicesAndActionsAreMessagesOfTheirOwn) {
  Registry registry;
  add_interfaces(registry);
  const ServiceType& cancel = **registry.service("action_msgs/srv/CancelGoal");
  EXPECT_EQ(cancel.request->name(), "action_msgs/srv/CancelGoal_Request");
  EXPECT_EQ(cancel.response->constants().size(), 4u);
  EXPECT_EQ(*registry.message("action_msgs/srv/CancelGoal_Response"), cancel.response);
  const ActionType& fibonacci = **registry.action("example_interfaces/action/Fibonacci");
  EXPECT_EQ(fibonacci.goal->fields()[0].name, "order");
  EXPECT_EQ(fibonacci.result->fields()[0].type_text(), "int32[]");
  EXPECT_EQ(fibonacci.feedback->name(), "example_interfaces/action/Fibonacci_Feedback");
  EXPECT_EQ(*registry.message("example_interfaces/action/Fibonacci_Goal"), fibonacci.goal);
}

TEST(Interfaces, TheWholeLanguageIsRead) {
  TempPackages packages;
  packages.write("std_msgs/msg/Header", "string frame_id\n");
  packages.write("pkg/msg/Inner", "int8 a 5\n");
  packages.write("pkg/msg/All",
                 "\xef\xbb\xbf# a comment\r\n"
                 "int32 LIMIT=0x10   # sixteen\r\n"
                 "string GREETING = \"a # b\" # not inside\n"
                 "string PLAIN=it's fine # cut\n"
                 "float32 HALF=.5\n"
                 "bool FLAG=true\n"
                 "uint64 BIG=18446744073709551615\n"
                 "int64 SMALL=-9223372036854775808\n"
                 "\n"
                 "bool flag true\n"
                 "byte b 255\n"
                 "char c 65\n"
                 "int8[3] fixed [1, -2, 3]\n"
                 "uint16[<=4] bounded [7]\n"
                 "float64[] open\t[1.5, 2]\n"
                 "string<=5 short 'a#b'\n"
                 "string[] names [\"x, y\", z]\n"
                 "wstring<=2 wide \"h\xc3\xa4\"\n"
                 "Inner inner\n"
                 "pkg/Inner[2] pair\n"
                 "pkg/msg/Inner[<=3] few\n"
                 "Header header");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  const auto type = registry.message("pkg/msg/All");
  ASSERT_TRUE(type.ok()) << type.error().text();
  std::vector<std::string> constants, types;
  for (const Constant& constant : (*type)->constants()) constants.push_back(constant.name + "=" + constant.value_text);
  for (const Field& field : (*type)->fields()) types.push_back(field.type_text());
  EXPECT_THAT(constants, ElementsAre("LIMIT=0x10", "GREETING=a # b", "PLAIN=it's fine", "HALF=.5", "FLAG=true",
                                     "BIG=18446744073709551615", "SMALL=-9223372036854775808"));
  EXPECT_THAT(types, ElementsAre("bool", "byte", "char", "int8[3]", "uint16[<=4]", "float64[]", "string<=5", "string[]",
                                 "wstring<=2", "pkg/msg/Inner", "pkg/msg/Inner[2]", "pkg/msg/Inner[<=3]",
                                 "std_msgs/msg/Header"));
  EXPECT_EQ(Message(**type)->to_string(),
            "{flag: true, b: 255, c: 65, fixed: [1, -2, 3], bounded: [7], open: [1.5, 2.0], short: \"a#b\", names: "
            "[\"x, y\", \"z\"], "
            "wide: \"h\xc3\xa4\", inner: {a: 5}, pair: [{a: 5}, {a: 5}], few: [], header: {frame_id: \"\"}}");
}

struct BadFile {
  const char* text;
  int line;
  const char* message;
};

class BadDefinition : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadDefinition, IsReportedWithFileAndLine) {
  TempPackages packages;
  packages.write("pkg/msg/Inner", "int8 a\n");
  const auto file = packages.write("pkg/msg/Bad", GetParam().text);
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  const auto type = registry.message("pkg/msg/Bad");
  ASSERT_FALSE(type.ok());
  EXPECT_EQ(type.error().file, file.string());
  EXPECT_EQ(type.error().line, GetParam().line) << type.error().text();
  EXPECT_THAT(type.error().message, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Interfaces, BadDefinition,
    ::testing::Values(
        BadFile{"\nint23 a\n", 2, "found type 'int23'"}, BadFile{"flaot64 a\n", 1, "nearest is 'float64'"},
        BadFile{"Iner a\n", 1, "nearest is 'pkg/msg/Inner'"}, BadFile{"pgk/Inner a\n", 1, "package 'pgk'"},
        BadFile{"pgk/Inner a\n", 1, "nearest is 'pkg'"}, BadFile{"pkg/srv/Inner a\n", 1, "expected a primitive type"},
        BadFile{"pkg/msg/inner a\n", 1, "expected a primitive type"},
        BadFile{"pkg/msg/In_ner a\n", 1, "expected a primitive type"},
        BadFile{"pkg/ a\n", 1, "expected a primitive type"}, BadFile{"Pkg/Inner a\n", 1, "expected a primitive type"},
        BadFile{"pkg/msg/x/Inner a\n", 1, "expected a primitive type"},
        BadFile{"/Inner a\n", 1, "expected a primitive type"}, BadFile{"int8\n", 1, "no name after the type 'int8'"},
        BadFile{"int8 Big\n", 1, "expected a name in lower case"},
        BadFile{"int8 a__b\n", 1, "expected a name in lower case"},
        BadFile{"int8 a_\n", 1, "expected a name in lower case"}, BadFile{"int8 LIMIT\n", 1, "a constant needs '='"},
        BadFile{"int8 limit=3\n", 1, "expected a name in capitals"}, BadFile{"int8 LIMIT=\n", 1, "has no value"},
        BadFile{"int8 LIMIT=200\n", 1, "expected int8 from -128 to 127"}, BadFile{"int8 LIMIT=1.5\n", 1, "found '1.5'"},
        BadFile{"int8 LIMIT=-129\n", 1, "expected int8 from -128 to 127"},
        BadFile{"uint8 LIMIT=-1\n", 1, "expected uint8 from 0 to 255"},
        BadFile{"int16 LIMIT=32768\n", 1, "expected int16 from -32768 to 32767"},
        BadFile{"int8 LIMIT=0x\n", 1, "found '0x'"}, BadFile{"int8 LIMIT=0b2\n", 1, "found '0b2'"},
        BadFile{"int8 LIMIT=0o8\n", 1, "found '0o8'"}, BadFile{"int8 LIMIT=+-1\n", 1, "found '+-1'"},
        BadFile{"int8 LIMIT=1 2\n", 1, "found '1 2'"}, BadFile{"float32 LIMIT=1 2\n", 1, "found '1 2'"},
        BadFile{"float64 LIMIT=1e400\n", 1, "a number that a float64 can hold"},
        BadFile{"string S=\"a\" b\n", 1, "after the closing quote"}, BadFile{"string[] a [x,,y]\n", 1, "an empty item"},
        BadFile{"string[] a [x,]\n", 1, "an empty item"}, BadFile{"string[] a [\n", 1, "expected a list"},
        BadFile{"string[] a ]\n", 1, "expected a list"}, BadFile{"string S=\"a\\\n", 1, "no closing \""},
        BadFile{"bool ON=yes\n", 1, "expected true or false"}, BadFile{"string S=\"open\n", 1, "no closing \""},
        BadFile{"Inner I=3\n", 1, "expected a primitive type, not an array"},
        BadFile{"int8[] L=3\n", 1, "not an array"}, BadFile{"int8 A=1\nint8 A=2\n", 2, "defined twice"},
        BadFile{"int8 a\nint16 a\n", 2, "defined twice, first in line 1"},
        BadFile{"int8 a 300\n", 1, "default of field 'a' (int8): found 300"},
        BadFile{"int8[2] a [1]\n", 1, "found 1 values, expected 2"}, BadFile{"int8[<=1] a [1, 2]\n", 1, "at most 1"},
        BadFile{"int8[] a 3\n", 1, "expected a list"}, BadFile{"string<=2 a \"abc\"\n", 1, "at most 2"},
        BadFile{"string[] a [\"b]\n", 1, "no closing \""},
        BadFile{"Inner a 3\n", 1, "only primitive types have defaults"},
        BadFile{"int8[0] a\n", 1, "expected a number from 1"}, BadFile{"int8[-1] a\n", 1, "expected a number from 1"},
        BadFile{"int8[<=] a\n", 1, "expected a number from 1"},
        BadFile{"string<=16777217 a\n", 1, "expected a number from 1 to 16777216"},
        BadFile{"int8[<=16777217] a\n", 1, "expected a number from 1 to 16777216"},
        BadFile{"int8[3 a\n", 1, "expected an array"}, BadFile{"int8<=3 a\n", 1, "only string and wstring"},
        BadFile{"float64[16777216] a\n", 1, "larger than"}, BadFile{"int8 a\n---\nint8 b\n", 2, "one '---' more"},
        BadFile{"Bad a\n", 1, "contains itself: pkg/msg/Bad -> pkg/msg/Bad"}));

TEST(Interfaces, BoundsGoUpTo16777216AndATabSeparatesWords) {
  TempPackages packages;
  packages.write("pkg/msg/Wide", "string<=16777216\ttext\nint8[<=16777216] list\nint8\tLEAST=-128\n");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  const auto type = registry.message("pkg/msg/Wide");
  ASSERT_TRUE(type.ok()) << type.error().text();
  EXPECT_THAT((*type)->field_names(), ElementsAre("text", "list"));
  EXPECT_EQ((*type)->find("text")->string_limit, 16777216u);
  EXPECT_EQ((*type)->find("list")->size_limit, 16777216u);
}

TEST(Interfaces, ValuesAreReadAsTheyAreWritten) {
  TempPackages packages;
  packages.write("pkg/msg/Values",
                 "int32 a 0x1F\nint32 b 0X1f\nint32 c -0x10\nint32 d 0o17\nint32 e 0b101\nint32 f 010\nint32 g +7\n"
                 "int32 h 0\nint32 i -0\nint32 j 00\nuint64 k 0xffffffffffffffff\n"
                 "bool l True\nbool m 1\nbool n False\nbool o 0\nbool p false\nbool q true\n"
                 "float64 r +1.5\nfloat64 s -2\nfloat64 t 1e3\n"
                 "string u 'it\\'s'\nstring v \"a\\tb\\nc\\\\d\\\"e\\q\"\nstring w \"\"\nstring x a\\n\n"
                 "string[] y [\"a\\\"]b\", 'c, d' , e f]\nint32[] z []\n"
                 "string za \"#\" # a comment\nstring zb it's # a comment\nstring zc \"\\\"#\" # a comment\n");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  const auto type = registry.message("pkg/msg/Values");
  ASSERT_TRUE(type.ok()) << type.error().text();
  EXPECT_EQ(Message(**type)->to_string(),
            "{a: 31, b: 31, c: -16, d: 15, e: 5, f: 10, g: 7, h: 0, i: 0, j: 0, k: 18446744073709551615, "
            "l: true, m: true, n: false, o: false, p: false, q: true, r: 1.5, s: -2.0, t: 1000.0, "
            "u: \"it's\", v: \"a\\tb\\nc\\\\d\\\"e\\\\q\", w: \"\", x: \"a\\\\n\", "
            "y: [\"a\\\"]b\", \"c, d\", \"e f\"], z: [], za: \"#\", zb: \"it's\", zc: \"\\\"#\"}");
}

TEST(Interfaces, OnlyFoldersWithTheNameOfAPackageAreSome) {
  TempPackages packages;
  for (const char* name : {"good_1/msg/T", "b-d/msg/T", "b.d/msg/T", "\xc3\xa4/msg/T"})
    packages.write(name, "int8 a\n");
  put_file(packages.folder() / "file", "text");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  EXPECT_THAT(registry.packages(), ElementsAre("good_1"));
  for (const char* name : {"", "b-d", "b.d", "a/b", "\xc3\xa4", "a b", "a@", "a[", "a`", "a{"})
    EXPECT_THAT(registry.add_package(name, packages.folder() / "good_1").error().message,
                HasSubstr("expected letters, digits and underscores"))
        << name;
  for (const char* name : {"azAZ09_", "Z", "0"})
    EXPECT_TRUE(registry.add_package(name, packages.folder() / "good_1").ok());
}

TEST(Interfaces, MessagesNestUpTo64Deep) {
  TempPackages packages;
  packages.write("pkg/msg/M1", "int8 a\n");
  for (int i = 2; i <= 65; ++i)
    packages.write("pkg/msg/M" + std::to_string(i), "M" + std::to_string(i - 1) + " inner\n");
  Registry registry, other;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  ASSERT_TRUE(other.add_packages_in(packages.folder()).ok());
  EXPECT_TRUE(registry.message("pkg/msg/M64").ok());
  EXPECT_TRUE(registry.message("pkg/msg/M65").ok()) << "M64 is known";
  EXPECT_THAT(other.message("pkg/msg/M65").error().message, HasSubstr("nested in 64 messages, which is the most"));
}

TEST(Interfaces, ADefinitionHasAtMost4MiB) {
  TempPackages packages;
  std::string text = "int8 a\n#";
  text.resize(std::size_t{1} << 22, '#');
  packages.write("pkg/msg/Long", text);
  packages.write("pkg/msg/Longer", text + '#');
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  EXPECT_TRUE(registry.message("pkg/msg/Long").ok());
  EXPECT_THAT(registry.message("pkg/msg/Longer").error().message,
              HasSubstr("found 4194305 bytes, expected a definition of at most 4194304"));
}

TEST(Interfaces, RecursionThroughOtherMessagesIsNamed) {
  TempPackages packages;
  packages.write("pkg/msg/A", "B b\n");
  packages.write("pkg/msg/B", "int8 x\nC[] c\n");
  const auto c = packages.write("pkg/msg/C", "A a\n");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  const auto type = registry.message("pkg/msg/A");
  ASSERT_FALSE(type.ok());
  EXPECT_EQ(type.error().file, c.string());
  EXPECT_THAT(type.error().message, HasSubstr("pkg/msg/A -> pkg/msg/B -> pkg/msg/C -> pkg/msg/A"));
}

TEST(Interfaces, ATypeIsReadOnce) {
  Registry registry;
  add_interfaces(registry);
  const MessageType* message = *registry.message("std_msgs/msg/String");
  const MessageType* request = (*registry.service("std_srvs/srv/SetBool"))->request;
  const MessageType* goal = (*registry.action("example_interfaces/action/Fibonacci"))->goal;
  EXPECT_EQ(*registry.message("std_msgs/msg/String"), message);
  EXPECT_EQ((*registry.service("std_srvs/srv/SetBool"))->request, request);
  EXPECT_EQ((*registry.action("example_interfaces/action/Fibonacci"))->goal, goal);
  EXPECT_EQ(*registry.message("std_srvs/srv/SetBool_Request"), request);
  EXPECT_EQ(*registry.message("example_interfaces/action/Fibonacci_Goal"), goal);
}

TEST(Interfaces, AServiceNeedsItsLineOfDashes) {
  TempPackages packages;
  packages.write("pkg/srv/S", "int8 a\n");
  packages.write("pkg/action/A", "int8 a\n---\nint8 b\n");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  EXPECT_THAT(registry.service("pkg/srv/S").error().message, HasSubstr("found 0 lines of '---', expected 1"));
  EXPECT_THAT(registry.action("pkg/action/A").error().message, HasSubstr("found 1 lines of '---', expected 2"));
}

TEST(Interfaces, AnUnknownNameGivesTheNearest) {
  TempPackages packages;
  packages.write("pkg/msg/T", "zzzzzzzzzz a\n");
  Registry strange;
  ASSERT_TRUE(strange.add_packages_in(packages.folder()).ok());
  EXPECT_EQ(strange.message("pkg/msg/T").error().message,
            "found type 'zzzzzzzzzz', expected a primitive type, Name, package/Name or package/msg/Name");
  Registry registry;
  add_interfaces(registry);
  EXPECT_THAT(registry.message("std_msgs/msg/Sting").error().text(), HasSubstr("nearest is 'std_msgs/msg/String'"));
  EXPECT_THAT(registry.message("stdmsgs/msg/String").error().text(), HasSubstr("nearest is 'std_msgs'"));
  EXPECT_THAT(registry.service("std_srvs/msg/SetBool").error().text(), HasSubstr("expected a service type"));
  EXPECT_THAT(registry.action("cxlab_skills/action/Pick/Fast").error().text(), HasSubstr("expected an action type"));
  EXPECT_THAT(registry.action("example_interfaces/action/Fibonaci").error().text(), HasSubstr("Fibonacci"));
  EXPECT_FALSE(registry.message("String").ok());
  EXPECT_FALSE(registry.message("").ok());
  EXPECT_FALSE(registry.message("std_srvs/srv/SetBool").ok());
  EXPECT_FALSE(registry.message("std_msgs/msg/../../../etc/passwd").ok());
  EXPECT_FALSE(registry.message("std_msgs/msg/..").ok());
}

TEST(Interfaces, ALaterFolderReplacesAPackageUntilItIsRead) {
  TempPackages first, second;
  first.write("pkg/msg/T", "int8 a\n");
  second.write("pkg/msg/T", "int16 b\n");
  Registry registry;
  ASSERT_TRUE(registry.add_package("pkg", first.folder() / "pkg").ok());
  ASSERT_TRUE(registry.add_package("pkg", second.folder() / "pkg").ok());
  EXPECT_THAT((*registry.message("pkg/msg/T"))->field_names(), ElementsAre("b"));
  EXPECT_THAT(registry.add_package("pkg", first.folder() / "pkg").error().message, HasSubstr("already read"));
  EXPECT_THAT(registry.packages(), Contains("pkg"));
  EXPECT_THAT(registry.files_read().front().string(), EndsWith("pkg/msg/T.msg"));
}

TEST(Interfaces, OfSeveralFoldersOfAPackageTheLastOneAddedIsAskedFirst) {
  TempPackages first, second;
  first.write("pkg/msg/T", "int8 a\n");
  first.write("pkg/msg/Only", "int8 c\n");
  second.write("pkg/msg/T", "int16 b\n");
  Registry registry;
  for (const TempPackages* packages : {&first, &second, &first, &second})
    ASSERT_TRUE(registry.add_package("pkg", packages->folder() / "pkg").ok());
  EXPECT_THAT(registry.interfaces("pkg"), ElementsAre("pkg/msg/Only", "pkg/msg/T"));
  EXPECT_THAT((*registry.message("pkg/msg/T"))->field_names(), ElementsAre("b"));
  EXPECT_THAT((*registry.message("pkg/msg/Only"))->field_names(), ElementsAre("c"));
}

TEST(Interfaces, AFolderWithoutDefinitionsIsNotAPackage) {
  TempPackages packages;
  std::filesystem::create_directories(packages.folder() / "empty");
  Registry registry;
  EXPECT_FALSE(registry.add_package("empty", packages.folder() / "empty").ok());
  EXPECT_FALSE(registry.add_package("absent", packages.folder() / "absent").ok());
  EXPECT_FALSE(registry.add_packages_in(packages.folder() / "absent").ok());
  EXPECT_TRUE(registry.add_packages_in(packages.folder()).ok());
  EXPECT_TRUE(registry.packages().empty());
}

}  // namespace
}  // namespace cxlab::bus
