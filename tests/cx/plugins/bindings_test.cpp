#include "cx/plugins/bindings/names.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(BindingNames, FollowTheGeneratorOfCx) {
  EXPECT_EQ(binding_class_name("std_msgs/msg/String"), "cx::CXStdMsgsStringPlugin");
  EXPECT_EQ(binding_class_name("cx_pddl_interfaces/action/PlanTemporal"), "cx::CXCxPddlInterfacesPlanTemporalPlugin");
  EXPECT_EQ(kebab_case("StdMsgsString"), "std-msgs-string");
  EXPECT_EQ(kebab_case("StdSrvsSetBool"), "std-srvs-set-bool");
  EXPECT_EQ(kebab_case("ExampleInterfacesFibonacci"), "example-interfaces-fibonacci");
  EXPECT_EQ(kebab_case("StdMsgsUInt16"), "std-msgs-u-int16");
  EXPECT_EQ(kebab_case("Tf2MsgsTFMessage"), "tf2-msgs-tf-message");
  EXPECT_EQ(kebab_case("GeometryMsgsVector3"), "geometry-msgs-vector3");
}

TEST(BindingNames, EveryInterfaceIsFoundByItsClass) {
  Lab lab;
  std::size_t count = 0;
  for (const std::string& package : lab.registry.packages())
    for (const std::string& interface : lab.registry.interfaces(package)) {
      const auto found = find_binding(binding_class_name(interface), lab.registry);
      ASSERT_TRUE(found) << interface;
      EXPECT_EQ(found->interface, interface);
      ++count;
    }
  EXPECT_GT(count, 200U);
  EXPECT_FALSE(find_binding("cx::CXStdMsgsPlugin", lab.registry));
  EXPECT_FALSE(find_binding("cx::ExecutivePlugin", lab.registry));
  EXPECT_FALSE(find_binding("cx::CXPlugin", lab.registry));
}

/// An environment "main" with bindings, and a node of the test beside it. Rules are those of `rules`.
class Bindings : public ::testing::Test {
 protected:
  void run(const std::vector<std::string>& classes, const std::string& rules = "") {
    std::string names, sections;
    for (const std::string& c : classes) {
      const std::string name = kebab_case(c);
      names += ", \"" + name + '"';
      sections += name + ": {plugin: \"cx::CX" + c + "Plugin\"}\n";
    }
    lab_.config(manager_ + "environments: [\"main\"]\nmain: {plugins: [\"executive\"" + names +
                ", \"files\"]}\n"
                "executive: {plugin: \"cx::ExecutivePlugin\"}\n" +
                sections +
                "files: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}");
    lab_.write("agent/rules.clp", rules);
    lab_.run_up();
    node_ = lab_.bus.join(bus::ParticipantKind::kNode, {"peer", "/", {}}, lab_.records.open_stream("node/peer"));
  }
  /// Runs this as the actions of a rule; what the rule's error says, empty without one.
  std::string act(const std::string& actions) {
    const std::string name = "act-" + std::to_string(++count_);
    EXPECT_TRUE(lab_.engine().build("(defrule " + name + " ?f <- (" + name + ") => (retract ?f) " + actions + ")").ok())
        << actions;
    EXPECT_TRUE(lab_.engine().assert_string("(" + name + ")").ok());
    for (int i = 0; i < 6; ++i)
      if (const Status s = lab_.tick(); !s) return s.error().message;
    return {};
  }
  std::string value(const std::string& expression) {
    const auto v = lab_.engine().eval(expression);
    return v ? v->print() : v.error().message;
  }
  /// What a rule printed after "said ".
  std::vector<std::string> said() const { return lab_.log.with("said "); }

  std::string manager_;  ///< parameters of the manager
  Lab lab_;
  bus::ParticipantId node_{};
  int count_ = 0;
};

