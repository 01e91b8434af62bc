#include "cx/bus/transforms.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kPi = 3.14159265358979323846;

Transform at(double x, double y, double yaw = 0) { return planar(x, y, yaw); }
double yaw_of(const Transform& t) { return 2 * std::atan2(t.rotation.z(), t.rotation.w()); }
SimTime s(double seconds) { return from_seconds(seconds); }

/// The message of a lookup that must fail.
std::string error_of(const Expected<TransformBuffer::Stamped>& found) {
  EXPECT_FALSE(found.ok());
  return found ? std::string() : found.error().message;
}

TEST(Transforms, AChainGoesThroughTheCommonAncestor) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("map", "robot1", s(1), at(2, 0, kPi / 2)).ok());
  ASSERT_TRUE(tf.set("map", "robot2", s(1), at(2, 3)).ok());
  ASSERT_TRUE(tf.set("robot1", "gripper1", {}, at(0.5, 0), true).ok());
  auto gripper = tf.lookup("map", "gripper1");
  ASSERT_TRUE(gripper.ok());
  EXPECT_NEAR(gripper->pose.translation.x(), 2, 1e-12);
  EXPECT_NEAR(gripper->pose.translation.y(), 0.5, 1e-12);
  EXPECT_EQ(gripper->stamp, s(1));
  auto other = tf.lookup("gripper1", "robot2");
  ASSERT_TRUE(other.ok());
  EXPECT_NEAR(other->pose.translation.x(), 2.5, 1e-12);
  EXPECT_NEAR(other->pose.translation.y(), 0, 1e-12);
  EXPECT_NEAR(yaw_of(other->pose), -kPi / 2, 1e-12);
}

TEST(Transforms, BetweenTwoTimesPosesAreInterpolatedOnTheShorterArc) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("map", "robot", s(1), at(0, 0, 0.9 * kPi)).ok());
  ASSERT_TRUE(tf.set("map", "robot", s(2), at(4, 2, -0.9 * kPi)).ok());
  auto quarter = tf.lookup("map", "robot", s(1.25));
  ASSERT_TRUE(quarter.ok());
  EXPECT_NEAR(quarter->pose.translation.x(), 1, 1e-12);
  EXPECT_NEAR(quarter->pose.translation.y(), 0.5, 1e-12);
  EXPECT_NEAR(yaw_of(quarter->pose), 0.95 * kPi, 1e-12);
  EXPECT_NEAR(quarter->pose.rotation.norm(), 1, 1e-12);
}

TEST(Transforms, TurnsInSpaceAreInvertedAndChained) {
  TransformBuffer tf;
  const double half = std::sqrt(0.5);
  ASSERT_TRUE(tf.set("map", "arm", s(1), {{1, 2, 3}, {half, half, 0, 0}}).ok());  // a quarter about x: y becomes z
  ASSERT_TRUE(tf.set("arm", "tool", s(1), {{0, 0, 1}, {1, 0, 0, 0}}).ok());
  const Transform tool = tf.lookup("map", "tool")->pose, map = tf.lookup("arm", "map")->pose;
  EXPECT_NEAR(tool.translation.x(), 1, 1e-12);
  EXPECT_NEAR(tool.translation.y(), 1, 1e-12);
  EXPECT_NEAR(tool.translation.z(), 3, 1e-12);
  EXPECT_NEAR(map.translation.x(), -1, 1e-12);
  EXPECT_NEAR(map.translation.y(), -3, 1e-12);
  EXPECT_NEAR(map.translation.z(), 2, 1e-12);
}

TEST(Transforms, OfTwoWithOneStampTheLaterCounts) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("map", "robot", s(1), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("map", "robot", s(1), at(2, 0)).ok());
  ASSERT_TRUE(tf.set("map", "robot", s(2), at(4, 0)).ok());
  EXPECT_DOUBLE_EQ(tf.lookup("map", "robot", s(1))->pose.translation.x(), 2);
  EXPECT_DOUBLE_EQ(tf.lookup("map", "robot", s(1.5))->pose.translation.x(), 3);
}

TEST(Transforms, AStaticFrameStaysStatic) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("map", "dock", s(1), at(1, 0), true).ok());
  ASSERT_TRUE(tf.set("map", "dock", s(5), at(9, 0)).ok());
  const auto later = tf.lookup("map", "dock", s(7));
  ASSERT_TRUE(later.ok());
  EXPECT_DOUBLE_EQ(later->pose.translation.x(), 9);
}

TEST(Transforms, TheLatestCommonTimeIsThatOfTheSlowestFrame) {
  TransformBuffer tf;
  for (const double t : {0.0, 1.0, 2.0}) ASSERT_TRUE(tf.set("map", "a", s(t), at(t, 0)).ok());
  for (const double t : {0.5, 1.5}) ASSERT_TRUE(tf.set("a", "b", s(t), at(0, t)).ok());
  auto found = tf.lookup("map", "b");
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->stamp, s(1.5));
  EXPECT_DOUBLE_EQ(found->pose.translation.x(), 1.5);
  EXPECT_DOUBLE_EQ(found->pose.translation.y(), 1.5);
}

