#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Environments "server" and "client" with the bindings of Fibonacci, under the short names fib-...
class ActionBindings : public ::testing::Test {
 protected:
  void run(const std::string& server_rules, bool stop_on_rule_error = true) {
    lab_.config(R"(environments: ["server", "client"]
server: {plugins: ["executive", "fib", "server_files"]}
client: {plugins: ["executive", "fib", "client_files"]}
executive: {plugin: "cx::ExecutivePlugin"}
fib: {plugin: "cx::CXExampleInterfacesFibonacciPlugin"}
server_files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["server.clp"]}
client_files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["client.clp"]})");
    lab_.write(
        "agent/server.clp",
        "(deffacts start (open)) (defrule open (open) => (example-interfaces-fibonacci-create-server \"/fib\"))\n" +
            server_rules);
    lab_.write("agent/client.clp",
               R"((deffacts start (open)) (defrule open (open) => (example-interfaces-fibonacci-create-client "fib"))
(defrule send ?f <- (send ?n) => (retract ?f)
  (bind ?g (example-interfaces-fibonacci-goal-create))
  (example-interfaces-fibonacci-goal-set-field ?g order ?n)
  (example-interfaces-fibonacci-send-goal ?g fib)
  (example-interfaces-fibonacci-goal-destroy ?g))
(defrule answered (example-interfaces-fibonacci-goal-response (server ?s) (client-goal-handle-ptr ?h)) =>
  (assert (goal ?h))
  (println "said " ?s " status " (example-interfaces-fibonacci-client-goal-handle-get-status ?h)))
(defrule feedback ?f <- (example-interfaces-fibonacci-goal-feedback (client-goal-handle-ptr ?h) (feedback-ptr ?m)) => (retract ?f)
  (println "said feedback " (example-interfaces-fibonacci-feedback-get-field ?m sequence))
  (example-interfaces-fibonacci-feedback-destroy ?m))
(defrule ended ?f <- (example-interfaces-fibonacci-wrapped-result (goal-id ?id) (code ?code) (result-ptr ?m)) ?g <- (goal ?h) => (retract ?f ?g)
  (println "said ended " ?code " " (example-interfaces-fibonacci-result-get-field ?m sequence) " "
    (example-interfaces-fibonacci-client-goal-handle-get-status ?h) " " (stringp ?id) (eq ?id (example-interfaces-fibonacci-client-goal-handle-get-goal-id ?h))
    " " (example-interfaces-fibonacci-client-goal-handle-is-feedback-aware ?h) (example-interfaces-fibonacci-client-goal-handle-is-result-aware ?h))
  (example-interfaces-fibonacci-result-destroy ?m) (example-interfaces-fibonacci-client-goal-handle-destroy ?h))
(defrule cancel ?f <- (cancel) (goal ?h) => (retract ?f) (example-interfaces-fibonacci-client-cancel-goal fib ?h))
)");
    lab_.options.stop_on_rule_error = stop_on_rule_error;
    lab_.run_up();
  }
  void put(const std::string& environment, const std::string& fact) {
    ASSERT_TRUE(lab_.engine(environment).assert_string(fact).ok());
  }
  void send(const std::string& fact = "(send 3)") {
    put("client", fact);
    lab_.ticks(15);
  }
  /// As at the prompt of an environment; what it gives, or its error.
  std::string eval(const std::string& environment, const std::string& expression) {
    const auto value = lab_.engine(environment).eval(expression);
    errors_ = lab_.engine(environment).take_errors();
    return value ? value->print() : value.error().message;
  }
  std::vector<std::string> said() const { return lab_.log.with("said "); }

  Lab lab_;
  std::vector<RuleError> errors_;  // of the last eval
};

/// Rules of a server that accept, tell, and succeed once `(finish)` is there.
constexpr const char* kServer = R"(
(deffunction example-interfaces-fibonacci-handle-goal-callback (?server ?goal ?uuid)
  (println "said asked " ?server " " (example-interfaces-fibonacci-goal-get-field ?goal order) " " (str-length ?uuid)) 2)
