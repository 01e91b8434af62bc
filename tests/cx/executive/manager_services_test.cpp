// Environments and plugins at run time, through the six services.

#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ManagerServices : ::testing::Test {
  ManagerServices() {
    lab.options.plugin_types.push_back(logging_plugin());
    lab.config(R"(environments: ["main"]
main: {plugins: ["executive", "one"]}
extra: {plugins: ["one", "files"], watch: ["facts"]}
wrong: {watch: ["fcts"]}
executive: {plugin: "cx::ExecutivePlugin"}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"], cleanup_batch: ["end.clp"]}
more: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["more.clp"]}
broken: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["broken.clp"]}
one: {plugin: "test::Logging"}
two: {plugin: "test::Logging"}
bad_init: {plugin: "test::Logging", fail: "init"}
bad_start: {plugin: "test::Logging", fail: "initialize"}
throws: {plugin: "test::Logging", fail: "throw-init"})");
    lab.write("agent/rules.clp",
              "(deffacts start (from-deffacts)) (defrule go (from-deffacts) => (println \"rules ran\"))\n(defrule end "
              "(executive-finalize) => (println \"finalized\"))");
    lab.write("agent/end.clp", "(println \"cleaned\")");
    lab.write("agent/more.clp", "(defrule more (time ?t) => (println \"more \" ?t))");
    lab.write("agent/broken.clp", "(defrule broken (time ?t)\n  => (no-such-function))");
  }
  /// Lines of the plugins' hooks and of rules, without their logger's level.
  std::vector<std::string> hooks() {
    std::vector<std::string> out;
    for (const auto& l : lab.log.lines)
      if ((l.starts_with("info one: ") || l.starts_with("info two: ") || l.starts_with("info bad") ||
           l.starts_with("info throws")) &&
          l.find("Initializing plugin for environment") == std::string::npos)
        out.push_back(l.substr(5));
    return out;
  }
  Lab lab;
  Caller caller{lab};
};

TEST_F(ManagerServices, ExistFromConfigureToDeactivate) {
  const auto offered = [&] {
    std::vector<std::string> names;
    for (const auto& info : lab.bus.services())
      if (info.providers > 0 && (info.name.ends_with("_env") || info.name.ends_with("_envs") ||
                                 info.name.ends_with("_plugin") || info.name.ends_with("_plugins")))
        names.push_back(info.name.substr(15));
    return names;
  };
  ASSERT_TRUE(lab.create().ok());
  EXPECT_THAT(offered(), IsEmpty());
  ASSERT_TRUE(lab.manager->configure().ok());
  EXPECT_THAT(offered(),
              ElementsAre("create_env", "destroy_env", "list_envs", "list_plugins", "load_plugin", "unload_plugin"));
  ASSERT_TRUE(lab.manager->activate().ok());
  EXPECT_EQ(offered().size(), 6u);
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(offered(), ElementsAre("list_envs"));
}

TEST_F(ManagerServices, ListWhatIsThere) {
  lab.run_up();
  EXPECT_EQ(caller.manager("list_envs", "ListClipsEnvs"), R"({success: true, envs: ["main"], error: ""})");
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins", "{env_name: main}"),
            R"({success: true, plugins: ["executive", "one"], error: ""})");
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins"), R"({success: true, plugins: [], error: ""})");
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins", "{env_name: moon}"),
            R"({success: false, plugins: [], error: "unknown environment"})");
}

TEST_F(ManagerServices, CreateEnvLoadsItsPluginsWithoutResetAndRun) {
  lab.run_up();
  EXPECT_EQ(caller.manager("create_env", "CreateClipsEnv", "{env_name: extra}"), R"({success: true, error: ""})");
  EXPECT_EQ(caller.manager("list_envs", "ListClipsEnvs"), R"({success: true, envs: ["main", "extra"], error: ""})");
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins", "{env_name: extra}"),
            R"({success: true, plugins: ["one", "files"], error: ""})");
  EXPECT_THAT(lab.facts("from-deffacts", "extra"), IsEmpty()) << "no reset";
  EXPECT_THAT(lab.log.with("rules ran"), IsEmpty());
  lab.engine("extra").reset();
  EXPECT_EQ(lab.log.with("info extra: ==> f-1").size(), 1u) << "its watch items hold";
  EXPECT_EQ(caller.manager("create_env", "CreateClipsEnv", "{env_name: extra}"),
            R"({success: false, error: "Enviroment extra already exists!"})");
  EXPECT_EQ(caller.manager("create_env", "CreateClipsEnv", "{env_name: bare}"), R"({success: true, error: ""})")
      << "without parameters it has no plugins";
}