TEST_F(Bindings, AMessageGoesOutAndComesBackUnderItsOwnFacts) {
  run({"StdMsgsString"}, R"((defrule hear ?f <- (std-msgs-string-message (topic ?t) (msg-ptr ?m)) =>
  (println "said " ?t " " (std-msgs-string-get-field ?m "data")) (std-msgs-string-destroy-message ?m) (retract ?f)))");
  EXPECT_EQ(act(R"((std-msgs-string-create-subscription "chatter") (std-msgs-string-create-publisher "/chatter")
    (bind ?m (std-msgs-string-create-message)) (std-msgs-string-set-field ?m "data" "hello")
    (std-msgs-string-publish ?m "/chatter") (std-msgs-string-destroy-message ?m))"),
            "");
  lab_.ticks(5);
  EXPECT_THAT(said(), ElementsAre("info main: said chatter hello"));
  EXPECT_THAT(lab_.facts("std-msgs-string-publisher"), ElementsAre("(std-msgs-string-publisher (topic \"/chatter\"))"));
  EXPECT_EQ(act(R"((std-msgs-string-destroy-publisher "/chatter") (std-msgs-string-destroy-subscription "chatter"))"),
            "");
  EXPECT_THAT(lab_.facts("std-msgs-string-publisher"), SizeIs(1)) << "as in CX the fact of a publisher stays";
  EXPECT_THAT(lab_.facts("std-msgs-string-subscription"), IsEmpty());
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST_F(Bindings, OpeningTwiceAndClosingTheUnknownWarns) {
  run({"StdMsgsString", "StdSrvsSetBool", "ExampleInterfacesFibonacci"});
  EXPECT_EQ(
      act(R"((std-msgs-string-create-publisher a) (std-msgs-string-create-publisher a) (std-msgs-string-destroy-publisher b)
    (std-msgs-string-create-subscription "a") (std-msgs-string-create-subscription "a") (std-msgs-string-destroy-subscription "b")
    (std-srvs-set-bool-create-client "a") (std-srvs-set-bool-create-client "a") (std-srvs-set-bool-destroy-client "b")
    (std-srvs-set-bool-create-service a) (std-srvs-set-bool-create-service a) (std-srvs-set-bool-destroy-service b)
    (example-interfaces-fibonacci-create-client "a") (example-interfaces-fibonacci-create-client "a") (example-interfaces-fibonacci-destroy-client "b")
    (example-interfaces-fibonacci-create-server a) (example-interfaces-fibonacci-create-server a) (example-interfaces-fibonacci-destroy-server b))"),
      "");
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn std-msgs-string: Already publishing to topic a",
                          "warn std-msgs-string: Publisher b not found in environment main",
                          "warn std-msgs-string: Already subscribed to topic a",
                          "warn std-msgs-string: Subscription b not found in environment main",
                          "warn std-srvs-set-bool: Already registered to client a",
                          "warn std-srvs-set-bool: Client b not found in environment main",
                          "warn std-srvs-set-bool: Already registered to service a",
                          "warn std-srvs-set-bool: Service b not found in environment main",
                          "warn example-interfaces-fibonacci: Already registered to action client for a",
                          "warn example-interfaces-fibonacci: Action client b not found in environment main",
                          "warn example-interfaces-fibonacci: Already providing action server a",
                          "warn example-interfaces-fibonacci: Action server b not found in environment main"));
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("has open a"), SizeIs(6)) << "what is left open is told";
}

TEST_F(Bindings, AnUnknownSlotIsToldAndEndsTheRule) {
  run({"StdMsgsString"});
  EXPECT_THAT(act("(std-msgs-string-get-field (std-msgs-string-create-message) dta) (println \"said more\")"),
              HasSubstr("std_msgs/msg/String has no field 'dta', did you mean 'data'?"));
  EXPECT_THAT(act("(std-msgs-string-set-field (std-msgs-string-create-message) dta x)"),
              HasSubstr("did you mean 'data'?"));
  EXPECT_THAT(lab_.log.with("unknown slot"),
              ElementsAre("error std-msgs-string: std-msgs-string-get-field: cannot retrieve unknown slot name dta",
                          "error std-msgs-string: std-msgs-string-set-field: cannot set unknown slot name dta"));
  EXPECT_THAT(said(), IsEmpty());
}

