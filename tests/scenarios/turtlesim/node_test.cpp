// The node turtlesim on the bus: what somebody who knows it from ROS finds.

#include <cmath>
#include <limits>
#include <numbers>

#include "scenarios/stage.h"
#include "sim/box2d/turtle_world.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// An episode with the node alone, and somebody on the bus who talks to it.
class TurtlesimTest : public EpisodeTest {
 protected:
  void open(const std::string& settings = {}, const std::string& more = {}) {
    const std::string world =
        settings.empty() ? "world: {kind: turtlesim}\n" : "world: {kind: turtlesim, " + settings + "}\n";
    episode_ = load(write("canvas.yaml", "schema: 1\nduration_s: 1000\n" + world + more));
    ASSERT_TRUE(episode_);
    begin(*episode_);
    me_ = bus().join(bus::ParticipantKind::kNode, {"tester", "/", {}}, episode_->journal().open_stream("node/tester"));
  }
  bus::Bus& bus() { return episode_->bus(); }
  const sim::TurtleWorld& world() { return dynamic_cast<const sim::TurtleWorld&>(*episode_->stage().worlds.front()); }

  void play_for(double seconds) { play(*episode_, to_seconds(episode_->now()) + seconds - 1e-6); }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) ASSERT_TRUE(episode_->tick().ok());
    bus().deliver(me_);
  }

  static bus::SharedMessage message(const bus::MessageType& type, const std::string& yaml) {
    auto made = bus::Message::from_yaml(type, yaml);
    EXPECT_TRUE(made.ok()) << made.error().text();
    return std::make_shared<const bus::Message>(*std::move(made));
  }
  void publish(const std::string& topic, const std::string& type, const std::string& yaml) {
    const bus::MessageType& known = **bus().registry().message(type);
    if (!publishers_.contains(topic)) publishers_[topic] = *bus().advertise(me_, topic, known);
    bus().publish(publishers_[topic], message(known, yaml));
  }
  void drive(const std::string& turtle, const std::string& twist) {
    publish("/" + turtle + "/cmd_vel", "geometry_msgs/msg/Twist", twist);
  }

  /// The response, or "none" where nobody serves.
  std::string call(const std::string& service, const std::string& type, const std::string& yaml = "{}") {
    const bus::ServiceType& known = **bus().registry().service(type);
    std::string answer = "none";
    auto client = bus().create_client(me_, service, known,
                                      [&](const bus::Delivery& d) { answer = d.message->view().to_string(); });
    EXPECT_TRUE(client.ok()) << client.error().text();
    if (bus().service_ready(*client)) {
      bus().call(*client, message(*known.request, yaml));
      ticks(1);
    }
    bus().remove(*client);
    return answer;
  }
  /// All messages of a topic from now on.
  std::vector<bus::Message>& hear(const std::string& topic, const std::string& type) {
    auto& heard = heard_[topic];
    auto made = bus().subscribe(me_, topic, **bus().registry().message(type),
                                [&heard](const bus::Delivery& d) { heard.push_back(*d.message); });
    EXPECT_TRUE(made.ok()) << made.error().text();
    return heard;
  }

  std::unique_ptr<Episode> episode_;
  bus::ParticipantId me_{};
  std::map<std::string, bus::EndpointId> publishers_;
  std::map<std::string, std::vector<bus::Message>> heard_;
};

TEST_F(TurtlesimTest, BeginsWithOneTurtleInTheMiddle) {
  open();
  auto& poses = hear("/turtle1/pose", "turtlesim/msg/Pose");
  auto& colours = hear("/turtle1/color_sensor", "turtlesim/msg/Color");
  ticks(5);
  ASSERT_EQ(poses.size(), 5u) << "one each tick";
  EXPECT_EQ(episode_->now(), from_seconds(4 * 0.016));
  EXPECT_NEAR(poses[0]->real("x"), 5.544445, 1e-6);
  EXPECT_NEAR(poses[0]->real("y"), 5.544445, 1e-6);
  EXPECT_EQ(poses[0]->real("theta"), 0);
  EXPECT_EQ(colours.back()->to_string(), "{r: 69, g: 86, b: 255}");
  EXPECT_THAT(
      log_.with("Spawning"),
      ElementsAre("0.000 turtlesim: Spawning turtle [turtle1] at x=[5.544445], y=[5.544445], theta=[0.000000]"));
}