TEST_F(ManagerServices, AnEnvironmentWithWrongParametersIsNotMade) {
  lab.options.keep_going = true;
  lab.run_up();
  EXPECT_EQ(caller.manager("create_env", "CreateClipsEnv", "{env_name: wrong}"),
            R"({success: false, error: "Unknown watch item: fcts"})");
  EXPECT_EQ(lab.manager->environment_names().size(), 1u);
  ASSERT_EQ(lab.manager->load_errors().size(), 1u) << "so that the exit code tells";
  EXPECT_THAT(lab.manager->load_errors().front().text(), HasSubstr(": Unknown watch item: fcts"));
}

TEST_F(ManagerServices, AnEnvironmentWithWrongParametersEndsTheRunUnlessItKeepsGoing) {
  lab.run_up();
  EXPECT_FALSE(lab.manager->create_environment("wrong").ok());
  EXPECT_EQ(lab.manager->act().error().message, "Unknown watch item: fcts");
}

TEST_F(ManagerServices, AnEnvironmentWhosePluginsFailEndsTheRun) {
  lab.config("environments: [\"main\"]\nmain: {plugins: []}\nextra: {plugins: [\"nope\"]}");
  lab.run_up();
  EXPECT_FALSE(lab.manager->create_environment("extra").ok());
  EXPECT_FALSE(lab.manager->act().ok());
}

TEST_F(ManagerServices, DestroyEnvUnloadsInReverseWithoutExecutiveFinalize) {
  lab.run_up();
  caller.manager("create_env", "CreateClipsEnv", "{env_name: extra}");
  EXPECT_EQ(caller.manager("destroy_env", "DestroyClipsEnv", "{env_name: extra}"), R"({success: true, error: ""})");
  EXPECT_EQ(lab.manager->find("extra"), nullptr);
  EXPECT_THAT(lab.log.with("finalized"), IsEmpty());
  EXPECT_THAT(lab.log.with("Deactivated!"),
              ElementsAre("debug clips_manager: [files] Deactivated!", "debug clips_manager: [one] Deactivated!"));
  EXPECT_EQ(lab.log.with("info extra: cleaned").size(), 1u);
  EXPECT_THAT(hooks(), ElementsAre("one: initialize", "one: init main", "one: init extra", "one: destroyed extra"))
      << "main still has it: no finalize";
  EXPECT_EQ(caller.manager("destroy_env", "DestroyClipsEnv", "{env_name: extra}"),
            R"({success: false, error: "unknown Environment name"})");
  EXPECT_EQ(caller.manager("create_env", "CreateClipsEnv", "{env_name: extra}"), R"({success: true, error: ""})")
      << "a name may come again";
}

/// Asserts a fact when it is taken from its environment.
class FarewellPlugin final : public Plugin {
 public:
  using Plugin::Plugin;
  Status clips_env_init(EnvironmentGuard) override { return {}; }
  void clips_env_destroyed(EnvironmentGuard environment) override {
    (void)environment.engine().assert_string("(bye 0)");
  }
};

TEST_F(ManagerServices, DestroyEnvReportsRuleErrorsOfItsEnd) {
  lab.options.plugin_types.push_back(
      {"test::Farewell", {}, [](PluginContext c) { return std::make_unique<FarewellPlugin>(std::move(c)); }});
  lab.config(R"(environments: ["main"]
main: {plugins: []}
extra: {plugins: ["files", "farewell"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["bye.clp"]}
farewell: {plugin: "test::Farewell"})");
  lab.write("agent/bye.clp", "(defrule bad (bye ?n)\n  (test (> (/ 1 ?n) 0)) =>)");
  lab.run_up();
  ASSERT_TRUE(lab.manager->create_environment("extra").ok());
  ASSERT_TRUE(lab.manager->act().ok());
  EXPECT_TRUE(lab.manager->destroy_environment("extra").ok());
  const Status s = lab.manager->act();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, "rule_error");
  EXPECT_THAT(s.error().file, HasSubstr("bye.clp"));
  EXPECT_TRUE(lab.manager->act().ok()) << "reported once";
}