TEST_F(Bindings, AMessageOfAnotherTypeWithTheSameFieldsIsTakenWithAWarning) {
  run({"GeometryMsgsPoint", "GeometryMsgsVector3", "GeometryMsgsTwist"});
  EXPECT_EQ(act("(bind ?p (geometry-msgs-point-create-message)) (geometry-msgs-point-set-field ?p y 4.0) "
                "(bind ?t (geometry-msgs-twist-create-message)) (geometry-msgs-twist-set-field ?t linear ?p) "
                "(println \"said \" (geometry-msgs-vector3-get-field (geometry-msgs-twist-get-field ?t linear) y))"),
            "");
  EXPECT_THAT(said(), ElementsAre("info main: said 4.0"));
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn geometry-msgs-twist: found a message of type geometry_msgs/msg/Point, expected "
                          "geometry_msgs/msg/Vector3: it has the same fields, so it is accepted"));
}

TEST_F(Bindings, TheNextCxNumbersRequestsAndWaitsForNobody) {
  manager_ = "compat: next\n";
  run({"StdSrvsSetBool"}, R"((deffunction std-srvs-set-bool-service-callback (?service ?request ?response))
(defrule answered (std-srvs-set-bool-response (service ?s) (request-id ?id)) => (println "said " ?s " " ?id)))");
  EXPECT_EQ(act(R"((std-srvs-set-bool-create-client "/switch") (bind ?r (std-srvs-set-bool-request-create))
    (println "said " (std-srvs-set-bool-send-request ?r "/switch")))"),
            "");
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn std-srvs-set-bool: service /switch not available, abort request."));
  EXPECT_EQ(act(R"((std-srvs-set-bool-create-service "/switch") (bind ?r (std-srvs-set-bool-request-create))
    (println "said " (std-srvs-set-bool-send-request ?r "/switch"))
    (println "said " (std-srvs-set-bool-send-request ?r "/switch")))"),
            "");
  lab_.ticks(10);
  EXPECT_THAT(said(), ElementsAre("info main: said FALSE", "info main: said 1", "info main: said 2",
                                  "info main: said /switch 2", "info main: said /switch 1"));
}

TEST_F(Bindings, WhatCxLeavesUndefinedIsAnError) {
  run({"StdMsgsString", "StdMsgsInt32", "StdSrvsSetBool", "ExampleInterfacesFibonacci"});
  EXPECT_THAT(act("(std-msgs-string-get-field (std-msgs-int32-create-message) data)"),
              HasSubstr("found a message of type std_msgs/msg/Int32"));
  EXPECT_THAT(act("(std-msgs-int32-set-field (std-msgs-int32-create-message) data 1.5)"),
              HasSubstr("found 1.5, expected a whole number"));
  EXPECT_THAT(act("(bind ?m (std-msgs-string-create-message)) (std-msgs-string-destroy-message ?m) "
                  "(std-msgs-string-get-field ?m data)"),
              HasSubstr("invalid message pointer"));
  EXPECT_THAT(act("(std-msgs-string-publish (std-msgs-string-create-message) nowhere)"),
              HasSubstr("no publisher for topic nowhere"));
  EXPECT_THAT(act("(std-srvs-set-bool-send-request (std-srvs-set-bool-request-create) nowhere)"),
              HasSubstr("no client for service nowhere"));
  EXPECT_THAT(act("(example-interfaces-fibonacci-send-goal (example-interfaces-fibonacci-goal-create) nowhere)"),
              HasSubstr("no action client for server nowhere"));
  EXPECT_EQ(value("(std-msgs-int32-set-field (std-msgs-int32-create-message) data 2.0)"), "");
}

