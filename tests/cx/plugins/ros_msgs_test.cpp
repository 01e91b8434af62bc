#include "tests/support/causes.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A node of the test beside the environments.
class RosMsgs : public ::testing::Test {
 protected:
  void SetUp() override {
    node_ = lab_.bus.join(bus::ParticipantKind::kNode, {"peer", "/", {}}, lab_.records.open_stream("node/peer"));
  }

  const bus::MessageType& type(const std::string& name) { return **lab_.registry.message(name); }
  bus::SharedMessage text(const std::string& data) {
    bus::Message m(type("std_msgs/msg/String"));
    m->set("data", data);
    return std::make_shared<bus::Message>(std::move(m));
  }
  /// Runs this as the actions of a rule at the next due tick.
  void act(const std::string& actions) {
    static int count = 0;
    const std::string name = "act-" + std::to_string(++count);
    ASSERT_TRUE(lab_.engine().build("(defrule " + name + " (" + name + ") => " + actions + ")").ok());
    ASSERT_TRUE(lab_.engine().assert_string("(" + name + ")").ok());
    lab_.ticks(5);
  }
  /// The same, but the actions fail; returns the errors.
  std::string fail(const std::string& actions) {
    EXPECT_TRUE(lab_.engine().build("(defrule fails (fails) => " + actions + ")").ok());
    EXPECT_TRUE(lab_.engine().assert_string("(fails)").ok());
    for (int i = 0; i < 6; ++i)
      if (Status s = lab_.tick(); !s) {
        EXPECT_TRUE(lab_.engine().eval("(undefrule fails)").ok());
        return s.error().message;
      }
    ADD_FAILURE() << "no error: " << actions;
    return {};
  }

  Lab lab_;
  bus::ParticipantId node_{};
};

TEST_F(RosMsgs, PublishesWhatRulesMake) {
  lab_.agent("");
  lab_.run_up();
  std::vector<std::string> heard;
  ASSERT_TRUE(lab_.bus
                  .subscribe(node_, "/chatter", type("std_msgs/msg/String"),
                             [&](const bus::Delivery& d) { heard.push_back(d.message->view().text("data")); })
                  .ok());
  act(R"((ros-msgs-create-publisher "chatter" "std_msgs/msg/String")
         (bind ?m (ros-msgs-create-message "std_msgs/msg/String"))
         (ros-msgs-set-field ?m "data" "one") (ros-msgs-publish ?m "chatter")
         (ros-msgs-set-field ?m "data" two) (ros-msgs-publish ?m "chatter") (ros-msgs-destroy-message ?m))");
  lab_.bus.deliver(node_);
  EXPECT_THAT(heard, ElementsAre("one", "two")) << "a message on its way is not changed by what rules do to theirs";
  EXPECT_THAT(lab_.facts("ros-msgs-publisher"),
              ElementsAre("(ros-msgs-publisher (topic \"chatter\") (type \"std_msgs/msg/String\"))"));
}

TEST_F(RosMsgs, AMessageBecomesAFactUnderTheNameAsWritten) {
  lab_.agent(R"((deffacts start (go))
(defrule open (go) => (ros-msgs-create-subscription "chatter" "std_msgs/msg/String"))
(defrule hear ?f <- (ros-msgs-message (topic ?t) (msg-ptr ?m)) =>
  (println "heard " ?t " " (ros-msgs-get-field ?m "data")) (ros-msgs-destroy-message ?m) (retract ?f)))");
  lab_.run_up();
  const auto publisher = *lab_.bus.advertise(node_, "/chatter", type("std_msgs/msg/String"));
  lab_.ticks(1);
  lab_.bus.publish(publisher, text("hello"));
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("ros-msgs-message"), SizeIs(1)) << "asserted between runs";
  EXPECT_THAT(lab_.log.with("heard"), IsEmpty());
  lab_.ticks(4);
  EXPECT_THAT(lab_.log.with("heard"), ElementsAre("info main: heard chatter hello"));
  EXPECT_THAT(lab_.facts("ros-msgs-message"), IsEmpty());
  EXPECT_THAT(causes_of(lab_.records, "ros-msgs-message"),
              ElementsAre(AllOf(HasSubstr("input "), HasSubstr("topic"), HasSubstr("chatter"), HasSubstr("hello"))));
}

