#include "tests/support/causes.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// Rules with a Fibonacci client "fib" that print what comes, and a server that the test moves.
class ActionClients : public ::testing::Test {
 protected:
  void SetUp() override {
    lab_.agent(R"((deffacts start (open))
(defrule open (open) =>
  (ros-msgs-create-action-client "fib" "example_interfaces/action/Fibonacci"))
(defrule send ?f <- (send ?n) =>
  (retract ?f)
  (bind ?g (ros-msgs-create-goal-request "example_interfaces/action/Fibonacci"))
  (ros-msgs-set-field ?g "order" ?n)
  (ros-msgs-async-send-goal ?g "fib"))
(defrule answered (ros-msgs-goal-response (server "fib") (client-goal-handle-ptr ?h)) =>
  (println "answered " (ros-msgs-client-goal-handle-get-status ?h) " at " (ros-msgs-client-goal-handle-get-goal-stamp ?h)
    " feedback " (ros-msgs-client-goal-handle-is-feedback-aware ?h) " id " (str-length (ros-msgs-client-goal-handle-get-goal-id ?h))))
(defrule feedback (ros-msgs-feedback (client-goal-handle-ptr ?h) (feedback-ptr ?m)) =>
  (println "feedback " (ros-msgs-get-field ?m "sequence")))
(defrule cancel (cancel) (ros-msgs-goal-response (client-goal-handle-ptr ?h)) =>
  (ros-msgs-async-cancel-goal "fib" ?h))
(defrule cancelled (ros-msgs-cancel-response (cancel-response-ptr ?m)) =>
  (bind ?info (nth$ 1 (ros-msgs-get-field ?m "goals_canceling")))
  (println "cancel " (ros-msgs-get-field ?m "return_code") " "
    (ros-msgs-goal-uuid-to-string (ros-msgs-get-field (ros-msgs-get-field ?info "goal_id") "uuid"))))
(defrule ended (ros-msgs-goal-response (client-goal-handle-ptr ?h)) (ros-msgs-wrapped-result (server ?s) (goal-id ?id) (code ?code) (result-ptr ?m)) =>
  (println "ended " ?s " " ?code " " (ros-msgs-get-field ?m "sequence") " " (ros-msgs-client-goal-handle-get-status ?h)
    " " (eq ?id (ros-msgs-client-goal-handle-get-goal-id ?h))))
)");
    type_ = *lab_.registry.action("example_interfaces/action/Fibonacci");
    lab_.run_up();
  }
  void serve(bus::GoalAnswer answer = bus::GoalAnswer::kAccept) {
    node_ = lab_.bus.join(bus::ParticipantKind::kNode, {"server", "/", {}}, lab_.records.open_stream("node/server"));
    server_ = *lab_.bus.serve_action(node_, "/fib", *type_,
                                     {[this, answer](const bus::Delivery& d) {
                                        goal_ = d.goal;
                                        order_ = d.message->view().integer("order");
                                        lab_.bus.answer_goal(server_, d.goal, answer);
                                      },
                                      [this](const bus::Delivery& d) { lab_.bus.answer_cancel(server_, d, true); }});
  }
  bus::SharedMessage sequence(const bus::MessageType& type, std::vector<int> values) {
    bus::Message m(type);
    const bus::Field& field = *type.find("sequence");
    EXPECT_TRUE(m.view().resize(field, values.size()).ok());
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_TRUE(m.view().set_integer(field, values[i], i).ok());
    return std::make_shared<bus::Message>(std::move(m));
  }
  /// Ticks of the executive until it is due again; the server acts at the end of each.
  void run() {
    for (int i = 0; i < 5; ++i) {
      lab_.ticks(1);
      if (server_ != bus::EndpointId{}) lab_.bus.deliver(node_);
    }
  }
  void put(const std::string& fact) { ASSERT_TRUE(lab_.engine().assert_string(fact).ok()); }

  Lab lab_;
  const bus::ActionType* type_ = nullptr;
  bus::ParticipantId node_{};
  bus::EndpointId server_{};
  bus::GoalId goal_{};
  std::int64_t order_ = 0;
};

TEST_F(ActionClients, AGoalGoesThroughToItsResult) {
  serve();
  put("(send 3)");
  run();
  EXPECT_EQ(order_, 3);
  run();
  EXPECT_THAT(lab_.log.with("answered"), ElementsAre("info main: answered EXECUTING at 0.0 feedback TRUE id 32"));
  lab_.bus.publish_feedback(server_, goal_, sequence(*type_->feedback, {0, 1}));
  run();
  EXPECT_THAT(lab_.log.with("feedback ("), ElementsAre("info main: feedback (0 1)"));
  lab_.bus.finish(server_, goal_, bus::GoalStatus::kSucceeded, sequence(*type_->result, {0, 1, 1}));
  run();
  EXPECT_THAT(lab_.log.with("ended"), ElementsAre("info main: ended fib SUCCEEDED (0 1 1) SUCCEEDED TRUE"));
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
  for (const char* what : {"goal-response", "feedback", "wrapped-result"}) {
    const std::string word = what == std::string("wrapped-result") ? "result" : what;
    EXPECT_THAT(causes_of(lab_.records, "ros-msgs-" + std::string(what)),
                ElementsAre(AllOf(StartsWith("input "), HasSubstr("what"), HasSubstr(word), HasSubstr("fib"))))
        << what;
  }
}