TEST_F(Bindings, ANestedMessageIsReadByTheBindingsOfItsType) {
  run({"GeometryMsgsTwist", "GeometryMsgsVector3"});
  EXPECT_EQ(act(R"((bind ?t (geometry-msgs-twist-create-message)) (bind ?v (geometry-msgs-twist-get-field ?t "linear"))
    (geometry-msgs-vector3-set-field ?v "x" 2.5) (bind ?w (geometry-msgs-vector3-create-message)) (geometry-msgs-vector3-set-field ?w x 3)
    (geometry-msgs-twist-set-field ?t angular ?w) (geometry-msgs-vector3-set-field ?w x 4)
    (println "said " (geometry-msgs-vector3-get-field (geometry-msgs-twist-get-field ?t "linear") "x") " "
      (geometry-msgs-vector3-get-field (geometry-msgs-twist-get-field ?t angular) x))
    (geometry-msgs-vector3-destroy-message ?w) (geometry-msgs-twist-destroy-message ?t))"),
            "");
  EXPECT_THAT(said(), ElementsAre("info main: said 2.5 3.0"));
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("message(s)"), IsEmpty());
}

TEST_F(Bindings, AServiceCallsItsDeffunctionAndTheResponseHasNoNumber) {
  run({"StdSrvsSetBool"}, R"((deffunction std-srvs-set-bool-service-callback (?service ?request ?response)
  (std-srvs-set-bool-response-set-field ?response "success" (std-srvs-set-bool-request-get-field ?request "data"))
  (std-srvs-set-bool-response-set-field ?response "message" (str-cat "by " ?service)))
(defrule answered ?f <- (std-srvs-set-bool-response (service ?s) (msg-ptr ?m)) =>
  (println "said " ?s " " (std-srvs-set-bool-response-get-field ?m success) " " (std-srvs-set-bool-response-get-field ?m message))
  (std-srvs-set-bool-response-destroy ?m) (retract ?f)))");
  EXPECT_EQ(
      act(R"((std-srvs-set-bool-create-client "/switch") (bind ?r (std-srvs-set-bool-request-create)) (std-srvs-set-bool-request-set-field ?r data TRUE)
    (std-srvs-set-bool-send-request ?r "/switch") (std-srvs-set-bool-send-request ?r "/switch") (std-srvs-set-bool-request-destroy ?r))"),
      "");
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty()) << "it may come within a second";
  lab_.ticks(60);
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn std-srvs-set-bool: service /switch not available, start waiting"));
  EXPECT_EQ(act("(std-srvs-set-bool-create-service \"switch\")"), "");
  lab_.ticks(10);
  EXPECT_THAT(lab_.log.with("finally"), ElementsAre("info std-srvs-set-bool: service /switch is finally reachable"));
  EXPECT_THAT(said(), ElementsAre("info main: said /switch TRUE by switch", "info main: said /switch TRUE by switch"));
  EXPECT_THAT(lab_.facts("std-srvs-set-bool-service"), ElementsAre("(std-srvs-set-bool-service (name \"switch\"))"));
  EXPECT_EQ(act(R"((std-srvs-set-bool-destroy-service "switch") (std-srvs-set-bool-destroy-client "/switch"))"), "");
  EXPECT_THAT(lab_.facts("std-srvs-set-bool-service"), SizeIs(1)) << "as in CX the fact of a service stays";
  EXPECT_THAT(lab_.facts("std-srvs-set-bool-client"), IsEmpty());
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST_F(Bindings, LeftMessagesAreReportedInTheWordsOfCx) {
  run({"StdMsgsString", "StdSrvsTrigger", "ExampleInterfacesFibonacci"});
  EXPECT_EQ(act(R"((std-msgs-string-create-message)
    (std-srvs-trigger-create-client "c1") (std-srvs-trigger-create-service "s1")
    (std-srvs-trigger-request-create) (std-srvs-trigger-request-create) (std-srvs-trigger-response-create)
    (example-interfaces-fibonacci-create-server "as") (example-interfaces-fibonacci-create-client "ac")
    (example-interfaces-fibonacci-feedback-create) (example-interfaces-fibonacci-goal-create)
    (example-interfaces-fibonacci-result-create))"),
            "");
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  const auto said = [this](const std::string& plugin) {
    std::vector<std::string> out;
    for (const std::string& line : lab_.log.with("warn " + plugin + ": "))
      out.push_back(line.substr(plugin.size() + 7, line.find(", cleaning up ...") - plugin.size() - 7));
    return out;
  };
  EXPECT_THAT(said("std-msgs-string"), ElementsAre("Found 1 message(s)"));
  EXPECT_THAT(said("std-srvs-trigger"),
              ElementsAre("Environment main has open c1 client", "Environment main has open s1 service",
                          "Found 2 request(s)", "Found 1 response(s)"));
  EXPECT_THAT(said("example-interfaces-fibonacci"),
              ElementsAre("Environment main has open as server", "Environment main has open ac client",
                          "Found 1 goal(s)", "Found 1 result(s)", "Found 1 feedback(s)"));
}

