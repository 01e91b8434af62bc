// What the next CX adds to executive and manager: pause, resume, tick_once, eval, build, a topic for the log, focus
// stack, rule limit; and `compat: next`.

#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ExecutiveControl : ::testing::Test {
  void start(const std::string& executive, const std::string& environment = "", const std::string& manager = "",
             const std::string& rules = kRules) {
    lab.config(manager + R"(environments: ["main", "other"]
main: {plugins: ["executive", "files"])" +
               environment + R"(}
other: {plugins: ["executive"]}
executive: {plugin: "cx::ExecutivePlugin")" +
               executive + R"(}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
    lab.write("agent/rules.clp", rules);
    lab.run_up();
  }
  std::string trigger(const std::string& name) {
    return caller.manager_service("executive/" + name, "std_srvs/srv/Trigger");
  }
  std::string command(const std::string& name, const std::string& text, const std::string& environment = "") {
    return caller.manager_service("executive/" + name, "cx_msgs/srv/ClipsCommand",
                                  "{env_name: '" + environment + "', command: '" + text + "'}");
  }
  std::vector<std::string> ticked() { return lab.log.with("tick "); }

  static constexpr const char* kRules = "(defrule tick (time ?t) => (println \"tick \" ?t))";
  Lab lab;
  Caller caller{lab};
};

TEST_F(ExecutiveControl, PauseStopsTheBeatAndResumeTakesItUpAgain) {
  start("");
  EXPECT_EQ(trigger("pause"), R"({success: true, message: "executive paused."})");
  EXPECT_EQ(trigger("pause"), R"({success: false, message: "executive already paused."})");
  EXPECT_THAT(lab.log.with("executive: executive"), ElementsAre("info executive: executive paused."));
  EXPECT_EQ(ticked().size(), 1u);
  lab.ticks(28);  // up to 0.6 s
  EXPECT_EQ(ticked().size(), 1u);
  EXPECT_EQ(lab.manager->next_due(), kNever);
  EXPECT_EQ(trigger("resume"), R"({success: true, message: "executive resumed."})");
  EXPECT_EQ(trigger("resume"), R"({success: false, message: "executive already running."})");
  lab.ticks(10);
  EXPECT_THAT(ticked(), ElementsAre("info main: tick 0.0", "info main: tick 0.7", "info main: tick 0.8"));
}

TEST_F(ExecutiveControl, BeginsPausedWithoutAutostart) {
  start(", autostart: false");
  lab.ticks(20);
  EXPECT_THAT(ticked(), IsEmpty());
  EXPECT_EQ(trigger("tick_once"), R"({success: true, message: "Tick executed."})");
  EXPECT_THAT(ticked(), ElementsAre("info main: tick 0.4"));
  EXPECT_EQ(trigger("resume"), R"({success: true, message: "executive resumed."})");
  lab.ticks(5);
  EXPECT_EQ(ticked().size(), 2u);
}

TEST_F(ExecutiveControl, TickOnceReportsAnErrorOfRulesToTheRun) {
  start(", autostart: false", "", "", "(defrule wrong (time ?t) => (/ ?t 0.0))");
  trigger("tick_once");
  const Status ended = lab.tick();
  ASSERT_FALSE(ended.ok());
  EXPECT_THAT(ended.error().text(), HasSubstr("rule wrong"));
}

TEST_F(ExecutiveControl, EvalAnswersAndPrintsOnTheTopic) {
  start("");
  const std::vector<std::string> lines = caller.listen("/clips_manager/clips_log", "cx_msgs/msg/Log", [&] {
    EXPECT_EQ(command("eval", "(println one (+ 1 1))"), R"({success: true, message: ""})");
    EXPECT_EQ(command("eval", "(println two)", "other"), R"({success: true, message: ""})");
  });
  EXPECT_THAT(lines, ElementsAre(R"({env_name: "main", logical_name: "stdout", line: "one2"})",
                                 R"({env_name: "other", logical_name: "stdout", line: "two"})"));
  EXPECT_EQ(command("eval", "(assert (seen))"), R"({success: true, message: ""})");
  EXPECT_THAT(lab.facts("seen"), ElementsAre("(seen)"));
  EXPECT_EQ(command("eval", "(seen", "main"),
            R"({success: false, message: "Eval failed: syntax error while parsing the expression."})");
  EXPECT_EQ(command("eval", "(+ a 1)", "main"),
            R"({success: false, message: "Eval failed: syntax error while parsing the expression."})")
      << "CLIPS checks types of constants when it parses";
  EXPECT_EQ(command("eval", "(nth$ (+ 1 1) (create$ 1 (/ 1 0)))"),
            R"({success: false, message: "Eval failed: error occurred while executing the parsed expression."})");
  EXPECT_EQ(command("eval", "(facts)", "moon"), R"({success: false, message: "Environment 'moon' not found."})");
  EXPECT_TRUE(lab.tick().ok()) << "what went wrong is the answer, not an error of the run";
}

TEST_F(ExecutiveControl, BuildAddsConstructs) {
  start("");
  EXPECT_EQ(command("build", "(defrule more (time ?) => (println more))"), R"({success: true, message: ""})");
  lab.ticks(5);
  EXPECT_EQ(lab.log.with("more").size(), 1u);
  EXPECT_EQ(command("build", "(defrule more"),
            R"({success: false, message: "Build failed: syntax error while parsing the construct."})");
  EXPECT_EQ(command("build", "(defrule more (time ?) => (no-such))"),
            R"({success: false, message: "Build failed: syntax error while parsing the construct."})");
  EXPECT_EQ(command("build", "(defrul more)"),
            R"({success: false, message: "Build failed: construct name not recognized."})");
}