TEST_F(TurtlesimTest, ACommandHoldsForASecondAndTheWallWarnsEachTick) {
  open();
  auto& poses = hear("/turtle1/pose", "turtlesim/msg/Pose");
  drive("turtle1", "{linear: {x: 3.0, y: 4.0}, angular: {z: 0.0}}");
  ticks(2);
  EXPECT_EQ(poses.back()->real("linear_velocity"), 5);
  ticks(62);
  EXPECT_EQ(poses.back()->real("linear_velocity"), 0);
  EXPECT_NEAR(poses.back()->real("x"), 5.544445 + 3 * 0.992, 1e-4);
  EXPECT_THAT(log_.with("wall"), IsEmpty());
  drive("turtle1", "{linear: {x: 4.0}}");
  ticks(64);
  EXPECT_NEAR(poses.back()->real("x"), 499 / 45.0, 1e-5);
  const auto warnings = log_.with("Oh no! I hit the wall! (Clamping from [x=11.");
  EXPECT_EQ(warnings.size(), 22u) << "40 steps to the wall, then one line each";
  ticks(5);
  EXPECT_EQ(log_.with("Oh no!").size(), warnings.size()) << "it stands";
  EXPECT_EQ(episode_->result().at("turtles[0].walls"), "1");
}

TEST_F(TurtlesimTest, TeleportsAnswerAndDraw) {
  open();
  auto& colours = hear("/turtle1/color_sensor", "turtlesim/msg/Color");
  EXPECT_EQ(call("/turtle1/teleport_absolute", "turtlesim/srv/TeleportAbsolute", "{x: 2, y: 3, theta: 1.5}"), "{}");
  ticks(1);
  EXPECT_NEAR(world().turtles()[0].x, 2, 1e-6);
  EXPECT_NEAR(world().turtles()[0].theta, 1.5, 1e-6);
  EXPECT_EQ(colours.back()->to_string(), "{r: 179, g: 184, b: 255}");
  EXPECT_EQ(call("/turtle1/set_pen", "turtlesim/srv/SetPen", "{r: 1, g: 2, b: 3, width: 9, off: 0}"), "{}");
  EXPECT_EQ(call("/turtle1/teleport_relative", "turtlesim/srv/TeleportRelative", "{linear: 2, angular: 0.5}"), "{}");
  ticks(1);
  EXPECT_NEAR(world().turtles()[0].x, 2 + 2 * std::cos(2.0), 1e-5);
  EXPECT_NEAR(world().turtles()[0].y, 3 + 2 * std::sin(2.0), 1e-5);
  EXPECT_EQ(colours.back()->to_string(), "{r: 1, g: 2, b: 3}");
  call("/clear", "std_srvs/srv/Empty");
  ticks(1);
  EXPECT_EQ(colours.back()->to_string(), "{r: 69, g: 86, b: 255}");
  EXPECT_THAT(log_.with("Clearing"), ElementsAre(HasSubstr("turtlesim: Clearing turtlesim.")));
  call("/turtle1/teleport_absolute", "turtlesim/srv/TeleportAbsolute", "{x: .nan, y: 3, theta: 0}");
  EXPECT_THAT(log_.with("no number"), SizeIs(1));
  call("/turtle1/teleport_absolute", "turtlesim/srv/TeleportAbsolute", "{x: 20, y: 3, theta: 0}");
  ticks(1);
  EXPECT_NEAR(world().turtles()[0].x, 499 / 45.0, 1e-5);
  EXPECT_THAT(log_.with("Clamping from [x=20.000000, y=3.000000]"), SizeIs(1));
}

TEST_F(TurtlesimTest, TurtlesComeAndGo) {
  open();
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn", "{x: 1, y: 2, theta: 0.5}"), "{name: \"turtle2\"}");
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn", "{x: 1, y: 2, theta: 0.5, name: bob}"), "{name: \"bob\"}");
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn", "{x: 1, y: 2, theta: 0.5, name: bob}"), "{name: \"\"}");
  EXPECT_THAT(log_.with("A turtle named [bob] already exists"), SizeIs(1));
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn", "{name: 'no name'}"), "{name: \"\"}");
  auto& poses = hear("/bob/pose", "turtlesim/msg/Pose");
  ticks(3);
  EXPECT_EQ(poses.size(), 3u);
  EXPECT_EQ(call("/kill", "turtlesim/srv/Kill", "{name: bob}"), "{}");
  const auto seen = poses.size();
  ticks(3);
  EXPECT_EQ(poses.size(), seen) << "it says no more";
  EXPECT_EQ(call("/bob/teleport_absolute", "turtlesim/srv/TeleportAbsolute"), "none");
  EXPECT_EQ(call("/kill", "turtlesim/srv/Kill", "{name: bob}"), "{}");
  EXPECT_THAT(log_.with("Tried to kill turtle [bob], which does not exist"), SizeIs(1));
  EXPECT_EQ(call("/reset", "std_srvs/srv/Empty"), "{}");
  ASSERT_EQ(world().turtles().size(), 1u);
  EXPECT_NEAR(world().turtles()[0].x, 5.544445, 1e-6);
  EXPECT_EQ(call("/turtle1/set_pen", "turtlesim/srv/SetPen"), "{}");
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn"), "{name: \"turtle2\"}") << "counting begins again";
}

