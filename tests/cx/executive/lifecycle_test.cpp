// The manager as a lifecycle node.

#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct LifecycleTest : ::testing::Test {
  LifecycleTest() {
    lab.agent(
        "(deffacts start (begin))\n(deftemplate item (slot a))\n(defrule begin (begin) => (assert (item (a 1))) "
        "(println \"begins\"))\n"
        "(defrule tick (time ?t) (item) => (println \"tick \" ?t))\n(defrule end (executive-finalize) => (println "
        "\"ends\"))");
  }
  std::string state() { return caller.call("/clips_manager/get_state", "lifecycle_msgs/srv/GetState"); }
  Lab lab;
  Caller caller{lab};
};

TEST_F(LifecycleTest, GoesThroughItsStatesOnRequest) {
  ASSERT_TRUE(lab.create().ok());
  EXPECT_EQ(state(), R"({current_state: {id: 1, label: "unconfigured"}})");
  EXPECT_EQ(caller.change("configure"), "{success: true}");
  EXPECT_EQ(state(), R"({current_state: {id: 2, label: "inactive"}})");
  EXPECT_THAT(lab.log.with("begins"), IsEmpty());
  EXPECT_EQ(caller.change("activate"), "{success: true}");
  EXPECT_EQ(state(), R"({current_state: {id: 3, label: "active"}})");
  EXPECT_EQ(lab.log.with("begins").size(), 1u);
  EXPECT_EQ(caller.change("deactivate"), "{success: true}");
  EXPECT_EQ(lab.log.with("ends").size(), 1u);
  EXPECT_EQ(caller.manager("list_envs", "ListClipsEnvs"), R"({success: true, envs: ["main"], error: ""})")
      << "environments stay until cleanup";
  EXPECT_EQ(caller.change("cleanup"), "{success: true}");
  EXPECT_EQ(lab.manager->size(), 0u);
  EXPECT_EQ(caller.change("shutdown"), "{success: true}");
  EXPECT_EQ(state(), R"({current_state: {id: 4, label: "finalized"}})");
}

TEST_F(LifecycleTest, LivesAgainAfterACleanup) {
  lab.run_up();
  lab.ticks(3);
  for (int life = 0; life < 3; ++life) {
    for (const char* step : {"deactivate", "cleanup", "configure", "activate"})
      EXPECT_EQ(caller.change(step), "{success: true}") << step;
    lab.ticks(6);
  }
  EXPECT_EQ(lab.log.with("begins").size(), 4u);
  EXPECT_EQ(lab.log.with("ends").size(), 3u);
  EXPECT_GE(lab.log.with("tick ").size(), 4u);
  EXPECT_THAT(lab.log.with("error"), IsEmpty());
  EXPECT_THAT(lab.log.with("warn"), IsEmpty());
}

TEST_F(LifecycleTest, LivesAgainWithoutACleanup) {
  lab.run_up();
  EXPECT_EQ(caller.change("deactivate"), "{success: true}");
  EXPECT_EQ(caller.change("activate"), "{success: true}");
  EXPECT_EQ(lab.log.with("begins").size(), 2u);
  EXPECT_THAT(lab.log.with("error"), IsEmpty());
  EXPECT_THAT(lab.facts("item"), ElementsAre("(item (a 1))"));
}

TEST_F(LifecycleTest, AnEnvironmentThatIsActivatedAgainIsTheSame) {
  lab.run_up();
  ASSERT_TRUE(lab.engine().build("(deffacts by-hand (hand))").ok());
  ASSERT_TRUE(lab.engine().build("(defrule by-hand (hand) => (println \"by hand \" (gensym*)))").ok());
  for (int life = 0; life < 3; ++life) {
    for (const char* step : {"deactivate", "activate"}) EXPECT_EQ(caller.change(step), "{success: true}") << step;
    lab.ticks(6);
  }
  EXPECT_EQ(lab.log.with("Initialized new CLIPS environment").size(), 1u);
  EXPECT_EQ(lab.log.with("begins").size(), 4u);
  EXPECT_THAT(lab.log.with("by hand "),
              ElementsAre("info main: by hand gen1", "info main: by hand gen2", "info main: by hand gen3"));
  EXPECT_THAT(lab.log.with("error"), IsEmpty());
  EXPECT_THAT(lab.log.with("warn"), IsEmpty());
}

TEST_F(LifecycleTest, AllKindsOfConstructsAreLoadedAgain) {
  lab.agent(R"((defclass MAIN::THING (is-a USER) (slot x))
(defmethod MAIN::area ((?x INTEGER)) (* ?x ?x))
(definstances MAIN::things ([t] of THING (x 1)))
(deffacts MAIN::go (go))
(defrule MAIN::begin (go) => (println "begin " (area 4) " " (send [t] get-x)) (focus USE))
(defrule MAIN::last (declare (salience -1)) (go) => (println "main again"))
(defmodule WORK (export ?ALL))
(deftemplate item (slot a))
(deffunction twice (?x) (* 2 ?x))
(deffacts items (item (a 5)))
(defmodule USE (import WORK ?ALL))
(defglobal ?*g* = 3)
(defrule uses (item (a ?x)) => (println "item " (twice ?x) " " ?*g*) (bind ?*g* 9)))");
  lab.run_up();
  for (int life = 0; life < 2; ++life)
    for (const char* step : {"deactivate", "activate"}) EXPECT_EQ(caller.change(step), "{success: true}") << step;
  for (const char* line : {"begin 16 1", "item 10 3", "main again"}) EXPECT_EQ(lab.log.with(line).size(), 3u) << line;
  EXPECT_THAT(lab.log.with("error"), IsEmpty());
}

