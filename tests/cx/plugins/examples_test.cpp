// The examples of docs/plugins run and say what they should.

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

/// All lines of an example that runs for `seconds` or until it ends itself.
std::vector<std::string> lines_of(const std::string& name, double seconds) {
  Lab lab;
  const auto folder = source_dir() / "docs" / "examples" / name;
  lab.options.packages = {{"example", {folder, {}}}};
  lab.options.config = folder / "example.yaml";
  lab.options.strict = true;
  lab.run_up();
  while (to_seconds(lab.now) < seconds && !lab.manager->shutdown_requested()) {
    const Status s = lab.tick();
    EXPECT_TRUE(s.ok()) << s.error().text();
    if (!s) break;
  }
  EXPECT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(lab.log.with("warn "), IsEmpty());
  EXPECT_THAT(lab.log.with("error "), IsEmpty());
  return lab.log.lines;
}

TEST(Examples, Executive) {
  const auto lines = lines_of("executive", 10);
  EXPECT_THAT(lines, IsSupersetOf({"info main: it is 0.0 s, 0.0 s since 1970",
                                   "info main: it is 2.0 s, 2.0 s since 1970", "info main: \033[33mgoodbye"}));
  EXPECT_THAT(lines, ::testing::Not(::testing::Contains(::testing::HasSubstr("2.5 s"))));
}

TEST(Examples, Manager) {
  EXPECT_THAT(lines_of("manager", 2), IsSupersetOf({"info main: a helper came: TRUE", "info helper: helping since 0.1",
                                                    "info main: the boss goes"}));
}

TEST(Examples, Config) {
  EXPECT_THAT(lines_of("config", 1),
              IsSupersetOf({"info main: hello R1", "info main: hello R2", "info main: 3 machines"}));
}

TEST(Examples, FileLoad) {
  EXPECT_THAT(lines_of("file_load", 1),
              IsSupersetOf({"info main: the strategy is breadth", "info main: hello world", "info main: files go"}));
}

TEST(Examples, AmentIndex) {
  EXPECT_THAT(lines_of("ament_index", 1),
              IsSupersetOf({"info main: first package: example", "info main: no package of the name nothing"}));
}

TEST(Examples, RosMsgs) {
  EXPECT_THAT(lines_of("ros_msgs", 2),
              IsSupersetOf({"info listener: \033[36mheard: it is 0.5", "info talker: the listener says: as you wish"}));
}

TEST(Examples, Bindings) {
  EXPECT_THAT(lines_of("bindings", 2),
              IsSupersetOf({"info caller: power answered TRUE", "info caller: the robot says: power TRUE",
                            "info caller: so far (0 1)", "info caller: SUCCEEDED (0 1 1 2 3 5 8)"}));
}

TEST(Examples, RosParam) {
  EXPECT_THAT(lines_of("ros_param", 1),
              IsSupersetOf({"info main: R1 drives at 0.8 m/s", "info main: tools: \"gripper\" \"camera\"",
                            "info main: tries: 3"}));
}

TEST(Examples, Protobuf) {
  EXPECT_THAT(lines_of("protobuf", 2),
              IsSupersetOf({"info referee: R1 at 127.0.0.1:4441 is IDLE at 1.5, -2.0 and sees \"C-BS\" \"C-DS\"",
                            "info robot: order 7 for R1",
                            "info referee: R1 at 127.0.0.1:4441 is BUSY at 1.5, -2.0 and sees \"C-BS\" \"C-DS\""}));
}

TEST(Examples, Tf2PoseTracker) {
  const auto lines = lines_of("tf2_pose_tracker", 5);
  EXPECT_THAT(lines, IsSupersetOf({"info watcher: gripper is at 0.5 1, seen at 0.4 s",
                                   "info watcher: gripper is at 1 1, seen at 1.4 s"}));
  EXPECT_THAT(lines, ::testing::Not(::testing::Contains(::testing::HasSubstr("seen at 2.4 s"))));
}

TEST(Examples, Example) {
  EXPECT_THAT(lines_of("example", 1),
              IsSupersetOf({"debug example: Initializing plugin for environment main", "info main: nothing was to do",
                            "info example: Destroying plugin for environment main"}));
}

}  // namespace
}  // namespace cxlab::cx