TEST_F(Bindings, AServiceWithoutDeffunctionAnswersTheDefault) {
  run({"StdSrvsTrigger"});
  EXPECT_EQ(act("(std-srvs-trigger-create-service go) (std-srvs-trigger-create-client \"go\") "
                "(std-srvs-trigger-send-request (std-srvs-trigger-request-create) go)"),
            "");
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("std-srvs-trigger-response"), SizeIs(1));
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn std-srvs-trigger: std-srvs-trigger-service-callback not defined, skip callback"));
}

TEST_F(Bindings, AnUnknownClassGivesTheNearest) {
  lab_.config("environments: [\"main\"]\nmain: {plugins: [\"s\"]}\ns: {plugin: \"cx::CXStdMsgsStrinPlugin\"}");
  const Status s = lab_.start();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message,
              HasSubstr("unknown plugin type 'cx::CXStdMsgsStrinPlugin', did you mean 'cx::CXStdMsgsStringPlugin'?"
                        " (a package of your own is named by packages: {NAME: DIR} in the scenario or "
                        "story, or by --package NAME=DIR of cxlab env, check, test and mutate)"));
  EXPECT_GT(s.error().line, 0);
}

TEST_F(Bindings, APackageOfAUsersOwnNeedsOnlyItsDefinitions) {
  const auto file = lab_.write("my_robot_msgs/msg/GripperState.msg",
                               "bool closed\nfloat32[] forces\nfloat64[2] limits\nbool[] pads\n");
  ASSERT_TRUE(lab_.registry.add_package("my_robot_msgs", file.parent_path().parent_path()).ok());
  run({"MyRobotMsgsGripperState"});
  EXPECT_EQ(
      act(R"((bind ?m (my-robot-msgs-gripper-state-create-message)) (my-robot-msgs-gripper-state-set-field ?m forces (create$ 0.5 1))
    (my-robot-msgs-gripper-state-set-field ?m limits (create$ 0 1)) (my-robot-msgs-gripper-state-set-field ?m pads (create$ TRUE FALSE))
    (println "said " (my-robot-msgs-gripper-state-get-field ?m forces) (my-robot-msgs-gripper-state-get-field ?m limits)
      (my-robot-msgs-gripper-state-get-field ?m pads)))"),
      "");
  EXPECT_THAT(said(), ElementsAre("info main: said (0.5 1.0)(0.0 1.0)(TRUE FALSE)"))
      << "CX cannot build or set any of these three";
}

TEST_F(Bindings, MessagesThatAreLeftAreToldByTheirPlugin) {
  run({"StdMsgsString", "StdMsgsInt32"});
  EXPECT_EQ(act("(std-msgs-string-create-message) (std-msgs-string-create-message) (std-msgs-int32-create-message)"),
            "");
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn std-msgs-int32: Found 1 message(s), cleaning up ...",
                                                  "warn std-msgs-string: Found 2 message(s), cleaning up ..."));
}

