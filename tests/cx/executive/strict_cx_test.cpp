#include "cx/executive/strict_cx.h"

#include "tests/support/engine_test.h"

namespace cxlab::cx {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class StrictCxTest : public EngineTest {
 protected:
  std::vector<std::string> found(std::string_view rules, RosRelease release = RosRelease::kKilted) {
    for (const char* name : {"now", "ros-msgs-create-action-client", "ros-msgs-create-goal-request",
                             "ros-msgs-async-send-goal", "ros-msgs-async-cancel-goal", "ros-msgs-create-client",
                             "ros-msgs-create-request", "ros-msgs-async-send-request", "ros-msgs-create-service",
                             "ros-msgs-create-subscription", "ros-msgs-create-message", "ros-msgs-set-field",
                             "ros-msgs-destroy-service", "ros-msgs-publish", "std-srvs-trigger-create-service"})
      EXPECT_TRUE(engine().add_function({.name = name, .returns = "*", .max_args = 5}, [](Call&) {}));
    given("(deftemplate ros-msgs-message (slot topic (type STRING)) (slot msg-ptr))\n");
    given(rules);
    std::vector<std::string> texts;
    for (const Error& error : differences_in_rules(engine(), release)) texts.push_back(error.text());
    return texts;
  }
};

TEST_F(StrictCxTest, RulesThatDoTheSameThereAreSilent) {
  EXPECT_THAT(found(R"((deffacts start (go 0))
(defglobal ?*begun* = 0.0)
(deffunction move-service-callback (?service ?request ?response) TRUE)
(defrule subscribe (go ?) => (ros-msgs-create-subscription "/pose" "geometry_msgs/msg/Pose") (bind ?*begun* (now)))
(defrule wait (time ?t&:(> ?t (+ ?*begun* 5))) (ros-msgs-message (topic "/pose") (msg-ptr ?p)) => (printout t ?p))
(defrule count (go ?n&:(> ?n 5)) => (assert (go 0))))"),
              IsEmpty());
}

TEST_F(StrictCxTest, GenericClientsAreNotInAllReleases) {
  const char* action = "(defrule a\n  (go)\n  =>\n  (ros-msgs-create-action-client s t))\n";
  const char* all = R"((defrule b (go) =>
  (ros-msgs-create-goal-request t) (ros-msgs-async-send-goal 1 s) (ros-msgs-async-cancel-goal 1 s))
(deffunction c () (ros-msgs-create-client s t) (ros-msgs-create-request t)
  (ros-msgs-async-send-request 1 s) (ros-msgs-create-service s t)))";
  EXPECT_THAT(found(action, RosRelease::kJazzy),
              ElementsAre("rules.clp:4: strict-cx: release: ROS 2 jazzy has no generic action client, so CX has no "
                          "'ros-msgs-create-action-client' there; use the generated bindings of the type"));
  given(all);
  const auto count = [&](RosRelease release) { return differences_in_rules(engine(), release).size(); };
  EXPECT_EQ(count(RosRelease::kHumble), 8u);
  EXPECT_EQ(count(RosRelease::kJazzy), 4u);
  EXPECT_EQ(count(RosRelease::kKilted), 0u);
  EXPECT_EQ(differences_in_rules(engine(), RosRelease::kHumble).back().line, 4);
}

TEST_F(StrictCxTest, ConstantTimesNeedSimulatedTime) {
  const auto texts = found(R"((defrule exact (time 12.5) =>)
(defrule late
  (time ?t&:(> ?t 30)) =>)
(defrule early (time ?t) (test (< 3 ?t)) =>)
(defrule asked (go) => (if (>= (now) 10.0) then (bind ?x 1)))
(deffunction noted () (bind ?at (now)) (= ?at 7))
(defrule right (time ?t) (deadline ?d&:(> ?t ?d)) (other ?n&:(> ?n 30)) =>)
)");
  ASSERT_EQ(texts.size(), 5u);
  EXPECT_THAT(texts[0], AllOf(HasSubstr("rules.clp:1: strict-cx: time: (time 12.5) needs simulated time")));
  EXPECT_THAT(texts[1], HasSubstr("rules.clp:3: strict-cx: time: (> ?t 30)"));
  EXPECT_THAT(texts[2], HasSubstr("rules.clp:4: strict-cx: time: (< 3 ?t)"));
  EXPECT_THAT(texts[3], HasSubstr("rules.clp:5: strict-cx: time: (>= (now) 10.0)"));
  EXPECT_THAT(texts[4], HasSubstr("rules.clp:6: strict-cx: time: (= ?at 7)"));
}