TEST_F(ActionClients, AGoalWaitsForItsServer) {
  put("(send 3)");
  put("(send 4)");
  run();
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty()) << "it may come within a second";
  lab_.ticks(60);
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn ros_msgs: server fib not available, start waiting"));
  serve();
  run();
  run();
  EXPECT_THAT(lab_.log.with("finally"), ElementsAre("info ros_msgs: server fib is finally reachable"));
  EXPECT_THAT(lab_.facts("ros-msgs-goal-response"), SizeIs(2));
}

TEST_F(ActionClients, AServerThatComesWithinASecondIsNoWarning) {
  put("(send 3)");
  lab_.ticks(30);
  serve();
  run();
  run();
  lab_.ticks(60);
  EXPECT_THAT(lab_.facts("ros-msgs-goal-response"), SizeIs(1));
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
  EXPECT_THAT(lab_.log.with("finally"), IsEmpty());
}

TEST_F(ActionClients, ACancelIsAnsweredAndEndsTheGoal) {
  serve();
  put("(send 3)");
  run();
  run();
  put("(cancel)");
  run();
  run();
  EXPECT_THAT(lab_.log.with("cancel 0"), ElementsAre("info main: cancel 0 " + bus::to_string(goal_)));
  lab_.bus.finish(server_, goal_, bus::GoalStatus::kCanceled, sequence(*type_->result, {}));
  run();
  EXPECT_THAT(lab_.log.with("ended"), ElementsAre("info main: ended fib CANCELED () CANCELED TRUE"));
}

TEST_F(ActionClients, ARejectedGoalGivesANullHandleWhoseUseIsAnError) {
  serve(bus::GoalAnswer::kReject);
  put("(send 3)");
  run();
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message,
              HasSubstr("unknown client goal handle: a null pointer, as of a goal that was rejected"));
  EXPECT_EQ(*lab_.engine().facts("ros-msgs-goal-response").at(0).slot("client-goal-handle-ptr"),
            Value::handle(Handle::kNone));
}

TEST_F(ActionClients, TheRuleOfThePageKnowsARejectedGoal) {
  serve(bus::GoalAnswer::kReject);
  ASSERT_TRUE(lab_.engine().undefine("defrule", "answered").ok()) << "it would ask a null handle";
  const std::string rules = lab_.page_code("docs/reference/plugins/ros_msgs.md", "is-null");
  ASSERT_TRUE(lab_.engine().load_text(rules, "page.clp", LoadMode::kConstructs).ok()) << rules;
  put("(send 3)");
  run();
  run();
  EXPECT_THAT(lab_.log.with("no: "), ElementsAre("info main: no: fib"));
}

TEST_F(ActionClients, GoalHandlesThatAreLeftAreTold) {
  serve();
  put("(send 3)");
  run();
  run();
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn ros_msgs: Environment main has open fib action clients, cleaning up ...",
                          "warn ros_msgs: Found 1 client_goal_handle(s), cleaning up ...",
                          "warn ros_msgs: Found 1 message(s), cleaning up ..."));
}

TEST_F(ActionClients, UnloadingWhileAGoalRunsDropsWhatWouldCome) {
  serve();
  put("(send 3)");
  run();
  run();
  ASSERT_THAT(lab_.log.with("answered EXECUTING"), SizeIs(1));
  lab_.bus.publish_feedback(server_, goal_, sequence(*type_->feedback, {0, 1}));
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "ros_msgs").ok());
  lab_.bus.finish(server_, goal_, bus::GoalStatus::kSucceeded, sequence(*type_->result, {0, 1, 1}));
  run();
  EXPECT_THAT(lab_.facts("ros-msgs-feedback"), IsEmpty());
  EXPECT_THAT(lab_.facts("ros-msgs-wrapped-result"), IsEmpty());
  EXPECT_THAT(lab_.facts("ros-msgs-goal-response"), SizeIs(1))
      << "facts that are there stay, and so do their templates";
  ASSERT_TRUE(lab_.manager->load_plugin("main", "ros_msgs").ok());
  put("(cancel)");
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("unknown client goal handle")) << "it went with the plugin";
}

TEST_F(ActionClients, AUuidHasSixteenBytes) {
  auto hex = lab_.engine().eval("(ros-msgs-goal-uuid-to-string (create$ 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 255))");
  ASSERT_TRUE(hex.ok());
  EXPECT_EQ(*hex, Value::symbol("000102030405060708090a0b0c0d0eff"));
  auto wrong = lab_.engine().eval("(ros-msgs-goal-uuid-to-string (create$ 1 2))");
  ASSERT_TRUE(wrong.ok());
  EXPECT_EQ(*wrong, Value::boolean(false));
  const auto errors = lab_.engine().take_errors();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_THAT(errors[0].message, HasSubstr("found (1 2), expected 16 integers from 0 to 255"));
}

}  // namespace
}  // namespace cxlab::cx