TEST_F(Bindings, AMessageOfAnotherTypeIsNotDestroyed) {
  run({"StdMsgsString", "StdSrvsSetBool"});
  EXPECT_EQ(
      act(R"((bind ?m (std-msgs-string-create-message)) (std-msgs-string-set-field ?m data kept) (std-srvs-set-bool-request-destroy ?m)
    (println "said " (std-msgs-string-get-field ?m data))
    (bind ?r (std-srvs-set-bool-response-create)) (std-srvs-set-bool-request-destroy ?r) (std-msgs-string-destroy-message ?m))"),
      "");
  EXPECT_THAT(said(), ElementsAre("info main: said kept"));
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn std-srvs-set-bool: Found 1 response(s), cleaning up ..."))
      << "as in CX the response is left";
}

TEST_F(Bindings, AServiceThatItsCallbackClosesAnswersOnce) {
  lab_.options.stop_on_rule_error = false;
  run({"StdSrvsTrigger"}, R"((deffunction std-srvs-trigger-service-callback (?service ?request ?response)
  (std-srvs-trigger-destroy-service ?service) (std-srvs-trigger-response-set-field ?response message "for the last time"))
(defrule answered ?f <- (std-srvs-trigger-response (msg-ptr ?m)) =>
  (println "said " (std-srvs-trigger-response-get-field ?m message)) (std-srvs-trigger-response-destroy ?m) (retract ?f)))");
  EXPECT_EQ(
      act(R"((std-srvs-trigger-create-service "once") (std-srvs-trigger-create-client "once") (bind ?r (std-srvs-trigger-request-create))
    (std-srvs-trigger-send-request ?r "once") (std-srvs-trigger-send-request ?r "once") (std-srvs-trigger-request-destroy ?r))"),
      "");
  EXPECT_THAT(said(), ElementsAre("info main: said for the last time"));
  EXPECT_EQ(act("(std-srvs-trigger-create-service \"once\")"), "");
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty()) << "the first one has gone";
}

TEST_F(Bindings, UnloadingAServiceWhileRulesUseItLeavesThemAnError) {
  lab_.options.stop_on_rule_error = false;
  lab_.config(R"(environments: ["server", "client"]
server: {plugins: ["executive", "switch", "server_files"]}
client: {plugins: ["executive", "switch", "client_files"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
switch: {plugin: "cx::CXStdSrvsSetBoolPlugin"}
server_files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["server.clp"]}
client_files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["client.clp"]})");
  lab_.write("agent/server.clp", R"((deffacts start (open))
(defrule open ?f <- (open) => (retract ?f) (std-srvs-set-bool-create-service "power"))
(deffunction std-srvs-set-bool-service-callback (?service ?request ?response)
  (std-srvs-set-bool-response-set-field ?response message (str-cat "by " ?service))))");
  lab_.write("agent/client.clp", R"((deffacts start (open))
(defrule open ?f <- (open) => (retract ?f) (std-srvs-set-bool-create-client "power"))
(defrule ask ?f <- (ask) => (retract ?f)
  (bind ?r (std-srvs-set-bool-request-create)) (std-srvs-set-bool-send-request ?r "power") (std-srvs-set-bool-request-destroy ?r))
(defrule answered ?f <- (std-srvs-set-bool-response (service ?s) (msg-ptr ?m)) => (retract ?f)
  (println "said " ?s " " (std-srvs-set-bool-response-get-field ?m message)) (std-srvs-set-bool-response-destroy ?m)))");
  lab_.run_up();
  const auto put = [&](const char* environment, const char* fact) {
    ASSERT_TRUE(lab_.engine(environment).assert_string(fact).ok());
    lab_.ticks(4);
  };
  put("client", "(ask)");
  EXPECT_THAT(said(), ElementsAre("info client: said power by power"));

  // The server leaves while a request is open: nobody answers, and later requests wait for a server.
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.engine("client").assert_string("(ask)").ok());
  lab_.ticks(1);
  ASSERT_TRUE(lab_.manager->unload_plugin("server", "switch").ok());
  EXPECT_THAT(lab_.log.with("warn switch: "), ElementsAre(HasSubstr("-service cant be undefined")));
  const std::vector<Value> args{Value::string("power"), Value::handle(Handle{1}), Value::handle(Handle{2})};
  EXPECT_FALSE(lab_.engine("server").call("std-srvs-set-bool-service-callback", args).ok());
  EXPECT_THAT(lab_.engine("server").take_errors().at(0).text(), HasSubstr("belongs to unloaded plugin switch"));
  put("client", "(ask)");
  EXPECT_THAT(said(), IsEmpty());
  lab_.ticks(60);
  EXPECT_THAT(lab_.log.with("warn switch: service power not available, start waiting"), SizeIs(1));

  // It comes back, and the old rules serve again.
  ASSERT_TRUE(lab_.manager->load_plugin("server", "switch").ok());
  put("server", "(open)");
  lab_.ticks(4);
  EXPECT_THAT(said(), testing::Not(IsEmpty()));

  // The client leaves while a request is open: the answer reaches nobody, and its rules are told.
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.engine("client").assert_string("(ask)").ok());
  lab_.ticks(1);
  ASSERT_TRUE(lab_.manager->unload_plugin("client", "switch").ok());
  EXPECT_THAT(lab_.log.with("warn switch: "),
              ElementsAre(HasSubstr("-client cant be undefined"), HasSubstr("-response cant be undefined")))
      << "a fact and a rule use these";
  put("client", "(ask)");
  EXPECT_THAT(lab_.log.with("rule ask"),
              ElementsAre(HasSubstr("'std-srvs-set-bool-request-create': belongs to unloaded plugin switch")));
  EXPECT_THAT(said(), IsEmpty());
  ASSERT_TRUE(lab_.manager->load_plugin("client", "switch").ok());
  put("client", "(open)");
  put("client", "(ask)");
  EXPECT_THAT(said(), ElementsAre("info client: said power by power"));

  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("has open power service, cleaning up ..."), testing::Not(IsEmpty()))
      << "told when no environment has the plugin any more";
  EXPECT_THAT(lab_.log.with("has open power client, cleaning up ..."), testing::Not(IsEmpty()));
}