TEST_F(ManagerServices, LoadPluginHotLoadsRules) {
  lab.run_up();
  EXPECT_EQ(caller.load("main", "more"), R"({success: true, error: ""})");
  lab.ticks(10);
  EXPECT_THAT(lab.log.with("main: more "), ElementsAre("info main: more 0.1", "info main: more 0.2"));
  EXPECT_EQ(caller.load("moon", "more"), R"({success: false, error: "unknown environment"})");
}

TEST_F(ManagerServices, EffectsTakePlaceAtTheEndOfTheTick) {
  lab.run_up();
  caller.post("/clips_manager/load_plugin", "cx_msgs/srv/LoadClipsPlugin", "{env_name: main, plugin_name: more}");
  EXPECT_EQ(lab.manager->plugin_names("main")->size(), 2u) << "nothing before the tick";
  lab.ticks(1);
  EXPECT_EQ(lab.manager->plugin_names("main")->size(), 3u);
  EXPECT_THAT(lab.log.with("main: more 0.0"), IsEmpty()) << "rules of this tick were over";
}

TEST_F(ManagerServices, APluginThatFailsIsNotRecordedAndNotDestroyed) {
  lab.options.keep_going = true;
  lab.run_up();
  const std::string refused = R"({success: false, error: "error while loading plugin"})";
  EXPECT_EQ(caller.load("main", "bad_init"), refused);
  EXPECT_EQ(caller.load("main", "bad_start"), refused);
  EXPECT_EQ(caller.load("main", "throws"), refused);
  EXPECT_EQ(caller.load("main", "one"), R"({success: true, error: ""})") << "it is there already";
  EXPECT_EQ(caller.load("main", "nowhere"), refused);
  EXPECT_EQ(caller.manager("list_plugins", "ListClipsPlugins", "{env_name: main}"),
            R"({success: true, plugins: ["executive", "one"], error: ""})");
  EXPECT_THAT(hooks(), ElementsAre("one: initialize", "one: init main", "bad_init: initialize", "bad_init: init main",
                                   "bad_init: finalize", "bad_start: initialize", "throws: initialize",
                                   "throws: init main", "throws: finalize"));
  EXPECT_EQ(lab.log.with("info clips_manager: plugin 'one' is loaded in environment 'main' already").size(), 1u);
  EXPECT_EQ(lab.manager->load_errors().size(), 4u);
  EXPECT_EQ(lab.log.with("clips_env_init threw: thrown in init").size(), 1u);
  EXPECT_EQ(
      lab.log.with("plugin 'nowhere' of environment 'main': no parameter 'nowhere.plugin' says what it is").size(), 1u);
}

TEST_F(ManagerServices, ABrokenRuleFileEndsTheRunUnlessItKeepsGoing) {
  lab.run_up();
  caller.post("/clips_manager/load_plugin", "cx_msgs/srv/LoadClipsPlugin", "{env_name: main, plugin_name: broken}");
  const Status s = lab.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_THAT(s.error().file, HasSubstr("broken.clp"));
  EXPECT_EQ(caller.take(), R"({success: false, error: "error while loading plugin"})");
}

TEST_F(ManagerServices, AnUnknownPluginOrClassEndsTheRunUnlessItKeepsGoing) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"nowhere", "no parameter 'nowhere.plugin' says what it is"},
      {"no_class", "unknown plugin type 'test::Loging', did you mean 'test::Logging'?"}};
  for (const auto& [plugin, message] : mistakes) {
    SCOPED_TRACE(plugin);
    Lab strict;
    strict.options.plugin_types.push_back(logging_plugin());
    strict.config("environments: [\"main\"]\nmain: {plugins: []}\nno_class: {plugin: \"test::Loging\"}");
    strict.run_up();
    Caller asks(strict);
    asks.post("/clips_manager/load_plugin", "cx_msgs/srv/LoadClipsPlugin",
              "{env_name: main, plugin_name: " + std::string(plugin) + "}");
    const Status s = strict.tick();
    ASSERT_FALSE(s.ok());
    EXPECT_EQ(s.error().kind, ErrorKind::kInput);
    EXPECT_THAT(s.error().message, HasSubstr(message));
    EXPECT_EQ(asks.take(), R"({success: false, error: "error while loading plugin"})");
  }
}