TEST_F(ExecutiveControl, WhatIsWrongWithAConstructIsLoggedAndPublished) {
  start("");
  const auto lines = caller.listen("/clips_manager/clips_log", "cx_msgs/msg/Log",
                                   [&] { command("build", "(defrule more (time ?) => (no-such))", "other"); });
  EXPECT_THAT(lines, ElementsAre(HasSubstr(R"({env_name: "other", logical_name: "stderr", line: "[EXPRNPSR3] Missing )"
                                           R"(function declaration for 'no-such')")));
  EXPECT_EQ(lab.log.with("error other: [EXPRNPSR3]").size(), 1u);
}

TEST_F(ExecutiveControl, NoEnvironments) {
  lab.config(R"(environments: ["main"]
main: {plugins: ["executive"]}
executive: {plugin: "cx::ExecutivePlugin"})");
  lab.run_up();
  EXPECT_EQ(caller.manager("destroy_env", "DestroyClipsEnv", "{env_name: main}"), R"({success: true, error: ""})");
  EXPECT_EQ(command("eval", "(facts)"), "") << "the plugin has gone with its last environment";
}

TEST_F(ExecutiveControl, LogGoesToTheTopicOnRequestAndByParameter) {
  start("", ", log_clips_to_topic: true");
  const auto listen = [&](const auto& act) {
    return caller.listen("/clips_manager/clips_log", "cx_msgs/msg/Log", act);
  };
  EXPECT_EQ(listen([&] { lab.ticks(5); }).size(), 1u);
  EXPECT_EQ(caller.manager("set_topic_logging", "SetTopicLogging", "{env_name: main, enabled: false}"),
            "{success: true}");
  EXPECT_THAT(listen([&] { lab.ticks(5); }), IsEmpty());
  EXPECT_EQ(caller.manager("set_topic_logging", "SetTopicLogging", "{env_name: moon, enabled: true}"),
            "{success: true}");
}

TEST_F(ExecutiveControl, FocusStackIsRunInItsOrder) {
  start("", ", focus_stack: [B, C, A]", "",
        "(defmodule A) (deffacts start (go)) (defrule a (go) => (println \"ran a\"))"
        "(defmodule B) (deffacts start (go)) (defrule b (go) => (println \"ran b\"))");
  lab.ticks(10);
  EXPECT_THAT(lab.log.with("ran "), ElementsAre("info main: ran b", "info main: ran a"));
  EXPECT_THAT(lab.log.with("Focus stack"),
              ElementsAre("error executive: Focus stack entry 'C' is not a valid module, removing from stack."));
}

/// One rule of the module A halts while another one waits, and MAIN has a rule to fire as well.
constexpr const char* kHalts =
    "(defrule first (not (seen)) => (assert (seen)) (focus A))"
    "(defrule second (seen) => (println \"ran in MAIN\"))"
    "(defmodule A) (deffacts start (go 1) (go 2)) (defrule a (go ?) => (println \"ran in A\") (halt))";

TEST_F(ExecutiveControl, TheReleasedOneGoesOnWhereTheLastRunEnded) {
  start("", "", "", kHalts);
  lab.ticks(10);
  EXPECT_THAT(lab.log.with("ran "),
              ElementsAre("info main: ran in A", "info main: ran in A", "info main: ran in MAIN"));
}

TEST_F(ExecutiveControl, NextBeginsAtMainAgain) {
  start("", "", "compat: next\n", kHalts);
  lab.ticks(10);
  EXPECT_THAT(lab.log.with("ran "),
              ElementsAre("info main: ran in A", "info main: ran in MAIN", "info main: ran in A"));
}

TEST_F(ExecutiveControl, RuleLimitEndsATick) {
  start("", ", rule_limit: 2", "",
        "(deffacts start (n 1)) (defrule count ?f <- (n ?n) (time ?) => (retract ?f) (assert (n (+ ?n 1))))");
  ASSERT_TRUE(lab.tick().ok());
  EXPECT_THAT(lab.facts("n"), ElementsAre("(n 3)"));
  EXPECT_THAT(lab.log.with("limit"), ElementsAre("error executive: Env 'main': Rule fire limit of 2 was reached."));
}

TEST_F(ExecutiveControl, NextRepeatsUntilNothingFiresAndRetractsTheTimeItself) {
  start(", publish_on_refresh: true", "", "compat: next\n",
        "(defrule first (time ?) => (assert (once)))"
        "(defrule second (once) (not (time ?)) => (println \"after the time\"))");
  const auto published = caller.listen("/clips_manager/executive/refresh_agenda", "std_msgs/msg/Int64",
                                       [&] { EXPECT_TRUE(lab.tick().ok()); });
  EXPECT_THAT(published, ElementsAre("{data: 2}"));
  EXPECT_THAT(lab.log.with("after"), ElementsAre("info main: after the time"));
  EXPECT_FALSE(lab.engine().has("defrule", "time-retract"));
  EXPECT_THAT(lab.facts("time"), IsEmpty());
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins"),
            R"({success: false, plugins: [], error: "unknown environment"})");
}

TEST_F(ExecutiveControl, CompatIsReleasedOrNext) {
  lab.config("compat: newest\nenvironments: []");
  const Status made = lab.create();
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(made.error().text(),
              HasSubstr("config.yaml:3: parameter 'compat': found 'newest', expected released or next"));
}

}  // namespace
}  // namespace cxlab::cx
