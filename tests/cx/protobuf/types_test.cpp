#include "cx/protobuf/types.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <map>

namespace cxlab::pb {
namespace {

using ::testing::ElementsAre;

constexpr const char* kRobot = R"(syntax = "proto2";
package team;
import "pose.proto";
message Robot {
  enum CompType { COMP_ID = 2000; MSG_TYPE = 31; }
  required string name = 1;
  optional Pose pose = 2;
  message Gripper {
    enum CompType { COMP_ID = 2000; MSG_TYPE = 32; }
    optional bool closed = 1;
  }
}
)";
constexpr const char* kPose = R"(syntax = "proto2";
package team;
message Pose { optional double x = 1; }
)";

class TypesTest : public ::testing::Test {
 protected:
  Status add(const std::string& file) { return types_.add_file(file); }
  std::string error_of(const std::string& file) {
    const Status s = add(file);
    return s ? "no error" : s.error().text();
  }

  std::map<std::string, std::string> files_{{"robot.proto", kRobot}, {"pose.proto", kPose}};
  Types types_{[this](const std::string& file) -> Expected<std::optional<Types::Source>> {
    const auto found = files_.find(file);
    if (found == files_.end()) return std::optional<Types::Source>();
    return std::optional(Types::Source{found->second, "/protos/" + file});
  }};
};

TEST_F(TypesTest, FilesAreReadWithWhatTheyImport) {
  ASSERT_TRUE(add("robot.proto").ok());
  EXPECT_THAT(types_.names(), ElementsAre("team.Pose", "team.Robot", "team.Robot.Gripper"));
  EXPECT_TRUE(add("pose.proto").ok());  // again
  EXPECT_EQ(types_.names().size(), 3u);
  EXPECT_EQ(types_.find(MessageKey{2000, 31}), types_.find("team.Robot"));
  EXPECT_EQ(types_.find(MessageKey{2000, 32}), types_.find("team.Robot.Gripper"));
  EXPECT_EQ(types_.find(MessageKey{31, 2000}), nullptr);
  EXPECT_EQ(types_.make("team.Nobody"), nullptr);
}

TEST_F(TypesTest, ErrorsHaveTheirLine) {
  files_["bad.proto"] = "syntax = \"proto2\";\nmessage M {\n  optional strin a = 1;\n}\n";
  EXPECT_EQ(error_of("bad.proto"), "/protos/bad.proto:3: \"strin\" is not defined.");
  files_["cut.proto"] = "syntax = \"proto2\";\nmessage M {\n";
  EXPECT_EQ(error_of("cut.proto"), "/protos/cut.proto:3: Reached end of input in message definition (missing '}').");
  files_["lost.proto"] = "syntax = \"proto2\";\n\nimport \"nowhere.proto\";\n";
  EXPECT_EQ(error_of("lost.proto"), "/protos/lost.proto:3: Import \"nowhere.proto\" was not found or had errors.");
  EXPECT_EQ(error_of("none.proto"), "none.proto: there is no such file among the .proto files");
  EXPECT_TRUE(add("robot.proto").ok());  // the others are read all the same
}

TEST_F(TypesTest, MessagesTravelInFrames) {
  ASSERT_TRUE(add("robot.proto").ok());
  auto robot = types_.make("team.Robot");
  EXPECT_EQ(Types::write(*robot).error().message, "team.Robot lacks required fields: name");
  robot->GetReflection()->SetString(robot.get(), robot->GetDescriptor()->FindFieldByName("name"), "R1");
  const auto bytes = Types::write(*robot);
  ASSERT_TRUE(bytes.ok());
  auto read = types_.read(*read_datagram(*bytes));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ((*read)->ShortDebugString(), "name: \"R1\"");
  EXPECT_EQ(types_.read({{1, 2}, ""}).error().message, "Message type 1:2 not registered");
  EXPECT_EQ(types_.read({{2000, 31}, ""}).error().message, "team.Robot lacks required fields: name");
  EXPECT_EQ(types_.read({{2000, 31}, "\x0a\xff"}).error().message, "the bytes are no team.Robot");
  EXPECT_EQ(Types::write(*types_.make("team.Pose")).error().message,
            "team.Pose has no enum CompType with COMP_ID and MSG_TYPE");
}

TEST_F(TypesTest, TypesAreRegisteredByName) {
  files_["twin.proto"] = "syntax = \"proto2\";\nmessage Twin { enum CompType { COMP_ID = 2000; MSG_TYPE = 31; } }\n";
  ASSERT_TRUE(add("robot.proto").ok());
  ASSERT_TRUE(add("twin.proto").ok());
  EXPECT_TRUE(types_.register_type("team.Robot").ok());
  EXPECT_EQ(types_.register_type("Twin").error().message, "message type 2000:31 is team.Robot already");
  EXPECT_EQ(types_.register_type("team.Pose").error().message, "it has no enum CompType with COMP_ID and MSG_TYPE");
  EXPECT_EQ(types_.register_type("team.Robott").error().message,
            "there is no message type 'team.Robott', did you mean 'team.Robot'?");
}

}  // namespace
}  // namespace cxlab::pb
