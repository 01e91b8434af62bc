// Plugins go and come back while rules use them.

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Unload : public ::testing::Test {
 protected:
  /// One environment that runs at 50 Hz, with this plugin and these rules.
  void run_up(const std::string& plugin, const std::string& type, const std::string& rules) {
    plugin_ = plugin;
    lab_.options.stop_on_rule_error = false;
    lab_.config("environments: [\"main\"]\nmain: {plugins: [\"executive\", \"" + plugin + "\", \"files\"]}\n" + plugin +
                ": {plugin: \"" + type +
                "\"}\nexecutive: {plugin: \"cx::ExecutivePlugin\", refresh_rate: 50}\n"
                "files: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}");
    lab_.write("agent/rules.clp", rules);
    lab_.run_up();
    lab_.ticks(2);
  }
  void unload() {
    const Status s = lab_.manager->unload_plugin("main", plugin_);
    ASSERT_TRUE(s.ok()) << s.error().text();
    lab_.log.lines.clear();
    lab_.ticks(2);
  }
  void load() {
    const Status s = lab_.manager->load_plugin("main", plugin_);
    ASSERT_TRUE(s.ok()) << s.error().text();
    lab_.log.lines.clear();
    lab_.ticks(2);
  }
  /// Each run of the rule fails, and names function, plugin and rule.
  void expect_tombstone(const std::string& function, const std::string& rule) {
    EXPECT_THAT(lab_.log.with("'" + function + "'"), Contains(HasSubstr("belongs to unloaded plugin " + plugin_)));
    EXPECT_THAT(lab_.log.with("rule " + rule), testing::Not(IsEmpty()));
  }
  Lab lab_;
  std::string plugin_;
};

TEST_F(Unload, AmentIndex) {
  run_up("index", "cx::AmentIndexPlugin",
         "(defrule ask (time ?) => (println \"share \" (ament-index-get-package-share-directory agent)))");
  EXPECT_THAT(lab_.log.with("share /"), SizeIs(2));
  unload();
  expect_tombstone("ament-index-get-package-share-directory", "ask");
  load();
  EXPECT_THAT(lab_.log.with("share /"), SizeIs(2));
}

TEST_F(Unload, RosParam) {
  run_up("params", "cx::RosParamPlugin",
         "(defrule ask (time ?) => (println \"speed \" (ros-param-get-value speed 2)))");
  EXPECT_THAT(lab_.log.with("speed 2"), SizeIs(2));
  unload();
  expect_tombstone("ros-param-get-value", "ask");
  load();
  EXPECT_THAT(lab_.log.with("speed 2"), SizeIs(2));
}

TEST_F(Unload, ConfigLeavesItsTemplateAndFacts) {
  lab_.write("agent/c.yaml", "a: 1");
  const std::string file = (lab_.folder / "agent/c.yaml").string();
  run_up("config", "cx::ConfigPlugin",
         "(defrule read (time ?) => (config-load \"" + file +
             "\" \"/\"))\n(defrule tell (confval (path ?p) (value ?v)) => (println ?p \" is \" ?v))");
  EXPECT_THAT(lab_.log.with("/a is 1"), SizeIs(1));
  unload();
  expect_tombstone("config-load", "read");
  EXPECT_THAT(lab_.facts("confval"), SizeIs(1));
  EXPECT_TRUE(lab_.engine().has("deftemplate", "confval"));
  load();
  EXPECT_THAT(lab_.log.with("error "), IsEmpty());
}

TEST_F(Unload, Tf2PoseTrackerEndsItsLookups) {
  run_up("tracker", "cx::Tf2PoseTrackerPlugin",
         "(defrule start => (tf2-start-periodic-lookup map robot 50.0))\n(defrule seen (tf2-tracked-pose) => (println "
         "\"seen\"))\n"
         "(defrule again (time ?) (again) => (tf2-start-periodic-lookup map robot 50.0))");
  EXPECT_THAT(lab_.log.with("TF lookup failed"), SizeIs(1));
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "tracker").ok());
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn tracker: tf2-tracked-pose cant be undefined"))
      << "a rule uses it";
  ASSERT_TRUE(lab_.engine().assert_string("(again)").ok());
  lab_.ticks(2);
  EXPECT_THAT(lab_.log.with("TF lookup failed"), IsEmpty());
  expect_tombstone("tf2-start-periodic-lookup", "again");
  load();
  EXPECT_THAT(lab_.log.with("TF lookup failed"), testing::Not(IsEmpty()))
      << "looked up again, with the template that was there";
}

TEST_F(Unload, ExecutiveTakesItsRuleAndGlobal) {
  lab_.options.stop_on_rule_error = false;
  run_up("other", "cx::ExamplePlugin", "(defrule tell (time ?) => (println \"now \" (now)))");
  EXPECT_THAT(lab_.log.with("now 0."), SizeIs(2));
  plugin_ = "executive";
  unload();
  EXPECT_THAT(lab_.log.lines, IsEmpty()) << "nothing runs";
  EXPECT_FALSE(lab_.engine().has("defrule", "time-retract"));
  EXPECT_FALSE(lab_.engine().has("defglobal", "PRIORITY-TIME-RETRACT"));
  EXPECT_FALSE(lab_.engine().eval("(now)").ok());
  load();
  EXPECT_THAT(lab_.log.with("now 0."), SizeIs(2));
  EXPECT_THAT(lab_.facts("time"), IsEmpty());
}

TEST_F(Unload, ExecutiveLeavesAGlobalThatRulesUse) {
  run_up("other", "cx::ExamplePlugin", "(defrule low (last ?) => (println ?*PRIORITY-TIME-RETRACT*))");
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "executive").ok());
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn executive: PRIORITY-TIME-RETRACT cant be undefined"));
  EXPECT_TRUE(lab_.engine().has("defglobal", "PRIORITY-TIME-RETRACT"));
  EXPECT_TRUE(lab_.manager->load_plugin("main", "executive").ok());
}

TEST_F(Unload, FileLoadLeavesItsRulesAndCleansUp) {
  lab_.options.stop_on_rule_error = false;
  lab_.config(R"(environments: ["main"]
main: {plugins: ["executive", "files"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"], cleanup_batch: ["bye.clp"]})");
  lab_.write("agent/rules.clp", "(defrule tell (time ?t) => (println \"tick\"))");
  lab_.write("agent/bye.clp", "(println \"bye\")");
  lab_.run_up();
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "files").ok());
  EXPECT_THAT(lab_.log.with("info main: bye"), SizeIs(1));
  lab_.ticks(3);
  EXPECT_THAT(lab_.log.with("info main: tick"), SizeIs(3));
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("info main: bye"), SizeIs(1));
}

TEST_F(Unload, Example) {
  run_up("example", "cx::ExamplePlugin", "");
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "example").ok());
  EXPECT_THAT(lab_.log.with(" example: "), ElementsAre("debug example: Initializing plugin for environment main",
                                                       "info example: Destroying plugin for environment main"));
}

}  // namespace
}  // namespace cxlab::cx