TEST_F(LifecycleTest, ATemplateThatWasChangedMeanwhileIsAnErrorAsInClips) {
  lab.options.keep_going = true;
  lab.run_up();
  EXPECT_EQ(caller.change("deactivate"), "{success: true}");
  lab.write("agent/rules.clp", "(deftemplate item (slot a) (slot b))");
  EXPECT_EQ(caller.change("activate"), "{success: true}");
  ASSERT_EQ(lab.manager->load_errors().size(), 1u);
  EXPECT_THAT(lab.manager->load_errors()[0].message, HasSubstr("CSTRCPSR4"));
  EXPECT_EQ(lab.manager->load_errors()[0].line, 1);
}

TEST_F(LifecycleTest, RefusesWhatTheStateDoesNotAllow) {
  lab.run_up();
  EXPECT_EQ(caller.change("configure"), "{success: false}");
  EXPECT_EQ(caller.call("/clips_manager/change_state", "lifecycle_msgs/srv/ChangeState", "{transition: {id: 99}}"),
            "{success: false}");
  EXPECT_EQ(lab.log.with("warn clips_manager: No transition matching").size(), 2u);
  EXPECT_EQ(caller.call("/clips_manager/change_state", "lifecycle_msgs/srv/ChangeState", "{transition: {id: 4}}"),
            "{success: true}")
      << "by number";
  EXPECT_FALSE(lab.manager->configure().ok());
}

TEST_F(LifecycleTest, TellsStatesAndTransitions) {
  lab.run_up();
  EXPECT_THAT(
      caller.call("/clips_manager/get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions"),
      ::testing::AllOf(
          HasSubstr(
              R"(transition: {id: 4, label: "deactivate"}, start_state: {id: 3, label: "active"}, goal_state: {id: 14, label: "deactivating"})"),
          HasSubstr(R"(transition: {id: 7, label: "shutdown"})"), ::testing::Not(HasSubstr("configure"))));
  EXPECT_THAT(
      caller.call("/clips_manager/get_available_states", "lifecycle_msgs/srv/GetAvailableStates"),
      ::testing::AllOf(HasSubstr(R"({id: 0, label: "unknown"})"), HasSubstr(R"({id: 15, label: "errorprocessing"})")));
  EXPECT_THAT(caller.call("/clips_manager/get_transition_graph", "lifecycle_msgs/srv/GetAvailableTransitions"),
              ::testing::AllOf(HasSubstr("configure"), HasSubstr("cleanup"), HasSubstr("activate")));
}

TEST_F(LifecycleTest, PublishesItsTransitions) {
  std::vector<std::string> heard;
  ASSERT_TRUE(lab.bus
                  .subscribe(caller.node(), "/clips_manager/transition_event",
                             **lab.registry.message("lifecycle_msgs/msg/TransitionEvent"),
                             [&](const bus::Delivery& d) {
                               const auto m = d.message->view();
                               heard.push_back(m.nested("start_state").text("label") + " " +
                                               m.nested("transition").text("label") + " " +
                                               m.nested("goal_state").text("label"));
                             })
                  .ok());
  ASSERT_TRUE(lab.create().ok());
  ASSERT_TRUE(lab.manager->configure().ok());
  caller.take();
  EXPECT_THAT(heard, ElementsAre("unconfigured configure configuring", "configuring transition_success inactive"));
}

TEST_F(LifecycleTest, AShutdownOfAnActiveNodeDeactivatesIt) {
  lab.run_up();
  EXPECT_EQ(caller.change("shutdown"), "{success: true}");
  EXPECT_EQ(lab.log.with("ends").size(), 1u);
  EXPECT_EQ(lab.manager->size(), 0u);
  lab.ticks(3);
}

TEST_F(LifecycleTest, AnUnknownWatchItemIsFoundAtConfigure) {
  lab.options.params = {{"/clips_manager.main.watch", "[facts, nonsense]"}};
  ASSERT_TRUE(lab.create().ok());
  const Status s = lab.manager->configure();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().text(), HasSubstr("Unknown watch item: nonsense"));
  EXPECT_EQ(lab.manager->state(), LifeState::kUnconfigured);
  EXPECT_EQ(lab.manager->size(), 0u);
}

TEST_F(LifecycleTest, AutostartIsAParameter) {
  ASSERT_TRUE(lab.create().ok());
  EXPECT_FALSE(lab.manager->autostart());
  lab.options.params = {{"clips_manager.autostart_node", "true"}};
  ASSERT_TRUE(lab.create().ok());
  EXPECT_TRUE(lab.manager->autostart());
}

}  // namespace
}  // namespace cxlab::cx
