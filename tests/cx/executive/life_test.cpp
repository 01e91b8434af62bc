#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Activation, LoadsAllPluginsOfAllEnvironmentsBeforeAnyReset) {
  Lab lab;
  lab.config(R"(environments: ["zeta", "alpha"]
zeta: {plugins: ["files"]}
alpha: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["a.clp"], batch: ["b.clp"]})");
  lab.write("agent/a.clp", "(deffacts start (from-deffacts))\n(defrule go (from-deffacts) => (println \"run\"))");
  lab.write("agent/b.clp", "(println \"batch\") (assert (from-batch))");
  lab.run_up();
  std::vector<std::string> said;
  for (const auto& l : lab.log.lines)
    if (l.ends_with("batch") || l.ends_with("run")) said.push_back(l);
  EXPECT_THAT(said, ElementsAre("info zeta: batch", "info alpha: batch", "info zeta: run", "info alpha: run"));
  EXPECT_THAT(lab.facts("from-batch", "zeta"), IsEmpty()) << "the reset takes facts of batch files away";
}

TEST(Activation, TellsOfEnvironmentsAndPluginsAsCxDoes) {
  Lab lab;
  lab.config(
      "environments: [\"main\"]\nmain: {plugins: [\"files\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", "
      "pkg_share_dirs: [\"agent\"], load: [\"a.clp\"]}");
  lab.write("agent/a.clp", "(defrule go => (println \"run\")) (defrule end (executive-finalize) => (println \"end\"))");
  lab.run_up();
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(
      lab.log.lines,
      ElementsAre("debug clips_manager: Configuring [clips_manager]...",
                  "debug clips_manager: Initialized new CLIPS environment: main",
                  "debug clips_manager: Configured [clips_manager]!",
                  "debug clips_manager: Activating [clips_manager]...",
                  "debug clips_manager: Loading plugins for main.",
                  "debug clips_manager: Created plugin: files of type cx::FileLoadPlugin on activation",
                  "debug files: Initializing plugin for environment main", "info main: run",
                  "debug clips_manager: Activated [clips_manager]...", "info main: end",
                  "debug clips_manager: [files] Deactivated!", "debug clips_manager: Deactivated [clips_manager]..."));
}

TEST(Executive, AssertsTheTimeAtItsRateAndTakesItBack) {
  Lab lab;
  lab.agent("(defrule note (time ?t) => (println \"t=\" ?t \" now=\" (now)))");
  lab.run_up();
  EXPECT_THAT(lab.log.with("t="), IsEmpty()) << "activation runs without a time fact";
  lab.ticks(11);
  EXPECT_THAT(lab.log.with("t="),
              ElementsAre("info main: t=0.0 now=0.0", "info main: t=0.1 now=0.1", "info main: t=0.2 now=0.2"));
  EXPECT_THAT(lab.facts("time"), IsEmpty());
}

TEST(Executive, TheTimeIsTheNumberThatARuleWrites) {
  Lab lab;
  lab.agent(
      "(defrule at (time 0.3) => (println \"at\")) (defrule after (time ?t&:(> ?t 0.3)&:(< ?t 0.35)) => (println "
      "\"after\"))");
  lab.run_up();
  lab.ticks(20);
  EXPECT_THAT(lab.log.with("main: a"), ElementsAre("info main: at"));
}

TEST(Executive, DueTimesAreThoseOfItsRateNotOfTicks) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["executive", "files"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 30}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
  lab.write("agent/rules.clp", "(defrule note (time ?t) => (println \"t=\" ?t))");
  lab.run_up();
  lab.ticks(6);  // due at 0, 33.3, 66.7, 100 ms; ticks are 20 ms
  EXPECT_THAT(lab.log.with("t="),
              ElementsAre("info main: t=0.0", "info main: t=0.04", "info main: t=0.08", "info main: t=0.1"));
  EXPECT_EQ(lab.manager->next_due(), SimTime{133'333'333});
}

TEST(Executive, AFasterRateThanTheTickRunsOnceATick) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["executive", "files"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 1000}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
  lab.write("agent/rules.clp", "(defrule note (time ?t) => (println \"t=\" ?t))");
  lab.run_up();
  lab.ticks(3);
  EXPECT_EQ(lab.log.with("t=").size(), 3u);
}