TEST_F(ManagerServices, UnloadPluginTakesItBack) {
  lab.run_up();
  caller.load("main", "two");
  EXPECT_EQ(caller.unload("main", "two"), R"({success: true, error: ""})");
  EXPECT_THAT(hooks(), ElementsAre("one: initialize", "one: init main", "two: initialize", "two: init main",
                                   "two: destroyed main", "two: finalize"));
  EXPECT_EQ(lab.log.with("[two] Deactivated!").size(), 1u);
  EXPECT_FALSE(lab.engine().callable("two-word"));
  EXPECT_EQ(caller.unload("main", "two"), R"({success: false, error: "unknown plugin"})");
  EXPECT_EQ(caller.unload("moon", "two"), R"({success: false, error: "unknown plugin"})");
  EXPECT_EQ(caller.load("main", "two"), R"({success: true, error: ""})") << "it may come again";
  EXPECT_TRUE(lab.engine().callable("two-word"));
}

TEST_F(ManagerServices, AFunctionOfAnUnloadedPluginThatRulesUseSaysWhoseItWas) {
  lab.options.stop_on_rule_error = false;
  lab.write("agent/more.clp", "(defrule more (time ?t) => (println \"word \" (two-word)))");
  lab.run_up();
  caller.load("main", "two");
  caller.load("main", "more");
  lab.ticks(5);
  EXPECT_FALSE(lab.log.with("word two").empty());
  caller.unload("main", "two");
  lab.ticks(5);
  ASSERT_FALSE(lab.manager->rule_errors().empty());
  EXPECT_THAT(lab.manager->rule_errors().back().error.message, HasSubstr("belongs to unloaded plugin two"));
  EXPECT_EQ(lab.manager->rule_errors().back().error.rule, "more");
  EXPECT_THAT(lab.manager->rule_errors().back().error.file, HasSubstr("more.clp"));
}

TEST_F(ManagerServices, APluginThatFailsWhenItIsUnloadedEndsTheRunUnlessItKeepsGoing) {
  for (const bool keep_going : {false, true}) {
    Lab other;
    other.options.keep_going = keep_going;
    other.options.plugin_types.push_back(logging_plugin());
    other.config(
        "environments: [\"main\"]\nmain: {plugins: [\"one\"]}\none: {plugin: \"test::Logging\", fail: "
        "\"throw-destroyed\"}");
    other.run_up();
    (void)other.manager->unload_plugin("main", "one");
    const Status s = other.manager->act();
    EXPECT_EQ(s.ok(), keep_going);
    if (!s) {
      EXPECT_THAT(s.error().message, HasSubstr("thrown in destroyed"));
    }
    EXPECT_EQ(other.manager->load_errors().size(), keep_going ? 1U : 0U);
  }
}

TEST_F(ManagerServices, ATemplateThatRulesUseStaysWithAWarning) {
  lab.config(R"(environments: ["main"]
main: {plugins: ["config", "files"]}
config: {plugin: "cx::ConfigPlugin"}
ros_msgs: {plugin: "cx::RosMsgsPlugin"}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["uses.clp"]})");
  lab.write("agent/uses.clp", "");
  lab.run_up();
  caller.load("main", "ros_msgs");
  ASSERT_TRUE(lab.engine().build("(defrule uses (ros-msgs-message) =>)").ok());
  EXPECT_EQ(caller.unload("main", "ros_msgs"), R"({success: true, error: ""})");
  EXPECT_THAT(lab.log.with("cant be undefined"), ElementsAre("warn ros_msgs: ros-msgs-message cant be undefined"));
  EXPECT_EQ(caller.load("main", "ros_msgs"), R"({success: true, error: ""})");
}

TEST_F(ManagerServices, RulesMayCallThemToo) {
  lab.agent(R"((deffacts start (open))
(defrule open (open) => (ros-msgs-create-client "clips_manager/create_env" "cx_msgs/srv/CreateClipsEnv")
  (bind ?r (ros-msgs-create-request "cx_msgs/srv/CreateClipsEnv")) (ros-msgs-set-field ?r "env_name" "second")
  (ros-msgs-async-send-request ?r "clips_manager/create_env") (ros-msgs-destroy-message ?r))
(defrule answer (ros-msgs-response (msg-ptr ?m)) => (println "created: " (ros-msgs-get-field ?m "success")) (ros-msgs-destroy-message ?m)))");
  lab.run_up();
  lab.ticks(2);
  EXPECT_THAT(lab.manager->environment_names(), ElementsAre("main", "second"));
  lab.ticks(8);
  EXPECT_EQ(lab.log.with("created: TRUE").size(), 1u);
}

}  // namespace
}  // namespace cxlab::cx