TEST_F(TurtlesimTest, TurnsToAnAngleAndReportsHowFar) {
  open();
  const bus::ActionType& type = **bus().registry().action("turtlesim/action/RotateAbsolute");
  std::vector<double> remaining;
  std::vector<bus::GoalStatus> ends;
  double delta = 0;
  bus::Bus::ActionClientHandlers handlers;
  handlers.feedback = [&](const bus::Delivery& d) { remaining.push_back(d.message->view().real("remaining")); };
  handlers.result = [&](const bus::Delivery& d) {
    ends.push_back(d.status);
    delta = d.message->view().real("delta");
  };
  handlers.goal_response = handlers.cancel_response = [](const bus::Delivery&) {};
  const bus::EndpointId client = *bus().create_action_client(me_, "/turtle1/rotate_absolute", type, handlers);
  const auto turn_to = [&](double theta) {
    return bus().send_goal(client, message(*type.goal, "{theta: " + std::to_string(theta) + "}"));
  };

  turn_to(1);
  ticks(80);
  ASSERT_THAT(ends, ElementsAre(bus::GoalStatus::kSucceeded));
  EXPECT_NEAR(world().turtles()[0].theta, 1, 0.02);
  EXPECT_NEAR(delta, -1, 0.03);
  ASSERT_GT(remaining.size(), 55u);
  EXPECT_NEAR(remaining[30] - remaining[31], 0.016, 1e-4) << "1 rad/s";

  turn_to(-1);
  ticks(10);
  turn_to(2);
  ticks(10);
  EXPECT_THAT(ends, ElementsAre(bus::GoalStatus::kSucceeded, bus::GoalStatus::kAborted)) << "the newer goal wins";
  drive("turtle1", "{linear: {x: 1.0}}");
  ticks(2);
  EXPECT_EQ(ends.back(), bus::GoalStatus::kAborted);
  EXPECT_EQ(world().turtles()[0].omega, 0) << "the command has taken over";

  const bus::GoalId goal = turn_to(-3);
  ticks(5);
  bus().cancel_goal(client, goal);
  ticks(3);
  EXPECT_EQ(ends.back(), bus::GoalStatus::kCanceled);
  EXPECT_EQ(world().turtles()[0].omega, 0);
  EXPECT_EQ(ends.size(), 4u);
}

TEST_F(TurtlesimTest, TheBackgroundIsAParameter) {
  open("background_r: 10");
  auto& colours = hear("/turtle1/color_sensor", "turtlesim/msg/Color");
  ticks(1);
  EXPECT_EQ(colours.back()->to_string(), "{r: 10, g: 86, b: 255}");
  EXPECT_THAT(call("/turtlesim/set_parameters", "rcl_interfaces/srv/SetParameters",
                   "{parameters: [{name: background_g, value: {type: 2, integer_value: 7}}, {name: background_b, "
                   "value: {type: 2, integer_value: 256}},"
                   " {name: pen, value: {type: 2}}]}"),
              testing::AllOf(HasSubstr("successful: true"), HasSubstr("found 256, expected 0 to 255"),
                             HasSubstr("'pen' cannot be set")));
  ticks(1);
  EXPECT_EQ(colours.back()->to_string(), "{r: 10, g: 7, b: 255}");
  EXPECT_THAT(call("/turtlesim/get_parameters", "rcl_interfaces/srv/GetParameters", "{names: [background_g]}"),
              HasSubstr("integer_value: 7"));
  EXPECT_THAT(call("/turtlesim/list_parameters", "rcl_interfaces/srv/ListParameters"), HasSubstr("background_b"));
}

TEST_F(TurtlesimTest, NamesFollowNamespaceAndRemaps) {
  open("namespace: /pond, remap: {turtle1/cmd_vel: /joystick}");
  EXPECT_EQ(call("/pond/turtle1/teleport_absolute", "turtlesim/srv/TeleportAbsolute", "{x: 1, y: 1}"), "{}");
  publish("/joystick", "geometry_msgs/msg/Twist", "{linear: {x: 1.0}}");
  ticks(5);
  EXPECT_GT(world().turtles()[0].x, 1.03);
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn"), "none");
  EXPECT_EQ(call("/pond/spawn", "turtlesim/srv/Spawn"), "{name: \"turtle2\"}");
}