TEST(Transforms, ErrorsAreThoseOfTf2) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("map", "once", s(1), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("map", "robot", s(1), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("map", "robot", s(2), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("odom", "camera", s(1), at(0, 0)).ok());
  EXPECT_EQ(error_of(tf.lookup("map", "nobody")),
            "\"nobody\" passed to lookupTransform argument source_frame does not exist. ");
  EXPECT_EQ(error_of(tf.lookup("", "robot")),
            "Invalid argument passed to lookupTransform argument target_frame in tf2 frame_ids cannot be empty");
  EXPECT_EQ(error_of(tf.lookup("map", "/robot")),
            "Invalid argument \"/robot\" passed to lookupTransform argument source_frame in tf2 frame_ids cannot start "
            "with a '/' like: ");
  EXPECT_EQ(error_of(tf.lookup("map", "camera")),
            "Could not find a connection between 'camera' and 'map' because they are not part of the same tree.Tf has "
            "two or more unconnected trees.");
  EXPECT_EQ(error_of(tf.lookup("map", "robot", s(2.5))),
            "Lookup would require extrapolation into the future.  Requested time 2.500000 but the latest data is at "
            "time 2.000000, "
            "when looking up transform from frame [robot] to frame [map]");
  EXPECT_EQ(error_of(tf.lookup("map", "robot", s(0.5))),
            "Lookup would require extrapolation into the past.  Requested time 0.500000 but the earliest data is at "
            "time 1.000000, "
            "when looking up transform from frame [robot] to frame [map]");
  EXPECT_EQ(error_of(tf.lookup("map", "once", s(3))),
            "Lookup would require extrapolation at time 3.000000, but only time 1.000000 is in the buffer, when "
            "looking up transform from "
            "frame [once] to frame [map]");
}

TEST(Transforms, WhatMakesNoTreeIsRefused) {
  TransformBuffer tf;
  const auto refusal = [&](const char* parent, const char* child, const Transform& t) {
    const Status set = tf.set(parent, child, s(1), t);
    EXPECT_FALSE(set.ok());
    return set ? std::string() : set.error().message;
  };
  ASSERT_TRUE(tf.set("a", "b", s(1), at(1, 0)).ok());
  ASSERT_TRUE(tf.set("b", "c", s(1), at(1, 0)).ok());
  EXPECT_THAT(refusal("c", "a", at(1, 0)), HasSubstr("TF_LOOP: Ignoring transform for child_frame_id \"a\""));
  EXPECT_THAT(refusal("a", "a", at(1, 0)), HasSubstr("TF_SELF_TRANSFORM"));
  EXPECT_THAT(refusal("", "d", at(1, 0)), HasSubstr("TF_NO_FRAME_ID"));
  EXPECT_THAT(refusal("a", "/", at(1, 0)), HasSubstr("TF_NO_CHILD_FRAME_ID"));
  EXPECT_THAT(refusal("a", "d", at(std::numeric_limits<double>::quiet_NaN(), 0)), HasSubstr("TF_NAN_INPUT"));
  EXPECT_THAT(refusal("a", "d", {{0, 0, 0}, {0, 0, 0, 0}}), HasSubstr("TF_DENORMALIZED_QUATERNION"));
  EXPECT_THAT(refusal("a", "d", {{0, 0, 0}, {1.02, 0, 0, 0}}), HasSubstr("TF_DENORMALIZED_QUATERNION"));
  EXPECT_TRUE(tf.set("a", "e", s(1), {{0, 0, 0}, {1.004, 0, 0, 0}}).ok()) << "rounded";
  EXPECT_DOUBLE_EQ(tf.lookup("a", "c")->pose.translation.x(), 2) << "what was refused left nothing behind";
}

TEST(Transforms, ALoopInThePastIsAnError) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("b", "a", s(1), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("c", "a", s(2), at(0, 0)).ok());
  ASSERT_TRUE(tf.set("a", "b", s(1), at(0, 0)).ok()) << "now the tree has no loop";
  EXPECT_EQ(error_of(tf.lookup("c", "a", s(1))), "The tf tree is invalid because it contains a loop.");
}

TEST(Transforms, OldOnesAreForgotten) {
  TransformBuffer tf;
  for (const double t : {0.0, 5.0, 12.0}) ASSERT_TRUE(tf.set("map", "robot", s(t), at(t, 0)).ok());
  EXPECT_THAT(error_of(tf.lookup("map", "robot", s(4))), HasSubstr("earliest data is at time 5.000000"));
  const Status late = tf.set("map", "robot", s(1), at(0, 0));
  ASSERT_FALSE(late.ok());
  EXPECT_THAT(late.error().message, HasSubstr("TF_OLD_DATA"));
}