TEST(Executive, NowSystimeIsEpochAndSimulatedTime) {
  Lab lab;
  lab.options.epoch = 1000;
  lab.agent("(defrule note (time ?) => (println \"systime=\" (now-systime) \" time=\" (time)))");
  lab.run_up();
  lab.ticks(6);
  EXPECT_THAT(lab.log.with("systime="),
              ElementsAre("info main: systime=1000.0 time=1000.0", "info main: systime=1000.1 time=1000.1"));
}

TEST(Executive, WithoutTimeFactRulesStillRun) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["executive", "files"]}
executive: {plugin: "cx::ExecutivePlugin", assert_time: false}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
  lab.write("agent/rules.clp",
            "(defrule note (time ?t) => (println \"time\")) (defrule late (go) => (println \"went\"))");
  lab.run_up();
  ASSERT_TRUE(lab.engine().assert_string("(go)").ok());
  lab.ticks(1);
  EXPECT_THAT(lab.log.with("time"), IsEmpty());
  EXPECT_THAT(lab.log.with("went"), ElementsAre("info main: went"));
}

TEST(Executive, PublishesEachRefreshOnceForAllItsEnvironments) {
  Lab lab;
  lab.config(R"(environments: ["one", "two"]
one: {plugins: ["executive"]}
two: {plugins: ["executive"]}
executive: {plugin: "cx::ExecutivePlugin", publish_on_refresh: true})");
  int heard = 0;
  const auto listener =
      lab.bus.join(bus::ParticipantKind::kNode, {"listener", "/", {}}, lab.records.open_stream("node/listener"));
  ASSERT_TRUE(lab.bus
                  .subscribe(listener, "/clips_executive/refresh_agenda", **lab.registry.message("std_msgs/msg/Empty"),
                             [&](const bus::Delivery&) { ++heard; })
                  .ok());
  lab.run_up();
  lab.ticks(6);
  lab.bus.deliver(listener);
  EXPECT_EQ(heard, 2);
}

TEST(Executive, AnEnvironmentWithoutItRunsAtActivationAndAtTheEndOnly) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
  lab.write("agent/rules.clp",
            "(defrule late (go) => (println \"went\")) (defrule end (executive-finalize) => (println \"end\"))");
  lab.run_up();
  ASSERT_TRUE(lab.engine().assert_string("(go)").ok());
  lab.ticks(3);
  EXPECT_THAT(lab.log.with("went"), IsEmpty());
  EXPECT_EQ(lab.manager->next_due(), kNever);
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_EQ(lab.log.with("went").size(), 1u);
  EXPECT_EQ(lab.log.with("end").size(), 1u);
}

TEST(Deactivation, FinalizesRulesThenTakesPluginsInReverseOrder) {
  Lab lab;
  lab.agent("(defrule end (executive-finalize) => (println \"finalized\"))");
  lab.run_up();
  ASSERT_TRUE(lab.manager->deactivate().ok());
  std::vector<std::string> said;
  for (const auto& l : lab.log.lines)
    if (l.find("Deactivated!") != std::string::npos || l.find("finalized") != std::string::npos) said.push_back(l);
  EXPECT_THAT(
      said,
      ElementsAre("info main: finalized", "debug clips_manager: [files] Deactivated!",
                  "debug clips_manager: [ros_msgs] Deactivated!", "debug clips_manager: [config] Deactivated!",
                  "debug clips_manager: [ament_index] Deactivated!", "debug clips_manager: [executive] Deactivated!"));
}

TEST(Deactivation, ARuleMayAskForIt) {
  Lab lab;
  lab.agent("(defrule stop (time ?t&:(> ?t 0.15)) => (cx-shutdown))");
  lab.run_up();
  lab.ticks(10);
  EXPECT_FALSE(lab.manager->shutdown_requested());
  lab.ticks(1);
  EXPECT_TRUE(lab.manager->shutdown_requested());
}