TEST_F(StrictCxTest, CallbacksTakeWhatTheyAreCalledWith) {
  const auto texts = found(R"((deffunction one-service-callback (?service ?request) TRUE)
(deffunction two-service-callback (?service $?rest) TRUE)
(deffunction three-handle-goal-callback (?a ?b ?c ?d) 2)
(deffunction four-cancel-goal-callback () 2)
(deffunction five-cancel-goal-callback (?server ?goal ?handle) 2)
(deffunction six-service-callback (?a ?b ?c ?d $?rest) TRUE)
(deffunction callback (?one) TRUE)
)");
  ASSERT_EQ(texts.size(), 4u);
  EXPECT_EQ(texts[0],
            "rules.clp:1: strict-cx: callback: 'one-service-callback' takes (?service ?request), but is called with "
            "(?service ?request ?response)");
  EXPECT_THAT(texts[1], HasSubstr("rules.clp:3: strict-cx: callback: 'three-handle-goal-callback'"));
  EXPECT_THAT(texts[2], HasSubstr("'four-cancel-goal-callback'"));
  EXPECT_THAT(texts[3], HasSubstr("'six-service-callback'"));
}

TEST_F(StrictCxTest, NamesHaveOneSpelling) {
  const auto texts =
      found(R"((defrule subscribe (go) => (ros-msgs-create-subscription "/pose" "geometry_msgs/msg/Pose"))
(defrule hear (ros-msgs-message (topic "pose") (msg-ptr ?p)) => (printout t "pose" ?p))
(defrule say (go ?m) => (ros-msgs-publish ?m "/said") (ros-msgs-publish ?m said))
(defrule ask (go) => (ros-msgs-async-send-request 1 "/asked") (ros-msgs-create-client "asked" "t"))
(deffunction served-service-callback (?service ?request ?response) TRUE)
(defrule serve (go) => (ros-msgs-create-service /served "t"))
)");
  const auto other = [](int line, const char* here, const char* elsewhere) {
    return "rules.clp:" + std::to_string(line) + ": strict-cx: spelling: \"" + here + "\" here and \"" + elsewhere +
           "\" elsewhere: CX compares names as they are written";
  };
  EXPECT_THAT(texts, testing::UnorderedElementsAre(other(2, "pose", "/pose"), other(3, "said", "/said"),
                                                   other(4, "asked", "/asked"), other(6, "/served", "served")));
}

TEST_F(StrictCxTest, OnlyNamesAreComparedAndEachWithItsKind) {
  EXPECT_THAT(found(R"((defrule a (go ?m ?t) => (ros-msgs-create-subscription "/data" "std_msgs/msg/String")
  (ros-msgs-set-field ?m "data" "data") (ros-msgs-publish ?m ?t) (ros-msgs-publish "pose" "/pose"))
(defrule b (go) => (ros-msgs-create-service "data" "t") (ros-msgs-create-service "/std-srvs-trigger" "t"))
(deffunction std-srvs-trigger-service-callback (?service ?request ?response) TRUE)
(deffunction data-service-callback (?service ?request ?response) TRUE)
)"),
              IsEmpty());
}

TEST_F(StrictCxTest, FunctionsThatCxDoesNotHave) {
  for (const auto& [name, owner] : {std::pair{"shout", "megaphone"},
                                    {"whisper", "files"},
                                    {"pb-peer-create-crypto", "pb"},
                                    {"pb-peer-create-local-crypto", "pb"},
                                    {"std-srvs-fill-client-cancel-goals-before", "bindings"},
                                    {"std-srvs-fill-client-cancel-goal", "bindings"}})
    EXPECT_TRUE(engine().add_function({.name = name, .returns = "*", .max_args = 5, .owner = owner}, [](Call&) {}));
  given(R"((defrule loud (go) => (shout) (whisper) (shout 1)
  (if TRUE then (shout 2)))
(deffunction peers () (pb-peer-create-crypto a 1 b c) (pb-peer-create-local-crypto a 1 2 b c)
  (std-srvs-fill-client-cancel-goals-before s 1.0) (std-srvs-fill-client-cancel-goal s 1))
(defrule quiet (shout-heard) => (whisper))
)");
  std::vector<std::string> texts;
  for (const Error& error : differences_in_rules(engine(), RosRelease::kKilted, {{"megaphone", "my::Megaphone"}}))
    texts.push_back(error.text());
  EXPECT_THAT(
      texts, ElementsAre("rules.clp:1: strict-cx: function: 'shout' is of plugin 'megaphone' (my::Megaphone), which CX "
                         "does not have",
                         "rules.clp:3: strict-cx: function: 'pb-peer-create-crypto' fails at each call in CX",
                         "rules.clp:4: strict-cx: function: 'std-srvs-fill-client-cancel-goals-before' fails at each "
                         "call in CX"));
}

TEST_F(StrictCxTest, FactsBeforeTheResetAreLost) {
  given("(deffacts kept (stays))\n");
  EXPECT_THAT(facts_lost_by_reset(engine()), IsEmpty());
  (void)engine().assert_string("(lost 1)");
  (void)engine().assert_string("(lost 2)");
  (void)engine().assert_string("(gone)");
  const auto lost = facts_lost_by_reset(engine());
  ASSERT_EQ(lost.size(), 2u);
  EXPECT_THAT(lost[0].text(), HasSubstr("strict-cx: reset: the fact (lost 1) was asserted before the reset"));
}

}  // namespace
}  // namespace cxlab::cx