(defrule begin (example-interfaces-fibonacci-accepted-goal (server ?s) (server-goal-handle-ptr ?h)) =>
  (assert (handle ?h))
  (bind ?f (example-interfaces-fibonacci-feedback-create))
  (example-interfaces-fibonacci-feedback-set-field ?f sequence (create$ 0 1))
  (example-interfaces-fibonacci-server-goal-handle-publish-feedback ?h ?f)
  (example-interfaces-fibonacci-feedback-destroy ?f)
  (println "said begun " (example-interfaces-fibonacci-goal-get-field (example-interfaces-fibonacci-server-goal-handle-get-goal ?h) order)
    " " (example-interfaces-fibonacci-server-goal-handle-is-executing ?h) (example-interfaces-fibonacci-server-goal-handle-is-active ?h)
    (example-interfaces-fibonacci-server-goal-handle-is-canceling ?h) " " (str-length (example-interfaces-fibonacci-server-goal-handle-get-goal-id ?h))))
(defrule finish ?f <- (finish ?how) (handle ?h) => (retract ?f)
  (bind ?r (example-interfaces-fibonacci-result-create))
  (example-interfaces-fibonacci-result-set-field ?r sequence (create$ 0 1 1))
  (switch ?how
    (case succeed then (example-interfaces-fibonacci-server-goal-handle-succeed ?h ?r))
    (case abort then (example-interfaces-fibonacci-server-goal-handle-abort ?h ?r))
    (case canceled then (example-interfaces-fibonacci-server-goal-handle-canceled ?h ?r)))
  (example-interfaces-fibonacci-result-destroy ?r))
)";

TEST_F(ActionBindings, AGoalGoesThroughToItsResult) {
  run(kServer);
  send();
  EXPECT_THAT(said(), ElementsAre("info server: said asked /fib 3 32", "info server: said begun 3 TRUETRUEFALSE 32",
                                  "info client: said fib status 2", "info client: said feedback (0 1)"));
  lab_.log.lines.clear();
  put("server", "(finish succeed)");
  lab_.ticks(10);
  EXPECT_THAT(said(), ElementsAre("info client: said ended SUCCEEDED (0 1 1) 4 TRUETRUE TRUETRUE"));

  for (const char* e : {"server", "client"}) {
    put(e, "(close)");
    ASSERT_TRUE(
        lab_.engine(e)
            .build(
                e == std::string("server")
                    ? "(defrule close (close) (handle ?h) => (example-interfaces-fibonacci-server-goal-handle-destroy "
                      "?h) (example-interfaces-fibonacci-destroy-server /fib))"
                    : "(defrule close (close) => (example-interfaces-fibonacci-destroy-client \"fib\"))")
            .ok());
  }
  lab_.ticks(5);
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-server", "server"), IsEmpty());
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-client", "client"), IsEmpty());
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST_F(ActionBindings, WithoutACallbackAGoalIsAcceptedAndRuns) {
  run("");
  send();
  EXPECT_THAT(said(), ElementsAre("info client: said fib status 2"));
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-accepted-goal", "server"), SizeIs(1));
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST_F(ActionBindings, ARejectedGoalGivesANullHandle) {
  run("(deffunction example-interfaces-fibonacci-handle-goal-callback (?s ?g ?u) 1)", false);
  send();
  EXPECT_EQ(
      *lab_.engine("client").facts("example-interfaces-fibonacci-goal-response").at(0).slot("client-goal-handle-ptr"),
      Value::handle(Handle::kNone));
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-accepted-goal", "server"), IsEmpty());
  EXPECT_THAT(lab_.log.with("error "),
              ElementsAre("error fib: Unknown client goal handle: map::at",
                          HasSubstr("client.clp:9: rule answered, RHS: [CXLAB1] Function "
                                    "'example-interfaces-fibonacci-client-goal-handle-get-status': the client goal "
                                    "handle is a null pointer, as of a goal that was rejected")));
  EXPECT_THAT(said(), ElementsAre("info client: said fib status 0")) << "the rule goes on, as in CX";
}

TEST_F(ActionBindings, TheRuleOfThePageKnowsARejectedGoal) {
  std::string rules = lab_.page_code("docs/reference/plugins/bindings.md", "is-null");
  rules.replace(rules.find("P-"), 2, "example-interfaces-fibonacci-");
  run("(deffunction example-interfaces-fibonacci-handle-goal-callback (?s ?g ?u) (if (= "
      "(example-interfaces-fibonacci-goal-get-field ?g order) 3) then 1 else 2))",
      false);
  ASSERT_TRUE(lab_.engine("client").load_text(rules, "page.clp", LoadMode::kConstructs).ok()) << rules;
  send("(send 4)");
  EXPECT_THAT(lab_.log.with("no: "), IsEmpty()) << "this one was accepted";
  send("(send 3)");
  EXPECT_THAT(lab_.log.with("no: "), ElementsAre("info client: no: fib"));
}

TEST_F(ActionBindings, AnotherAnswerIsAnErrorAndRejects) {
  run("(deffunction example-interfaces-fibonacci-handle-goal-callback (?s ?g ?u) TRUE)", false);
  send();
  EXPECT_THAT(lab_.log.with("error fib: example"),
              ElementsAre("error fib: example-interfaces-fibonacci-handle-goal-callback returned TRUE, expected an "
                          "INTEGER from 1 to 3: rejected"));
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-accepted-goal", "server"), IsEmpty());
}

TEST_F(ActionBindings, ADeferredGoalWaitsForItsExecution) {
  run("(deffunction example-interfaces-fibonacci-handle-goal-callback (?s ?g ?u) 3)");
  send();
  EXPECT_THAT(said(), ElementsAre("info client: said fib status 1"));
  ASSERT_TRUE(lab_.engine("server")
                  .build(R"((defrule go (go) (example-interfaces-fibonacci-accepted-goal (server-goal-handle-ptr ?h)) =>
    (println "said active " (example-interfaces-fibonacci-server-goal-handle-is-active ?h))
    (println "said executing " (example-interfaces-fibonacci-server-goal-handle-is-executing ?h))
    (example-interfaces-fibonacci-server-goal-handle-execute ?h)
    (println "said executing " (example-interfaces-fibonacci-server-goal-handle-is-executing ?h))
    (example-interfaces-fibonacci-server-goal-handle-execute ?h)))")
                  .ok());
  put("server", "(go)");
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("the goal is EXECUTING, expected ACCEPTED"));
  EXPECT_THAT(lab_.log.with("said executing"),
              ElementsAre("info server: said executing FALSE", "info server: said executing TRUE"));
  EXPECT_THAT(lab_.log.with("said active"), ElementsAre("info server: said active TRUE"));
}