TEST(Transforms, AFrameMayMoveToAnotherParent) {
  TransformBuffer tf;
  ASSERT_TRUE(tf.set("shelf", "piece", s(1), at(1, 0)).ok());
  ASSERT_TRUE(tf.set("gripper", "piece", s(2), at(0, 0)).ok());
  EXPECT_DOUBLE_EQ(tf.lookup("shelf", "piece", s(1.5))->pose.translation.x(), 1);
  EXPECT_TRUE(tf.lookup("gripper", "piece").ok());
  EXPECT_FALSE(tf.lookup("shelf", "piece").ok());
}

class TransformTopics : public BusTest {
 protected:
  std::unique_ptr<TransformListener> listen(ParticipantId p) {
    auto made = TransformListener::create(bus_, p, [this](const std::string& text) { refused_.push_back(text); });
    EXPECT_TRUE(made.ok());
    return *std::move(made);
  }
  std::vector<std::string> refused_;
};

TEST_F(TransformTopics, WhatAServerPostsIsThereInTheSameTick) {
  auto server = TransformBroadcaster::create(bus_, node("world"));
  ASSERT_TRUE(server.ok());
  const ParticipantId agent = environment("agent");
  auto listener = listen(agent);
  tick();
  server->set("map", "robot", at(1, 2));
  server->set_static("robot", "gripper", at(0.5, 0));
  server->post();
  bus_.deliver(agent);
  auto found = listener->buffer().lookup("map", "gripper");
  ASSERT_TRUE(found.ok());
  EXPECT_DOUBLE_EQ(found->pose.translation.x(), 1.5);
  EXPECT_EQ(found->stamp, now_);
  server->post();
  EXPECT_FALSE(bus_.has_waiting(agent)) << "nothing new, no message";
}

TEST_F(TransformTopics, AStampHasSecondsAndNanoseconds) {
  const MessageType& type = **registry_.message("tf2_msgs/msg/TFMessage");
  auto server = TransformBroadcaster::create(bus_, node("world"));
  const ParticipantId agent = environment("agent");
  std::string header;
  ASSERT_TRUE(bus_.subscribe(agent, "/tf", type, [&](const Delivery& d) {
    header = d.message->view().nested("transforms", 0).nested("header").to_string();
  }));
  bus_.begin_tick(SimTime{12'345'678'901});
  server->set("map", "robot", at(1, 2));
  server->post();
  bus_.deliver(agent);
  EXPECT_EQ(header, "{stamp: {sec: 12, nanosec: 345678901}, frame_id: \"map\"}");
}

TEST_F(TransformTopics, WhoListensLaterGetsTheStaticOnes) {
  auto server = TransformBroadcaster::create(bus_, node("world"));
  tick();
  server->set_static("map", "dock", at(1, 0));
  server->set("map", "robot", at(1, 0));
  server->post();
  server->set_static("map", "shelf", at(2, 0));
  server->post();
  server->set_static("map", "dock", at(3, 0));
  server->post();
  const ParticipantId agent = environment("agent");
  auto listener = listen(agent);
  bus_.deliver(agent);
  EXPECT_THAT(listener->buffer().frames(), ElementsAre("dock", "map", "shelf"));
  EXPECT_DOUBLE_EQ(listener->buffer().lookup("map", "dock")->pose.translation.x(), 3);
  EXPECT_THAT(refused_, IsEmpty());
}

TEST_F(TransformTopics, TheStaticOnesOfAPublisherThatIsGoneAreGone) {
  const ParticipantId world = node("world");
  auto server = TransformBroadcaster::create(bus_, world);
  auto other = TransformBroadcaster::create(bus_, node("other"));
  tick();
  server->set_static("map", "dock", at(1, 0));
  server->post();
  other->set_static("map", "shelf", at(2, 0));
  other->post();
  bus_.leave(world);
  tick();
  const ParticipantId agent = environment("agent");
  auto listener = listen(agent);
  bus_.deliver(agent);
  EXPECT_THAT(listener->buffer().frames(), ElementsAre("map", "shelf"));
}

TEST_F(TransformTopics, RemapsOfTheListenerHold) {
  auto server =
      TransformBroadcaster::create(bus_, join(ParticipantKind::kNode, "world", {"world", "/", {{"/tf", "/r1/tf"}}}));
  const ParticipantId agent = join(ParticipantKind::kEnvironment, "agent", {"agent", "/r1", {{"/tf", "tf"}}});
  auto listener = listen(agent);
  tick();
  server->set("map", "robot", at(1, 0));
  server->post();
  bus_.deliver(agent);
  EXPECT_THAT(listener->buffer().frames(), ElementsAre("map", "robot"));
}

TEST_F(TransformTopics, ARefusedTransformIsToldAndTheRestIsTaken) {
  auto server = TransformBroadcaster::create(bus_, node("world"));
  const ParticipantId agent = environment("agent");
  auto listener = listen(agent);
  tick();
  server->set("a", "a", at(1, 0));
  server->set("a", "b", at(1, 0));
  server->post();
  bus_.deliver(agent);
  EXPECT_THAT(refused_,
              ElementsAre(HasSubstr("Failure to set received transform from a to a with error: TF_SELF_TRANSFORM")));
  EXPECT_TRUE(listener->buffer().lookup("a", "b").ok());
}

}  // namespace
}  // namespace cxlab::bus