TEST(Deactivation, RulesGiveUpThatPrintAnErrorAndAskForIt) {
  Lab lab;
  lab.agent(
      "(defrule odd (time 0.0) => (printout error \"odd\" crlf))\n"
      "(defrule stop (time ?t&:(> ?t 0.15)) => (printout error \"no way\" crlf) (cx-shutdown))");
  lab.run_up();
  lab.ticks(10);
  EXPECT_FALSE(lab.manager->gave_up());
  lab.ticks(1);
  ASSERT_TRUE(lab.manager->gave_up());
  EXPECT_EQ(lab.manager->gave_up()->text(), "environment 'main' gives up: no way");
}

TEST(Deactivation, AnErrorPrintedBeforeIsNoReasonForIt) {
  Lab lab;
  lab.agent(
      "(defrule odd (time 0.0) => (printout error \"odd\" crlf))\n"
      "(defrule stop (time ?t&:(> ?t 0.15)) => (cx-shutdown))");
  lab.run_up();
  lab.ticks(11);
  EXPECT_TRUE(lab.manager->shutdown_requested());
  EXPECT_FALSE(lab.manager->gave_up());
}

TEST(RuleErrors, StopTheRunWithRuleFileLineAndSide) {
  Lab lab;
  lab.agent("(defrule bad\n  (time ?t)\n  =>\n  (println (/ 1 0)))\n");
  lab.run_up();
  const Status s = lab.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kRun);
  EXPECT_EQ(s.error().code, "rule_error");
  EXPECT_EQ(s.error().file, (lab.folder / "agent/rules.clp").string());
  EXPECT_EQ(s.error().line, 4);
  ASSERT_EQ(lab.manager->rule_errors().size(), 1u);
  const RuleErrorEntry& entry = lab.manager->rule_errors()[0];
  EXPECT_EQ(entry.environment, "main");
  EXPECT_EQ(entry.error.rule, "bad");
  EXPECT_EQ(entry.error.side, ErrorSide::kRhs);
  EXPECT_EQ(entry.error.t, SimTime{0});
  EXPECT_TRUE(lab.manager->deactivate().ok()) << "the end still comes in order";
}

TEST(RuleErrors, OnALeftHandSideAreFoundWhenFactsEnter) {
  Lab lab;
  lab.agent(
      "(defrule bad\n  (amount ?n)\n  (test (> (/ 1 ?n) 0))\n  =>)\n(defrule put (time ?) => (assert (amount 0)))");
  lab.run_up();
  const Status s = lab.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kRun);
  ASSERT_FALSE(lab.manager->rule_errors().empty());
  EXPECT_EQ(lab.manager->rule_errors()[0].error.rule, "bad");
  EXPECT_EQ(lab.manager->rule_errors()[0].error.side, ErrorSide::kLhs);
}

TEST(RuleErrors, AreOnlyNotedWhenTheRunContinues) {
  Lab lab;
  lab.options.stop_on_rule_error = false;
  lab.agent(
      "(defrule bad (time ?t) => (println (/ 1 0)))\n(defrule good (declare (salience -1)) (time ?t) => (println "
      "\"good \" ?t))");
  lab.run_up();
  lab.ticks(6);
  EXPECT_EQ(lab.manager->rule_errors().size(), 2u);
  EXPECT_FALSE(lab.log.with("error main: [PRNTUTIL7]").empty());
}

TEST(RuleLoops, EndTheRunAndAreNamed) {
  Lab lab;
  lab.options.max_firings = 1000;
  lab.options.stop_on_rule_error = false;
  lab.agent(
      "(deffacts start (counter 0))\n(defrule spin ?f <- (counter ?n) => (retract ?f) (assert (counter (+ ?n 1))))");
  const Status s = lab.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kRun);
  EXPECT_EQ(s.error().code, "rule_loop");
  EXPECT_THAT(s.error().message, HasSubstr("spin"));
  EXPECT_THAT(s.error().message, HasSubstr("counter"));
  EXPECT_EQ(s.error().file, (lab.folder / "agent/rules.clp").string());
  EXPECT_EQ(s.error().line, 2);
  EXPECT_THAT(s.error().message, HasSubstr("max_firings_per_tick (now 1000, 0 = no limit)"));
}