TEST_F(ActionBindings, AMessageOfAnotherTypeEndsNoGoal) {
  run(kServer, false);
  send();
  const std::string prefix = "example-interfaces-fibonacci-", type = "example_interfaces/action/Fibonacci_";
  for (const auto& [function, wrong, expected] :
       {std::tuple{"succeed", "feedback", "Result"}, std::tuple{"abort", "goal", "Result"},
        std::tuple{"canceled", "feedback", "Result"}, std::tuple{"publish-feedback", "result", "Feedback"}}) {
    const std::string name = type + static_cast<char>(std::toupper(wrong[0])) + std::string(wrong + 1);
    for (const auto& [message, found] : {std::pair{"(" + prefix + wrong + "-create)",
                                                   "found a message of type " + name + ", expected " + type + expected},
                                         std::pair{std::string("?h"), std::string("invalid message pointer")}}) {
      ASSERT_TRUE(lab_.engine("server")
                      .build("(defrule wrong (handle ?h) => (" + prefix + "server-goal-handle-" + function + " ?h " +
                             message + "))")
                      .ok());
      lab_.log.lines.clear();
      lab_.ticks(10);
      EXPECT_THAT(lab_.log.with("rule wrong, RHS: "), ElementsAre(HasSubstr(found))) << function;
    }
  }
  put("server", "(finish succeed)");
  lab_.ticks(10);
  EXPECT_THAT(lab_.log.with("said ended SUCCEEDED"), SizeIs(1)) << "it was under way";
}