TEST_F(RosMsgs, OneEnvironmentHearsAnotherAtTheNextTick) {
  lab_.config(R"(environments: ["speaker", "hearer"]
speaker: {plugins: ["executive", "ros_msgs"]}
hearer: {plugins: ["executive", "ros_msgs"]}
executive: {plugin: "cx::ExecutivePlugin"}
ros_msgs: {plugin: "cx::RosMsgsPlugin"})");
  lab_.run_up();
  RuleEngine& speaker = lab_.engine("speaker");
  ASSERT_TRUE(speaker.eval("(ros-msgs-create-publisher \"a\" \"std_msgs/msg/Empty\")").ok());
  ASSERT_TRUE(lab_.engine("hearer").eval("(ros-msgs-create-subscription \"/a\" \"std_msgs/msg/Empty\")").ok());
  ASSERT_TRUE(speaker.eval("(ros-msgs-publish (ros-msgs-create-message \"std_msgs/msg/Empty\") \"a\")").ok());
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("ros-msgs-message", "hearer"), SizeIs(1));
}

TEST_F(RosMsgs, NumberOfSubscribersDoesNotMatterToAReceivedMessage) {
  lab_.agent(
      "(deffacts start (go)) (defrule open (go) => (ros-msgs-create-subscription \"a\" \"std_msgs/msg/String\"))\n"
      "(defrule change (ros-msgs-message (msg-ptr ?m)) => (ros-msgs-set-field ?m \"data\" \"mine\") (println "
      "(ros-msgs-get-field ?m \"data\")))");
  lab_.run_up();
  const bus::SharedMessage sent = text("theirs");
  lab_.bus.publish(*lab_.bus.advertise(node_, "a", type("std_msgs/msg/String")), sent);
  lab_.ticks(6);
  EXPECT_EQ(sent->view().text("data"), "theirs");
  EXPECT_THAT(lab_.log.with("mine"), SizeIs(1));
}

TEST_F(RosMsgs, OpeningTwiceAndClosingTheUnknownWarns) {
  lab_.agent("");
  lab_.run_up();
  act(R"((ros-msgs-create-publisher "a" "std_msgs/msg/Empty") (ros-msgs-create-publisher "a" "std_msgs/msg/Empty")
         (ros-msgs-destroy-publisher "b") (ros-msgs-destroy-subscription "b") (ros-msgs-destroy-client "b")
         (ros-msgs-destroy-service "b") (ros-msgs-destroy-action-client "b"))");
  EXPECT_THAT(lab_.log.with("warn ros_msgs: "), SizeIs(6));
  EXPECT_THAT(lab_.log.with("Already"), ElementsAre("warn ros_msgs: Already publishing to topic a"));
}

TEST_F(RosMsgs, ClosingTakesTheFactsBack) {
  lab_.agent("");
  lab_.run_up();
  act(R"((ros-msgs-create-publisher "a" "std_msgs/msg/Empty") (ros-msgs-create-subscription "a" "std_msgs/msg/Empty")
         (ros-msgs-create-client "s" "std_srvs/srv/Empty") (ros-msgs-create-service "s" "std_srvs/srv/Empty")
         (ros-msgs-create-action-client "f" "example_interfaces/action/Fibonacci"))");
  for (const char* name :
       {"ros-msgs-publisher", "ros-msgs-subscription", "ros-msgs-client", "ros-msgs-service", "ros-msgs-action-client"})
    EXPECT_THAT(lab_.facts(name), SizeIs(1)) << name;
  act(R"((ros-msgs-destroy-publisher "a") (ros-msgs-destroy-subscription "a") (ros-msgs-destroy-client "s")
         (ros-msgs-destroy-service "s") (ros-msgs-destroy-action-client "f"))");
  for (const char* name :
       {"ros-msgs-publisher", "ros-msgs-subscription", "ros-msgs-client", "ros-msgs-service", "ros-msgs-action-client"})
    EXPECT_THAT(lab_.facts(name), IsEmpty()) << name;
}

