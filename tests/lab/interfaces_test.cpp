#include "lab/interfaces.h"

#include <gmock/gmock.h>

#include "folder.h"

namespace cxlab::lab {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

class InterfacesTest : public FolderTest {
 protected:
  Interfaces with_own() const {
    write("own/msg/Inner.msg", "# about inner\nint32 FIRST=1\nint32 a  # one\n\nstring b\n");
    write("own/msg/Outer.msg", "# about outer\nInner one  # the first\nown/Inner[3] many\ngeometry_msgs/Point point\n");
    write("own/srv/Ask.srv", "Inner question\n---\nbool yes\n");
    return *Interfaces::load({{"own", path("own").string()}});
  }
};

TEST_F(InterfacesTest, NestedFieldsAreIndentedWithoutTheirComments) {
  const auto text = with_own().show("own/msg/Outer");
  ASSERT_TRUE(text) << text.error().text();
  EXPECT_EQ(
      *text,
      "# about outer\nInner one  # the first\n\tint32 FIRST=1\n\tint32 a\n\tstring b\nown/Inner[3] many\n"
      "\tint32 FIRST=1\n\tint32 a\n\tstring b\ngeometry_msgs/Point point\n\tfloat64 x\n\tfloat64 y\n\tfloat64 z\n");
}

TEST_F(InterfacesTest, ServicesAndActionsHaveTheirSections) {
  EXPECT_EQ(*with_own().show("own/srv/Ask"), "Inner question\n\tint32 FIRST=1\n\tint32 a\n\tstring b\n---\nbool yes\n");
  const auto action = with_own().show("rcll_interfaces/action/InstructMachine");
  ASSERT_TRUE(action) << action.error().text();
  EXPECT_THAT(*action, HasSubstr("---\n"));
}

TEST_F(InterfacesTest, EveryInterfaceCanBeShown) {
  Interfaces all = with_own();
  EXPECT_THAT(all.names(), Contains("rcll_interfaces/msg/Order"));
  for (const std::string& name : all.names()) EXPECT_TRUE(all.show(name)) << name;
}

TEST_F(InterfacesTest, MessagesAreFoundWithoutTheirFolder) {
  EXPECT_THAT(*with_own().show("rcll_interfaces/Order"), StartsWith("# An order that has been released.\n"));
}

TEST_F(InterfacesTest, AnUnknownNameGetsASuggestion) {
  const auto text = with_own().show("rcll_interfaces/msg/Oder");
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().text(), HasSubstr("did you mean 'rcll_interfaces/msg/Order'?"));
}

}  // namespace
}  // namespace cxlab::lab