TEST_F(ActionBindings, ACancelIsAskedOfTheRulesWithThreeArguments) {
  run(std::string(kServer) + R"((deffunction example-interfaces-fibonacci-cancel-goal-callback (?server ?goal ?handle)
  (println "said cancel " ?server " " (example-interfaces-fibonacci-goal-get-field ?goal order) " " (example-interfaces-fibonacci-server-goal-handle-is-executing ?handle)) 2))");
  send();
  lab_.log.lines.clear();
  send("(cancel)");
  EXPECT_THAT(said(), ElementsAre("info server: said cancel /fib 3 TRUE"));
  const std::string id = eval("client",
                              "(do-for-fact ((?g goal)) TRUE "
                              "(example-interfaces-fibonacci-client-goal-handle-get-goal-id (nth$ 1 ?g:implied)))");
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-response", "client"),
              ElementsAre("(example-interfaces-fibonacci-cancel-goal-response (server \"fib\") (return-code "
                          "ERROR_NONE) (num-goals 1))"));
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-entry", "client"),
              ElementsAre(HasSubstr("(example-interfaces-fibonacci-cancel-goal-entry (server \"fib\") (goal-id " + id +
                                    ") (stamp 0.")));
  lab_.log.lines.clear();
  put("server", "(finish canceled)");
  lab_.ticks(10);
  EXPECT_THAT(said(), ElementsAre("info client: said ended CANCELED (0 1 1) 5 TRUETRUE TRUETRUE"));
}

TEST_F(ActionBindings, ACancelMayBeRejected) {
  run(std::string(kServer) + "(deffunction example-interfaces-fibonacci-cancel-goal-callback (?s ?g ?h) 1)");
  send();
  send("(cancel)");
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-response", "client"),
              ElementsAre("(example-interfaces-fibonacci-cancel-goal-response (server \"fib\") (return-code "
                          "ERROR_REJECTED) (num-goals 0))"));
  put("server", "(finish canceled)");
  Status s;
  for (int i = 0; i < 6 && s.ok(); ++i) s = lab_.tick();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("the goal is EXECUTING, expected CANCELING"));
}

TEST_F(ActionBindings, AllGoalsOrThoseBeforeAMomentAreCancelled) {
  run("");
  send("(send 1)");
  send("(send 2)");
  EXPECT_EQ(eval("client", "(example-interfaces-fibonacci-client-cancel-goals-before fib 0.1)"), "");
  lab_.ticks(5);
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-entry", "client"), SizeIs(1))
      << "the second was accepted later";
  EXPECT_EQ(eval("client", "(example-interfaces-fibonacci-client-cancel-all-goals fib)"), "");
  lab_.ticks(5);
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-entry", "client"), SizeIs(2))
      << "the first is being cancelled already";
}

TEST_F(ActionBindings, AnAbortedGoalAndOneWhoseHandleIsDestroyedEnd) {
  run(kServer);
  send();
  put("server", "(finish abort)");
  lab_.ticks(10);
  EXPECT_THAT(lab_.log.with("ended"), ElementsAre("info client: said ended ABORTED (0 1 1) 6 TRUETRUE TRUETRUE"));
  send("(send 4)");
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
  ASSERT_TRUE(lab_.engine("server")
                  .eval("(do-for-all-facts ((?g handle)) TRUE (example-interfaces-fibonacci-server-goal-handle-destroy "
                        "(nth$ 1 ?g:implied)))")
                  .ok());
  lab_.ticks(5);
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre(HasSubstr("of server /fib is aborted: its handle was destroyed before its end")));
  EXPECT_THAT(lab_.log.with("ended ABORTED () 6"), SizeIs(1)) << "the client does not wait for ever";
}

TEST_F(ActionBindings, AServerThatItsCallbackDestroysAnswersAndEndsItsGoals) {
  run(R"((deffunction example-interfaces-fibonacci-handle-goal-callback (?server ?goal ?uuid)
  (bind ?order (example-interfaces-fibonacci-goal-get-field ?goal order))
  (if (> ?order 1) then (example-interfaces-fibonacci-destroy-server ?server))
  (if (= ?order 3) then 1 else 2)))",
      false);
  send("(send 1)");
  EXPECT_THAT(said(), ElementsAre("info client: said fib status 2"));
  lab_.log.lines.clear();
  send("(send 2)");
  EXPECT_THAT(lab_.log.with("is aborted: its server was destroyed before its end"), SizeIs(2))
      << "the goal that ran, and the one that was accepted meanwhile";
  EXPECT_THAT(lab_.log.with("said ended ABORTED () 6"), SizeIs(2)) << "their clients do not wait for ever";
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-accepted-goal", "server"), SizeIs(1))
      << "none for a goal that nobody can end";

  ASSERT_TRUE(lab_.engine("server").eval("(example-interfaces-fibonacci-create-server \"/fib\")").ok());
  send("(send 3)");
  EXPECT_EQ(
      *lab_.engine("client").facts("example-interfaces-fibonacci-goal-response").back().slot("client-goal-handle-ptr"),
      Value::handle(Handle::kNone))
      << "it was rejected";
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-server", "server"), IsEmpty());
}