TEST_F(RosMsgs, AServiceCallsTheRulesDeffunction) {
  lab_.agent(R"((deffacts start (go))
(deffunction /switch-service-callback (?service ?request ?response)
  (ros-msgs-set-field ?response "success" (ros-msgs-get-field ?request "data"))
  (ros-msgs-set-field ?response "message" (str-cat "by " ?service)))
(defrule open (go) => (ros-msgs-create-service "/switch" "std_srvs/srv/SetBool")))");
  lab_.run_up();
  std::string answer;
  const auto service = *lab_.registry.service("std_srvs/srv/SetBool");
  const auto client = *lab_.bus.create_client(node_, "/switch", *service,
                                              [&](const bus::Delivery& d) { answer = d.message->view().to_string(); });
  bus::Message request(*service->request);
  request->set("data", true);
  lab_.bus.call(client, std::make_shared<bus::Message>(std::move(request)));
  lab_.ticks(1);
  lab_.bus.deliver(node_);
  EXPECT_EQ(answer, "{success: true, message: \"by /switch\"}");
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("message(s)"), IsEmpty()) << "request and response go by themselves";
}

TEST_F(RosMsgs, AServiceWithoutDeffunctionAnswersTheDefault) {
  lab_.agent(
      "(deffacts start (go)) (defrule open (go) => (ros-msgs-create-service \"switch\" \"std_srvs/srv/SetBool\"))");
  lab_.run_up();
  int answers = 0;
  const auto service = *lab_.registry.service("std_srvs/srv/SetBool");
  const auto client = *lab_.bus.create_client(node_, "/switch", *service, [&](const bus::Delivery&) { ++answers; });
  lab_.bus.call(client, std::make_shared<bus::Message>(*service->request));
  lab_.ticks(1);
  lab_.bus.deliver(node_);
  EXPECT_EQ(answers, 1);
  EXPECT_THAT(lab_.log.with("not defined"),
              ElementsAre("warn ros_msgs: switch-service-callback not defined, skip callback"));
}

TEST_F(RosMsgs, AnErrorInACallbackHasItsPlace) {
  lab_.agent(R"((deffacts start (go))
(deffunction switch-service-callback (?s ?request ?response)
  (ros-msgs-set-field ?response "success" 5))
(defrule open (go) => (ros-msgs-create-service "switch" "std_srvs/srv/SetBool")))");
  lab_.run_up();
  const auto service = *lab_.registry.service("std_srvs/srv/SetBool");
  const auto client = *lab_.bus.create_client(node_, "/switch", *service, [](const bus::Delivery&) {});
  lab_.bus.call(client, std::make_shared<bus::Message>(*service->request));
  const Status s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().file, (lab_.folder / "agent/rules.clp").string());
  EXPECT_EQ(s.error().line, 3);
  EXPECT_EQ(lab_.manager->rule_errors().at(0).error.side, ErrorSide::kCallback);
  EXPECT_EQ(lab_.manager->rule_errors().at(0).error.rule, "switch-service-callback");
  EXPECT_THAT(s.error().message, HasSubstr("found 5, expected TRUE or FALSE"));
}

TEST_F(RosMsgs, ARequestGetsItsNumberAndItsResponseAFact) {
  lab_.agent("");
  lab_.run_up();
  const auto service = *lab_.registry.service("std_srvs/srv/Trigger");
  bus::EndpointId server{};
  server = *lab_.bus.serve(node_, "/go", *service, [&](const bus::Delivery& request) {
    bus::Message response(*service->response);
    response->set("message", "done");
    lab_.bus.respond(server, request, std::make_shared<bus::Message>(std::move(response)));
  });
  act(R"((ros-msgs-create-client "go" "std_srvs/srv/Trigger") (bind ?r (ros-msgs-create-request "std_srvs/srv/Trigger"))
         (println "ids " (ros-msgs-async-send-request ?r "go") " " (ros-msgs-async-send-request ?r "go")) (ros-msgs-destroy-message ?r))");
  EXPECT_THAT(lab_.log.with("ids"), ElementsAre("info main: ids 1 2"));
  lab_.bus.deliver(node_);
  lab_.ticks(1);
  const auto responses = lab_.engine().facts("ros-msgs-response");
  ASSERT_THAT(responses, SizeIs(2));
  EXPECT_EQ(*responses[0].slot("service"), Value::string("go"));
  EXPECT_EQ(*responses[0].slot("request-id"), Value::integer(1));
  EXPECT_EQ(*responses[1].slot("request-id"), Value::integer(2));
  act("(do-for-all-facts ((?f ros-msgs-response)) TRUE (println \"said \" (ros-msgs-get-field ?f:msg-ptr "
      "\"message\")))");
  EXPECT_THAT(lab_.log.with("said"), SizeIs(2));
  const auto input = AllOf(HasSubstr("input "), HasSubstr("response"), HasSubstr("go"), HasSubstr("done"));
  EXPECT_THAT(causes_of(lab_.records, "ros-msgs-response"), ElementsAre(input, input));
}

