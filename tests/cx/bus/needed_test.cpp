// Definitions of a user's package beside those that cxlab's own code was written for.

#include "cx/bus/needed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NeededTest : public ::testing::Test {
 protected:
  NeededTest() {
    own_.write("pkg/msg/Part", "string name\n");
    own_.write("pkg/msg/T", "int32 a\nstring text\nint32 extra 7\nPart part\nfloat64[2] pair\nstring<=5 short\n");
    own_.write("pkg/srv/Ask", "int32 question\n---\nint32 answer\n");
    own_.write("pkg/action/Go", "int32 to\n---\nint32 at\n---\nint32 left\n");
    set_own_definitions(own_.folder());
  }
  ~NeededTest() override { set_own_definitions({}); }

  /// Why a type of a package with these definitions is refused; empty if it is not.
  std::string refused(const std::string& name, const std::vector<std::pair<std::string, std::string>>& definitions) {
    TempPackages packages;
    for (const auto& [type, text] : definitions) packages.write(type, text);
    Registry registry;
    EXPECT_TRUE(registry.add_packages_in(packages.folder()).ok());
    const Status fits = check_needed(registry, name);
    return fits ? "" : fits.error().message;
  }
  std::string refused_message(const std::string& fields, const std::string& part = "string name\n") {
    return refused("pkg/msg/T", {{"pkg/msg/T", fields}, {"pkg/msg/Part", part}, {"pkg/msg/Other", "string name\n"}});
  }

 private:
  TempPackages own_;
};

TEST_F(NeededTest, FieldsOfAnyOrderAndMoreOfThemWillDo) {
  EXPECT_EQ(
      refused_message("string<=5 short\nfloat64[2] pair\nPart part\nbool more\nstring text\nint32 a\nint32 extra\n",
                      "bool more\nstring name\n"),
      "");
  EXPECT_EQ(refused_message("int32 a\nstring text\nPart part\nfloat64[2] pair\nstring<=5 short\n"), "")
      << "a field with a default may be lacking";
}

TEST_F(NeededTest, AFieldThatIsLackingOrOfAnotherTypeIsNamed) {
  const std::string rest = "Part part\nfloat64[2] pair\nstring<=5 short\n";
  EXPECT_THAT(refused_message("string text\n" + rest), HasSubstr("'pkg/msg/T' has no field 'a' (int32)"));
  EXPECT_THAT(refused_message("int64 a\nstring text\n" + rest),
              HasSubstr("has the field 'a' as int64 instead of int32"));
  EXPECT_THAT(refused_message("int32[] a\nstring text\n" + rest),
              HasSubstr("has the field 'a' as int32[] instead of int32"));
  EXPECT_THAT(refused_message("int32 a\nstring text\nint64 extra\n" + rest), HasSubstr("'extra' as int64"))
      << "a default does not help where the field is there";
  const std::string begin = "int32 a\nstring text\n";
  EXPECT_THAT(refused_message(begin + "Part part\nfloat64[3] pair\nstring<=5 short\n"),
              HasSubstr("'pair' as float64[3] instead of float64[2]"));
  EXPECT_THAT(refused_message(begin + "Part part\nfloat64[2] pair\nstring<=6 short\n"),
              HasSubstr("'short' as string<=6 instead of string<=5"));
  EXPECT_THAT(refused_message(begin + "Other part\nfloat64[2] pair\nstring<=5 short\n"),
              AllOf(HasSubstr("'part' as"), HasSubstr("Other instead of"), HasSubstr("Part")));
  EXPECT_THAT(refused_message(begin + rest, "string nam\n"), HasSubstr("has no field 'part.name' (string)"));
}

TEST_F(NeededTest, EachSectionOfAServiceAndAnActionIsCompared) {
  const auto service = [&](const std::string& text) { return refused("pkg/srv/Ask", {{"pkg/srv/Ask", text}}); };
  EXPECT_EQ(service("int32 question\n---\nint32 answer\n"), "");
  EXPECT_THAT(service("int32 asked\n---\nint32 answer\n"), HasSubstr("'pkg/srv/Ask_Request' has no field 'question'"));
  EXPECT_THAT(service("int32 question\n---\nbool answer\n"),
              HasSubstr("'pkg/srv/Ask_Response' has the field 'answer'"));
  const auto action = [&](const std::string& text) { return refused("pkg/action/Go", {{"pkg/action/Go", text}}); };
  EXPECT_EQ(action("int32 to\n---\nint32 at\n---\nint32 left\n"), "");
  EXPECT_THAT(action("---\nint32 at\n---\nint32 left\n"), HasSubstr("Go_Goal' has no field 'to'"));
  EXPECT_THAT(action("int32 to\n---\n---\nint32 left\n"), HasSubstr("Go_Result' has no field 'at'"));
  EXPECT_THAT(action("int32 to\n---\nint32 at\n---\n"), HasSubstr("Go_Feedback' has no field 'left'"));
}

TEST_F(NeededTest, TypesThatCxlabDoesNotHaveAreNeverRefused) {
  EXPECT_EQ(refused("pkg/msg/Mine", {{"pkg/msg/Mine", "bool anything\n"}}), "");
  EXPECT_EQ(refused("other/msg/T", {{"other/msg/T", "bool anything\n"}}), "");
  set_own_definitions({});
  EXPECT_EQ(refused("pkg/msg/T", {{"pkg/msg/T", "bool anything\n"}}), "") << "nothing of its own is known";
}

TEST_F(NeededTest, WhatIsNotOfferedIsNotedOnce) {
  TempPackages packages;
  const std::string file = packages.write("pkg/srv/Ask", "int32 asked\n---\nint32 answer\n").string();
  packages.write("pkg/action/Go", "int32 to\n---\nint32 at\n---\nint32 left\n");
  Registry registry;
  ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
  EXPECT_TRUE(can_offer(registry, "action /n/go", "pkg/action/Go"));
  EXPECT_THAT(registry.not_offered(), IsEmpty());
  EXPECT_FALSE(can_offer(registry, "service /n/ask", "pkg/srv/Ask"));
  EXPECT_FALSE(can_offer(registry, "service /n/ask", "pkg/srv/Ask"));
  EXPECT_FALSE(can_offer(registry, "service /m/ask", "pkg/srv/Ask"));
  EXPECT_THAT(registry.not_offered(), ElementsAre(AllOf(HasSubstr("service /n/ask is not offered: "), HasSubstr(file)),
                                                  HasSubstr("service /m/ask")));
  EXPECT_FALSE(needed_service(registry, "pkg/srv/Ask").ok());
  EXPECT_TRUE(needed_action(registry, "pkg/action/Go").ok());
  EXPECT_THAT(Registry().not_offered(), IsEmpty());
}

}  // namespace
}  // namespace cxlab::bus