TEST(RuleLoops, ZeroIsNoLimitForFiringsAndCallbacks) {
  Lab lab;
  lab.options.max_firings = 0;
  lab.agent(
      "(deffunction heard () (return 1))\n(deffacts start (counter 0))\n"
      "(defrule count ?f <- (counter ?n&:(< ?n 500)) => (retract ?f) (assert (counter (+ ?n 1))))");
  lab.run_up();
  EXPECT_THAT(lab.facts("counter"), ElementsAre("(counter 500)"));
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(lab.engine().call("heard", {}).ok());
  EXPECT_TRUE(lab.tick().ok());
}

TEST(RuleLoops, AsManyCallbacksAsFiringsMayBeInATick) {
  Lab lab;
  lab.options.max_firings = 100;
  lab.agent("(deffunction heard () (return 1))");
  lab.run_up();
  const auto tick_after = [&](int calls) {
    for (int i = 0; i < calls; ++i) EXPECT_TRUE(lab.engine().call("heard", {}).ok());
    return lab.tick();
  };
  EXPECT_TRUE(tick_after(100).ok());
  EXPECT_TRUE(tick_after(100).ok()) << "of each tick";
  const Status s = tick_after(101);
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, "rule_loop");
  EXPECT_THAT(s.error().message, HasSubstr("101 callbacks were called in one tick"));
}

/// What a run with these rules writes to all streams.
std::map<std::string, std::string> records_of(Lab& lab, int n) {
  lab.run_up();
  lab.ticks(n);
  EXPECT_TRUE(lab.manager->deactivate().ok());
  return lab.records.text_by_stream();
}

constexpr const char* kDrawing = R"(
(defrule open (executive-ready) => (ros-msgs-create-publisher "out" "std_msgs/msg/Int32"))
(deffacts start (executive-ready))
(defrule draw (time ?t) => (bind ?m (ros-msgs-create-message "std_msgs/msg/Int32")) (ros-msgs-set-field ?m "data" (random 0 1000))
  (ros-msgs-publish ?m "out") (ros-msgs-destroy-message ?m))
)";

TEST(Determinism, TheSameSeedGivesTheSameRecordsBesideOtherManagers) {
  Lab alone;
  alone.options.seed = 7;
  alone.agent(kDrawing);
  const auto expected = records_of(alone, 30);

  Lab left, right;
  left.options.seed = 7;
  right.options.seed = 8;
  left.agent(kDrawing);
  right.agent(kDrawing);
  left.run_up();
  right.run_up();
  for (int i = 0; i < 30; ++i) {
    left.ticks(1);
    right.ticks(1);
  }
  ASSERT_TRUE(right.manager->deactivate().ok());
  ASSERT_TRUE(left.manager->deactivate().ok());
  EXPECT_EQ(left.records.text_by_stream(), expected);
  EXPECT_NE(right.records.text_by_stream(), expected);
}

TEST(Determinism, ManagersOfOneNameAreNumberedInTheirOrder) {
  Lab lab;
  lab.options.streams = std::make_shared<std::set<std::string>>();
  lab.config("environments: [\"main\"]");
  std::vector<std::unique_ptr<EnvironmentManager>> managers;
  for (int i = 0; i < 3; ++i) {
    lab.run_up();
    managers.push_back(std::move(lab.manager));
  }
  for (const char* stream : {"env/main", "env/main-2", "env/main-3"})
    EXPECT_EQ(lab.records.text_by_stream().count(stream), 1u) << stream;
}

TEST(Determinism, ManagersInOneProcessHaveTheirOwnNamesAndStreams) {
  Lab lab;
  lab.agent(
      "(defrule open (initial) => (ros-msgs-create-subscription \"chatter\" \"std_msgs/msg/String\")) (deffacts start "
      "(initial))");
  lab.options.name_space = "/cyan";
  lab.run_up();
  auto cyan = std::move(lab.manager);
  lab.options.name_space = "/magenta";
  lab.run_up();
  std::vector<std::string> topics;
  for (const auto& info : lab.bus.topics()) topics.push_back(info.name);
  EXPECT_THAT(topics, ::testing::IsSupersetOf({"/cyan/chatter", "/magenta/chatter"}));
  EXPECT_EQ(lab.records.text_by_stream().count("env/cyan/main"), 1u);
  EXPECT_EQ(lab.records.text_by_stream().count("env/magenta/main"), 1u);
}

}  // namespace
}  // namespace cxlab::cx