TEST_F(RosMsgs, AMissingServiceIsFalseAtOnce) {
  lab_.agent("");
  lab_.run_up();
  act(R"((ros-msgs-create-client "go" "std_srvs/srv/Trigger")
         (println "sent " (ros-msgs-async-send-request (ros-msgs-create-request "std_srvs/srv/Trigger") "go")))");
  EXPECT_THAT(lab_.log.with("sent"), ElementsAre("info main: sent FALSE"));
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn ros_msgs: service go not available, abort request."));
}

TEST_F(RosMsgs, RulesThatAskAMissingServiceOftenFillNoLog) {
  lab_.agent("");
  lab_.run_up();
  const std::string ask = "(ros-msgs-async-send-request (ros-msgs-create-request \"std_srvs/srv/Trigger\") \"go\")";
  const std::string line = "warn ros_msgs: service go not available, abort request.";
  const auto asked = [&] { return lab_.engine().eval(ask)->print(); };
  act("(ros-msgs-create-client \"go\" \"std_srvs/srv/Trigger\")");
  const SimTime begin = lab_.bus.now();
  while (lab_.bus.now() < begin + std::chrono::seconds(15)) {
    EXPECT_EQ(asked(), "FALSE");
    lab_.ticks(1);
  }
  EXPECT_THAT(lab_.log.with(line), SizeIs(2)) << "at once and after 10 s";
  const auto service =
      lab_.bus.serve(node_, "/go", **lab_.registry.service("std_srvs/srv/Trigger"), [](const auto&) {});
  ASSERT_TRUE(service);
  EXPECT_EQ(asked(), "1");
  lab_.bus.remove(*service);
  EXPECT_EQ(asked(), "FALSE");
  EXPECT_THAT(lab_.log.with(line), SizeIs(3)) << "it was there in between";
}

TEST_F(RosMsgs, WhatCxLeavesUndefinedIsAnErrorHere) {
  lab_.agent("");
  lab_.run_up();
  EXPECT_THAT(fail("(ros-msgs-create-message \"std_msgs/msg/Strin\")"), HasSubstr("std_msgs/msg/String"));
  EXPECT_THAT(fail("(ros-msgs-publish (ros-msgs-create-message \"std_msgs/msg/Empty\") \"nowhere\")"),
              HasSubstr("no publisher for topic nowhere"));
  EXPECT_THAT(fail("(ros-msgs-create-publisher \"t\" \"std_msgs/msg/String\") (ros-msgs-publish "
                   "(ros-msgs-create-message \"std_msgs/msg/Empty\") \"t\")"),
              HasSubstr("topic t has std_msgs/msg/String"));
  EXPECT_THAT(fail("(ros-msgs-create-subscription \"t\" \"std_msgs/msg/Int32\")"), HasSubstr("std_msgs/msg/String"));
  EXPECT_THAT(fail("(ros-msgs-async-send-request (ros-msgs-create-request \"std_srvs/srv/Empty\") \"none\")"),
              HasSubstr("no client for service none"));
  const std::string gone = "(bind ?m (ros-msgs-create-message \"std_msgs/msg/Empty\")) (ros-msgs-destroy-message ?m) ";
  EXPECT_THAT(fail(gone + "(ros-msgs-async-send-request ?m \"none\")"),
              HasSubstr("Failed to send request: invalid message pointer"));
  EXPECT_THAT(fail(gone + "(ros-msgs-async-send-goal ?m \"none\")"),
              HasSubstr("Failed to send goal: invalid message pointer"));
  EXPECT_THAT(
      fail(
          "(ros-msgs-async-send-goal (ros-msgs-create-goal-request \"example_interfaces/action/Fibonacci\") \"none\")"),
      HasSubstr("no action client for server none"));
}

TEST_F(RosMsgs, PublishingAnUnknownMessageIsAnErrorLineAsInCx) {
  lab_.agent("");
  lab_.run_up();
  act("(ros-msgs-create-publisher \"t\" \"std_msgs/msg/Empty\") (bind ?m (ros-msgs-create-message "
      "\"std_msgs/msg/Empty\"))"
      "(ros-msgs-destroy-message ?m) (ros-msgs-destroy-message ?m) (ros-msgs-publish ?m \"t\")");
  EXPECT_THAT(lab_.log.with("error "), ElementsAre("error ros_msgs: Failed to publish invalid msg pointer"));
}