TEST_F(ActionBindings, AServerThatItsCancelCallbackDestroysAnswersTheCancel) {
  run("(deffunction example-interfaces-fibonacci-cancel-goal-callback (?server ?goal ?handle) "
      "(example-interfaces-fibonacci-destroy-server ?server) 2)");
  send();
  send("(cancel)");
  EXPECT_THAT(lab_.log.with("said ended ABORTED () 6"), SizeIs(1));
  EXPECT_THAT(lab_.facts("example-interfaces-fibonacci-cancel-goal-response", "client"),
              ElementsAre(HasSubstr("ERROR_REJECTED")));
}

TEST_F(ActionBindings, UnknownServerHandlesAreToldAndTheRuleGoesOn) {
  run("");
  for (const auto& [what, gives] : std::vector<std::pair<std::string, std::string>>{{"is-active", "FALSE"},
                                                                                    {"is-executing", "FALSE"},
                                                                                    {"is-canceling", "FALSE"},
                                                                                    {"get-goal-id", "\"\""},
                                                                                    {"execute", ""}}) {
    lab_.log.lines.clear();
    EXPECT_EQ(eval("server", "(example-interfaces-fibonacci-server-goal-handle-" + what +
                                 " (example-interfaces-fibonacci-goal-create))"),
              gives);
    EXPECT_THAT(lab_.log.with("error "), ElementsAre("error fib: Unknown server goal handle: map::at")) << what;
    ASSERT_EQ(errors_.size(), 1U);
    EXPECT_THAT(errors_[0].message, HasSubstr(what + "': the server goal handle was destroyed"));
  }
}

TEST_F(ActionBindings, UnloadingAServerWhileAGoalRunsLeavesItsRulesAnError) {
  run(kServer, false);
  send();
  ASSERT_THAT(lab_.log.with("said begun"), SizeIs(1));
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->unload_plugin("server", "fib").ok());
  EXPECT_THAT(lab_.log.with("warn fib: "),
              ElementsAre(HasSubstr("-server cant be undefined"), HasSubstr("-accepted-goal cant be undefined")))
      << "a fact and a rule use these; what is left is told when the client's environment has lost the plugin, too";
  put("server", "(finish succeed)");
  put("client", "(cancel)");
  lab_.ticks(15);
  EXPECT_THAT(lab_.log.with("belongs to unloaded plugin fib"), testing::Not(IsEmpty()));
  EXPECT_THAT(said(), IsEmpty()) << "no answer, no result: nobody serves";

  ASSERT_TRUE(lab_.manager->load_plugin("server", "fib").ok());
  ASSERT_TRUE(lab_.engine("server").eval("(do-for-all-facts ((?f handle finish)) TRUE (retract ?f))").ok());
  ASSERT_TRUE(lab_.engine("server").eval("(example-interfaces-fibonacci-create-server \"/fib\")").ok());
  send("(send 4)");
  EXPECT_THAT(lab_.log.with("said begun 4"), SizeIs(1)) << "the old rules serve again";
}

TEST_F(ActionBindings, LeftGoalsAreReported) {
  run(kServer);
  send();
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  EXPECT_THAT(lab_.log.with("warn "), ElementsAre("warn fib: Environment server has open /fib server, cleaning up ...",
                                                  "warn fib: Environment client has open fib client, cleaning up ...",
                                                  "warn fib: Found 1 client_goal_handle(s), cleaning up ...",
                                                  "warn fib: Found 1 server_goal_handle(s), cleaning up ..."));
}

}  // namespace
}  // namespace cxlab::cx