TEST_F(TurtlesimTest, ANodeThatIsStoppedSaysAndDoesNothingAnyMore) {
  episode_ = load(
      write("stopped.yaml",
            "schema: 1\nworld: {kind: turtlesim}\nduration_s: 60\nstimuli:\n  - {at: 8.5, stop_node: /turtlesim}\n"));
  ASSERT_TRUE(episode_);
  begin(*episode_);
  me_ = bus().join(bus::ParticipantKind::kNode, {"tester", "/", {}}, episode_->journal().open_stream("node/tester"));
  for (int second = 0; second < 8; ++second) {
    drive("turtle1", "{linear: {x: 2.0}}");
    play(*episode_, second + 1.0);
  }
  EXPECT_THAT(log_.with("I hit the wall"), ::testing::Not(::testing::IsEmpty()));
  drive("turtle1", "{linear: {x: 2.0}}");
  play(*episode_, 8.6);
  EXPECT_THAT(log_.with("/turtlesim: stopped"), SizeIs(1));
  const auto said = log_.all.size();
  play(*episode_, 12);
  EXPECT_EQ(log_.all.size(), said) << "it is at the wall all the while";
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn"), "none");
}

TEST_F(TurtlesimTest, TurtlesThatCollidePushEachOther) {
  for (const bool collisions : {false, true}) {
    open(std::string("collisions: ") + (collisions ? "true" : "false") +
         ", turtles: [{name: a, x: 4}, {name: b, x: 6}]");
    for (int i = 0; i < 3; ++i) {
      drive("a", "{linear: {x: 1.0}}");
      play_for(0.9);
    }
    const double gap = world().turtles()[1].x - world().turtles()[0].x;
    EXPECT_EQ(gap > 0.85, collisions) << gap;
    EXPECT_EQ(episode_->result().at("turtles[1].touches"), collisions ? "1" : "0");
    publishers_.clear();
  }
  EXPECT_THAT(log_.with("bumps into"), SizeIs(1));
}

TEST_F(TurtlesimTest, StandsBesideAnotherWorldAndComesLate) {
  episode_ = load(
      write("late.yaml", "schema: 1\nduration_s: 60\ntick_s: 0.02\nservers:\n  - {node: turtlesim, start_s: 5}\n"));
  ASSERT_TRUE(episode_);
  begin(*episode_);
  me_ = bus().join(bus::ParticipantKind::kNode, {"tester", "/", {}}, episode_->journal().open_stream("node/tester"));
  auto& poses = hear("/turtle1/pose", "turtlesim/msg/Pose");
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn"), "none");
  EXPECT_LT(episode_->now(), from_seconds(5));
  play(*episode_, 5);
  bus().deliver(me_);
  EXPECT_EQ(poses.size(), 1u);
  EXPECT_EQ(call("/spawn", "turtlesim/srv/Spawn"), "{name: \"turtle2\"}");
  play(*episode_, 6);
  bus().deliver(me_);
  EXPECT_NEAR(static_cast<double>(poses.size()), 51, 1)
      << "ticks of 20 ms, a step of 16 ms in most of them: one pose a tick";
}

TEST_F(TurtlesimTest, AnyTickTakesTheStepsThatAreDue) {
  open("turtles: [{name: turtle1, x: 1, y: 1}]", "tick_s: 0.1\n");
  drive("turtle1", "{linear: {x: 1.0}}");
  play(*episode_, 1.6);
  EXPECT_EQ(world().steps(), 100);
  EXPECT_NEAR(world().turtles()[0].x, 1.992, 1e-4);
}

TEST_F(TurtlesimTest, WrongSettingsAreReportedWithTheirLine) {
  const auto error = [&](const std::string& text) {
    auto scenario = Scenario::parse("schema: 1\n" + text, "x.yaml", shipped());
    return scenario ? std::string("none") : scenario.error().text();
  };
  EXPECT_EQ(error("world: {kind: turtlesim}\n"), "none");
  EXPECT_THAT(error("world:\n  kind: turtlesim\n  background_r: 300\n"),
              HasSubstr("x.yaml:4: world.background_r: found 300, expected 0 to 255"));
  EXPECT_THAT(error("world: {kind: turtlesim, colisions: true}\n"), HasSubstr("did you mean 'collisions'"));
  EXPECT_THAT(error("servers:\n  - turtlesin\n"),
              HasSubstr("x.yaml:3: servers[0]: found 'turtlesin', expected one of: "));
  EXPECT_THAT(error("servers:\n  - {node: turtlesim, turtles: [{name: 1a}]}\n"), HasSubstr("'1a'"));
}

}  // namespace
}  // namespace cxlab