TEST_F(RosMsgs, OpenEndpointsAreReportedAtTheEnd) {
  lab_.agent("");
  lab_.run_up();
  act(R"((ros-msgs-create-publisher "a" "std_msgs/msg/Empty") (ros-msgs-create-subscription "b" "std_msgs/msg/Empty")
         (ros-msgs-create-client "c" "std_srvs/srv/Empty") (ros-msgs-create-service "d" "std_srvs/srv/Empty")
         (ros-msgs-create-action-client "e" "example_interfaces/action/Fibonacci")
         (ros-msgs-get-field (ros-msgs-create-message "geometry_msgs/msg/Twist") "linear") (ros-msgs-create-message "std_msgs/msg/Empty"))");
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn ros_msgs: Environment main has open b subscription, cleaning up ...",
                          "warn ros_msgs: Environment main has open a publishers, cleaning up ...",
                          "warn ros_msgs: Environment main has open c clients, cleaning up ...",
                          "warn ros_msgs: Environment main has open d services, cleaning up ...",
                          "warn ros_msgs: Environment main has open e action clients, cleaning up ...",
                          "warn ros_msgs: Found 2 message(s), cleaning up ..."));
}

TEST_F(RosMsgs, LeftMessagesAreReportedWhenThePluginIsFinalized) {
  lab_.agent("");
  lab_.run_up();
  act("(ros-msgs-create-message \"std_msgs/msg/Empty\")");
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  ASSERT_FALSE(lab_.log.lines.empty());
  EXPECT_EQ(lab_.log.lines.at(lab_.log.lines.size() - 2), "warn ros_msgs: Found 1 message(s), cleaning up ...")
      << "after every plugin was deactivated, as in CX";
}

TEST_F(RosMsgs, UnloadingWhileRulesUseItLeavesThemAnError) {
  lab_.agent(R"((deffacts start (open))
(defrule open (open) => (ros-msgs-create-subscription "a" "std_msgs/msg/String") (ros-msgs-create-publisher "b" "std_msgs/msg/String"))
(defrule hear ?f <- (ros-msgs-message (msg-ptr ?m)) => (retract ?f) (println "heard " (ros-msgs-get-field ?m "data")))
(defrule say ?f <- (say) => (retract ?f) (ros-msgs-publish (ros-msgs-create-message "std_msgs/msg/String") "b")))");
  lab_.run_up();
  const auto publisher = *lab_.bus.advertise(node_, "/a", type("std_msgs/msg/String"));
  lab_.bus.publish(publisher, text("on its way"));
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "ros_msgs").ok());
  EXPECT_THAT(lab_.log.with("warn ros_msgs: Environment main has open"),
              ElementsAre("warn ros_msgs: Environment main has open a subscription, cleaning up ...",
                          "warn ros_msgs: Environment main has open b publishers, cleaning up ..."));
  EXPECT_THAT(lab_.log.with("ros-msgs-message cant be undefined"), SizeIs(1)) << "a rule uses it";
  EXPECT_TRUE(lab_.engine().has("deftemplate", "ros-msgs-message"));
  EXPECT_FALSE(lab_.engine().has("deftemplate", "ros-msgs-client")) << "nobody uses it";
  lab_.ticks(6);
  EXPECT_THAT(lab_.facts("ros-msgs-message"), IsEmpty()) << "what was on its way is dropped";
  ASSERT_TRUE(lab_.engine().assert_string("(say)").ok());
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("belongs to unloaded plugin ros_msgs"));

  ASSERT_TRUE(lab_.manager->load_plugin("main", "ros_msgs").ok());
  lab_.ticks(1);  // the one that failed
  act("(ros-msgs-create-subscription \"a\" \"std_msgs/msg/String\")");
  lab_.bus.publish(publisher, text("again"));
  lab_.ticks(6);
  EXPECT_THAT(lab_.log.with("heard"), ElementsAre("info main: heard again"))
      << "old rules call the plugin that came back";
}

TEST_F(RosMsgs, ActingFunctionsHaveNoPlaceOnALeftHandSide) {
  lab_.agent("(defrule bad (go) (test (ros-msgs-create-message \"std_msgs/msg/Empty\")) =>)");
  const Status s = lab_.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().line, 1);
}

}  // namespace
}  // namespace cxlab::cx
