#include "cx/bus/transforms.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Tf2PoseTracker : public ::testing::Test {
 protected:
  void SetUp() override {
    lab_.options.stop_on_rule_error = false;
    lab_.config(R"(environments: ["main"]
main: {plugins: ["executive", "tracker", "files"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
tracker: {plugin: "cx::Tf2PoseTrackerPlugin", spin_thread: true}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
    world_ = lab_.bus.join(bus::ParticipantKind::kNode, {"world", "/", {}}, lab_.records.open_stream("node/world"));
    auto made = bus::TransformBroadcaster::create(lab_.bus, world_);
    ASSERT_TRUE(made.ok());
    server_.emplace(*std::move(made));
  }
  void run_up(const std::string& rules = "") {
    lab_.write("agent/rules.clp", rules);
    lab_.run_up();
  }
  /// A tick in which the world posts the robot at `x`, if it is given.
  void tick(std::optional<double> x = {}) {
    lab_.bus.begin_tick(lab_.now);
    if (x) server_->set("map", "robot", bus::planar(*x, 0, 0));
    server_->post();
    lab_.ticks(1);
  }
  std::string eval(const std::string& expression) { return lab_.engine().eval(expression)->print(); }
  std::vector<std::string> poses() { return lab_.facts("tf2-tracked-pose"); }

  Lab lab_;
  bus::ParticipantId world_{};
  std::optional<bus::TransformBroadcaster> server_;
};

TEST_F(Tf2PoseTracker, LooksUpAfterEachPeriodAndModifiesOneFact) {
  run_up("(defrule seen (tf2-tracked-pose (stamp ?s) (translation $?t)) => (println \"at \" ?s \": \" ?t))");
  EXPECT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  for (int i = 0; i <= 4; ++i) tick(i * 0.5);  // 0 to 80 ms
  EXPECT_THAT(poses(), IsEmpty()) << "the first lookup is due after one period";
  tick(2.5);  // 100 ms
  EXPECT_THAT(poses(), ElementsAre("(tf2-tracked-pose (parent \"map\") (child \"robot\") (stamp 0.1) (translation 2.5 "
                                   "0 0) (rotation 0 0 0 1) (timer <Pointer-C-0x1>))"));
  EXPECT_THAT(lab_.log.with("at 0.1: (2.5 0 0)"), SizeIs(1))
      << "before the rules of the same tick, whole numbers are INTEGERs";
  for (int i = 6; i <= 10; ++i) tick(i * 0.5);  // until 200 ms
  EXPECT_THAT(poses(), ElementsAre(HasSubstr("(stamp 0.2) (translation 5 0 0)")));
  EXPECT_THAT(lab_.log.with("info main: at "), SizeIs(2));
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST_F(Tf2PoseTracker, DueTimesAreNotAccumulated) {
  run_up("(defrule seen (tf2-tracked-pose (stamp ?s)) => (println \"at \" ?s))");
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 3.0)"), "TRUE");
  for (int i = 0; i <= 100; ++i) tick(0.1 * i);  // until 2 s
  // k / 3 s at the first tick of 20 ms not before: 0.34 0.68 1.0 1.34 1.68 2.0
  std::vector<std::string> at;
  for (const std::string& line : lab_.log.with("info main: at ")) at.push_back(line.substr(line.rfind(' ') + 1));
  EXPECT_THAT(at, ElementsAre("0.34", "0.68", "1.0", "1.34", "1.68", "2.0"));
}

TEST_F(Tf2PoseTracker, DueTimesThatALongTickStepsOverAreOneLookup) {
  run_up("(defrule seen (tf2-tracked-pose (stamp ?s)) => (println \"at \" ?s))");
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  lab_.now = std::chrono::seconds(1);
  for (int i = 0; i <= 5; ++i) tick(0.1 * i);  // until 1.1 s
  EXPECT_THAT(lab_.log.with("info main: at "), ElementsAre("info main: at 1.0", "info main: at 1.1"));
}

TEST_F(Tf2PoseTracker, AFailedLookupIsAWarningEachPeriodAndGoesOn) {
  run_up();
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  for (int i = 0; i <= 10; ++i) tick();
  EXPECT_THAT(
      lab_.log.with("warn "),
      ElementsAre(
          "warn tracker: TF lookup failed: \"map\" passed to lookupTransform argument target_frame does not exist. ",
          "warn tracker: TF lookup failed: \"map\" passed to lookupTransform argument target_frame does not exist. "));
  for (int i = 0; i < 5; ++i) tick(1);
  EXPECT_THAT(poses(), SizeIs(1));
}

TEST_F(Tf2PoseTracker, ARetractedFactComesAgainWithAWarning) {
  run_up("(defrule drop (time ?t&:(< 0.11 ?t 0.13)) ?f <- (tf2-tracked-pose) => (retract ?f))");
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  for (int i = 0; i <= 7; ++i) tick(1);
  EXPECT_THAT(poses(), IsEmpty());
  for (int i = 8; i <= 10; ++i) tick(1);
  EXPECT_THAT(poses(), SizeIs(1));
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn tracker: the tf2-tracked-pose of robot in map was retracted, asserting a new one"));
}

TEST_F(Tf2PoseTracker, AResetTakesTheFactOnly) {
  run_up("(deffacts other (a) (b) (c))");
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  for (int i = 0; i <= 5; ++i) tick(1);
  lab_.engine().reset();
  for (int i = 0; i <= 5; ++i) tick(1);
  EXPECT_THAT(poses(), SizeIs(1));
  EXPECT_THAT(lab_.facts("a"), SizeIs(1));
}

TEST_F(Tf2PoseTracker, StoppingKeepsTheFactAndATimerStopsOnce) {
  run_up(
      "(defrule stop (time ?t&:(> ?t 0.15)) (tf2-tracked-pose (timer ?timer)) => (println \"stopped \" "
      "(tf2-stop-periodic-lookup ?timer)))");
  ASSERT_EQ(eval("(tf2-start-periodic-lookup map robot 10.0)"), "TRUE");
  for (int i = 0; i <= 20; ++i) tick(1.0 * i);
  EXPECT_THAT(poses(), ElementsAre(HasSubstr("(stamp 0.1)")));
  EXPECT_THAT(lab_.log.with("info main: stopped TRUE"), SizeIs(1));
  EXPECT_THAT(lab_.log.with("warn tracker: tf2-stop-periodic-lookup: invalid pointer!"), SizeIs(Ge(1U)));
}

TEST_F(Tf2PoseTracker, ARateHasToBeAFloatAboveZero) {
  run_up();
  EXPECT_EQ(eval("(tf2-start-periodic-lookup map robot 0.0)"), "FALSE");
  EXPECT_EQ(eval("(tf2-start-periodic-lookup map robot -1.0)"), "FALSE");
  EXPECT_THAT(lab_.log.with("error tracker: Failed to create pose updater: "), SizeIs(2));
  EXPECT_FALSE(lab_.engine().eval("(tf2-start-periodic-lookup map robot 10)").ok());
  EXPECT_THAT(
      lab_.log.with("[ARGACCES2] Function 'tf2-start-periodic-lookup' expected argument #3 to be of type float"),
      SizeIs(1));
}

TEST_F(Tf2PoseTracker, WhatTheBufferRefusesIsAnErrorLine) {
  run_up();
  lab_.bus.begin_tick(lab_.now);
  server_->set("robot", "robot", {});
  tick();
  EXPECT_THAT(
      lab_.log.with("error "),
      ElementsAre(HasSubstr(
          "error tracker: Failure to set received transform from robot to robot with error: TF_SELF_TRANSFORM")));
}

TEST_F(Tf2PoseTracker, StaticTransformsFromBeforeAreThere) {
  lab_.bus.begin_tick(lab_.now);
  server_->set_static("map", "dock", bus::planar(1.25, 2, 0));
  server_->post();
  run_up();
  ASSERT_EQ(eval("(tf2-start-periodic-lookup \"map\" \"dock\" 50.0)"), "TRUE");
  for (int i = 0; i < 3; ++i) tick();
  EXPECT_THAT(poses(), ElementsAre(AllOf(HasSubstr("(translation 1.25 2 0)"), HasSubstr("(stamp 0.0)"))));
}

TEST_F(Tf2PoseTracker, IsTheSameTwice) {
  const auto run = [] {
    Lab lab;
    lab.config(R"(environments: ["main"]
main: {plugins: ["tracker"]}
tracker: {plugin: "cx::Tf2PoseTrackerPlugin"})");
    const auto world =
        lab.bus.join(bus::ParticipantKind::kNode, {"world", "/", {}}, lab.records.open_stream("node/world"));
    auto server = bus::TransformBroadcaster::create(lab.bus, world);
    lab.run_up();
    EXPECT_TRUE(lab.engine().eval("(tf2-start-periodic-lookup map robot 7.0)").ok());
    for (int i = 0; i < 50; ++i) {
      lab.bus.begin_tick(lab.now);
      server->set("map", "robot", bus::planar(0.1 * i, 0, 0));
      server->post();
      lab.ticks(1);
    }
    return lab.records.text_by_stream().at("env/main");
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace cxlab::cx