TEST_F(Bindings, UnloadingWhileRulesUseItLeavesThemAnError) {
  run({"StdMsgsString"}, R"((defrule hear ?f <- (std-msgs-string-message (msg-ptr ?m)) => (retract ?f)
  (println "said " (std-msgs-string-get-field ?m data)) (std-msgs-string-destroy-message ?m))
(defrule make ?f <- (make) => (retract ?f) (std-msgs-string-create-message)))");
  EXPECT_EQ(act("(std-msgs-string-create-subscription \"a\") (std-msgs-string-create-message)"), "");
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "std-msgs-string").ok());
  EXPECT_THAT(lab_.log.with("warn std-msgs-string: "),
              ElementsAre(HasSubstr("-subscription cant be undefined"), HasSubstr("-message cant be undefined"),
                          HasSubstr("has open a subscription"), HasSubstr("Found 1 message(s)")));
  ASSERT_TRUE(lab_.engine().assert_string("(make)").ok());
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("belongs to unloaded plugin std-msgs-string"));
  ASSERT_TRUE(lab_.manager->load_plugin("main", "std-msgs-string").ok());
  ASSERT_TRUE(lab_.engine().assert_string("(make)").ok());
  lab_.ticks(6);
}

TEST_F(Bindings, EveryClassLoads) {
  std::vector<std::string> classes;
  std::size_t functions = 0;
  for (const std::string& package : lab_.registry.packages())
    for (const std::string& interface : lab_.registry.interfaces(package)) {
      const std::string name = binding_class_name(interface);
      classes.push_back(name.substr(6, name.size() - 12));
      functions += interface.find("/msg/") != std::string::npos   ? 9u
                   : interface.find("/srv/") != std::string::npos ? 13u
                                                                  : 37u;
    }
  run(classes);
  std::size_t found = 0;
  for (const FunctionSpec& f : lab_.engine().functions()) found += f.name.starts_with(f.owner + '-');
  EXPECT_EQ(found, functions);
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

}  // namespace
}  // namespace cxlab::cx
