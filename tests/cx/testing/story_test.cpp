// Stories tell what is wrong, where, and what was there instead.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/stories.h"

namespace cxlab::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(Stories, FactIsSeenInItsTimeOnly) {
  EXPECT_THAT(play("fact: (door (state OPEN)), within_s: 1", kBell).failures, IsEmpty());
  EXPECT_THAT(play("fact: (door (state OPEN)), within_s: 0.9", kBell).failures,
              ElementsAre(AllOf(HasSubstr("t.story.yaml:6: expected fact (door (state OPEN)) by 0.9 s"),
                                HasSubstr("(by BELL)) at 1 s, at another time"))));
  EXPECT_THAT(play("fact: (door (state CLOSED)), at: 2", kBell).failures.size(), 1u);
}

TEST_F(Stories, AFactThatLivesWithinOneRunIsSeen) {
  const auto both = "  steps: [{at: 1, assert: (bell)}, {at: 2, assert: (wind)}, {at: 2, retract: (bell)}]\n";
  EXPECT_THAT(play("fact: (door (state OPEN) (by BELL)), within_s: 3", both).failures, IsEmpty());
  EXPECT_THAT(play("no_fact: (door (state OPEN)), within_s: 3", both).failures,
              ElementsAre(HasSubstr("there was (door (state OPEN) (by BELL)) from 1 s")));
  EXPECT_THAT(play("no_fact: (door (state OPEN)), at: 3", both).failures, IsEmpty());
}

TEST_F(Stories, AFactThatIsThereForNoTimeIsSeenAtThatTime) {
  write("door.clp", "(defrule flash (bell) => (assert (light)))\n(defrule dark ?l <- (light) => (retract ?l))\n");
  for (const auto& [when, seen] : {std::pair{"after: 1, within_s: 2", true},
                                   {"after: 0, within_s: 1", true},
                                   {"after: 1.1, within_s: 2", false},
                                   {"after: 0, within_s: 0.9", false}}) {
    auto stories = read(std::string("- story: s\n  rules: door.clp\n  given: []\n") + kBell +
                        "  expect:\n    - {fact: (light), " + when + "}\n    - {no_fact: (light), " + when + "}\n");
    ASSERT_TRUE(stories) << stories.error().text();
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    EXPECT_THAT(result.failures, ElementsAre(HasSubstr(seen ? "there was (light)" : "expected fact (light)"))) << when;
  }
}

TEST_F(Stories, WhatIsLeftOpenIsANoteOrAFailure) {
  write("listen.clp", "(defrule listen (bell) => (ros-msgs-create-subscription \"/x\" \"std_msgs/msg/String\"))\n");
  const auto listen = [&](const std::string& more) {
    const auto stories =
        read("- story: s\n  rules: listen.clp\n" + more + kBell + "  expect: [{fires: listen, within_s: 1}]\n");
    return run_story(stories->front(), {interfaces_dir()});
  };
  const StoryResult noted = listen("");
  EXPECT_THAT(noted.failures, IsEmpty());
  EXPECT_EQ(noted.notes.size(), 1u);
  const StoryResult failed = listen("  leaves_nothing: true\n");
  EXPECT_THAT(failed.failures, ElementsAre(HasSubstr("t.story.yaml:1: left open at the end: ")));
  EXPECT_THAT(failed.notes, IsEmpty());
  EXPECT_THAT(play("fires: open, within_s: 1", kBell + std::string("  leaves_nothing: true\n")).failures, IsEmpty());
}

TEST_F(Stories, AStageHasOneAgentForStoriesThatDifferInWhatHappens) {
  const auto stories = read(
      "common: {rules: door.clp, given: [(door (state CLOSED))]}\n"
      "stories:\n"
      "  - {story: a, steps: [{at: 1, assert: (bell)}], expect: [{fires: open, within_s: 1}]}\n"
      "  - {story: b, expect: [{fires: open, within_s: 1}]}\n"
      "  - {story: c, seed: 2, expect: [{fires: open, within_s: 1}]}\n"
      "  - {story: d, begins_s: 5, expect: [{fires: open, within_s: 6}]}\n");
  ASSERT_TRUE(stories) << stories.error().text();
  EXPECT_TRUE(same_agent((*stories)[0], (*stories)[1]));
  EXPECT_FALSE(same_agent((*stories)[0], (*stories)[2]));
  EXPECT_FALSE(same_agent((*stories)[0], (*stories)[3]));
  const StorySetup setup{interfaces_dir()};
  for (std::size_t i = 0; i < 2; ++i) {
    Stage stage((*stories)[1 - i], setup);  // loaded for the other one
    const StoryResult staged = stage.play((*stories)[i]), alone = run_story((*stories)[i], setup);
    EXPECT_EQ(staged.failures, alone.failures);
    EXPECT_EQ(staged.passed(), i == 0);
    EXPECT_EQ(staged.files, alone.files);
  }
}

TEST_F(Stories, FiringIsCounted) {
  EXPECT_THAT(play("fires: open, within_s: 1", kBell).failures, IsEmpty());
  EXPECT_THAT(play("fires: open, count: 2, within_s: 2", kBell).failures, ElementsAre(HasSubstr("it fired at 1 s")));
  EXPECT_THAT(play("fires: slam, within_s: 2", kBell).failures,
              ElementsAre(HasSubstr("condition 1 does not hold: (wind): there is no fact of wind")));
  EXPECT_THAT(play("not_fires: open, within_s: 2", kBell).failures, ElementsAre(HasSubstr("it fired at 1 s")));
}

TEST_F(Stories, WhatWasPlayedOfAStoryThatEndsEarlyIsCovered) {
  write("door.clp", "(defrule on => (assert (n 0)))\n(defrule loop (n ?n) => (assert (n (+ ?n 1))))\n");
  auto stories = read("- {story: s, rules: door.clp, expect: [{fires: loop, within_s: 1}]}\n");
  ASSERT_TRUE(stories) << stories.error().text();
  const StoryResult result = run_story(stories->front(), {.interfaces = interfaces_dir(), .coverage = true});
  EXPECT_THAT(result.failures, ElementsAre(HasSubstr("rules still fire")));
  ASSERT_EQ(result.coverage.rules.size(), 2u);
  EXPECT_GT(result.coverage.rules[0].fired + result.coverage.rules[1].fired, 1000);
}

TEST_F(Stories, AStoryReplacesWhatIsCommon) {
  const auto failures_of = [&](const std::string& more) {
    const auto stories =
        read("common: {rules: door.clp, given: [(bell), (door (state CLOSED))]}\nstories:\n  - story: s\n" + more +
             "    expect: [{fires: open, within_s: 1}]\n");
    return stories ? run_story(stories->front(), {interfaces_dir()}).failures : std::vector{stories.error().text()};
  };
  EXPECT_THAT(failures_of("    given: [(visitor)]\n"), IsEmpty());
  EXPECT_THAT(failures_of("    replaces: [given]\n    given: [(bell)]\n"), ElementsAre(HasSubstr("it never fired")));
  EXPECT_THAT(failures_of("    replaces: given\n    given: [(bell), (door (state CLOSED))]\n"), IsEmpty());
  EXPECT_THAT(failures_of("    replaces: [gven]\n"),
              ElementsAre(HasSubstr("t.story.yaml:4: stories[0].replaces[0]: found 'gven', expected some of: ")));
}

TEST_F(Stories, AMomentIsAllThatThereIsAndHasFired) {
  write("door.clp",
        "(deftemplate door (slot state))\n(deffacts start (door (state CLOSED)) (bell))\n(defglobal ?*rings* = 0)\n"
        "(defrule open (bell) (door (state ?s)) => (bind ?*rings* (+ ?*rings* 1)) (assert (opened ?s ?*rings*)))\n"
        "(defrule knock (knock) (door (state ?s)) => (assert (knocked ?s (now))))\n");
  const auto failures_of = [&](const std::string& more, const std::string& expect) {
    const auto stories = read("- story: s\n  rules: door.clp\n" + more + "  expect: [" + expect + "]\n");
    if (!stories) return std::vector{stories.error().text()};
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? std::vector{result.bad->text()} : result.failures;
  };
  const std::string moment =
      "  begins_s: 100\n  moment: true\n  calls: [\"(bind ?*rings* 7)\"]\n  given: [(bell), (door (state AJAR))]\n";
  EXPECT_THAT(failures_of(moment,
                          "{no_fact: \"(opened AJAR ?)\", after: 100}, {no_fact: (door (state CLOSED)), at: 100}, "
                          "{not_fires: open, after: 100.02}"),
              IsEmpty());
  EXPECT_THAT(
      failures_of(
          moment + "  steps: [{at: 101, assert: (knock)}, {at: 101, retract: (bell)}, {at: 102, assert: (bell)}]\n",
          "{fact: (knocked AJAR 101), within_s: 101.2}, {fact: (opened AJAR 8), after: 102, within_s: 102.2}"),
      IsEmpty());
  EXPECT_THAT(failures_of("  given: [(door (state AJAR))]\n", "{fact: \"(opened AJAR ?)\", within_s: 1}"), IsEmpty());
}

/// Plays stories of a moment with the rules in door.clp.
class Moments : public Stories {
 protected:
  std::vector<std::string> failures_of(const std::string& more, const std::string& expect) {
    const auto stories =
        read("- story: s\n  rules: door.clp\n  moment: true\n  end: 5\n" + more + "  expect: [" + expect + "]\n");
    if (!stories) return {stories.error().text()};
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? std::vector{result.bad->text()} : result.failures;
  }
};

TEST_F(Moments, AFactGoesWithWhatItFollowsFrom) {
  write(
      "door.clp",
      "(deftemplate door (slot name) (slot state))\n(deffunction twice (?x) (* 2 ?x))\n"
      "(defglobal ?*calls* = 0)\n(deffunction count () (bind ?*calls* (+ ?*calls* 1)) ?*calls*)\n"
      "(defrule pass (logical (door (name ?n) (state OPEN))) (light) => (assert (way ?n)) (assert (ways (twice 1))))\n"
      "(defrule pass-first (logical (or (door (name A) (state OPEN)) (all-open))) => (assert (first) (way A)))\n"
      "(defrule no-way (logical (not (door (state OPEN)))) => (assert (closed)))\n"
      "(defrule counted (logical (bell)) => (assert (counted (count))))\n"
      "(defrule bound (logical (bell)) => (bind ?x 1) (assert (bound ?x)))\n");
  const std::string given =
      "  given: [(door (name A) (state OPEN)), (door (name B) (state OPEN)), (light), (way A), (ways 2), (way C), "
      "(first), (all-open), (bell), (counted 1), (bound 1)]\n";
  EXPECT_THAT(failures_of(given,
                          "{fact: (way A), at: 4}, {fact: (ways 2), at: 4}, {no_fact: (way B)}, {no_fact: "
                          "(closed), at: 4}, {fact: (way C), at: 4}, {not_fires: pass}, {no_fact: (counted 2)}"),
              IsEmpty())
      << "nothing follows anew at the moment";
  const auto without = [&](const std::string& pattern) {
    return given + "  steps: [{at: 1, retract: " + pattern + "}, {at: 2, assert: (done)}]\n";
  };
  EXPECT_THAT(failures_of(without("(door (name A))"),
                          "{fact: (way A), at: 0.9}, {fact: (way A), at: 4}, {fact: (ways "
                          "2), at: 4}, {fact: (first), at: 4}"),
              IsEmpty())
      << "they rest on other facts, too";
  EXPECT_THAT(failures_of(without("(light)"), "{fact: (way A), at: 4}, {fact: (ways 2), at: 4}"), IsEmpty())
      << "(light) is not within `logical`";
  EXPECT_THAT(failures_of(without("(door)"),
                          "{fact: (ways 2), at: 0.9}, {no_fact: (ways 2), at: 1}, {fact: (way A), at: "
                          "4}, {fact: (way C), at: 4}, {fact: (closed), at: 1}"),
              IsEmpty());
  EXPECT_THAT(failures_of(given + "  steps: [{at: 1, retract: (door)}, {at: 2, retract: (all-open)}]\n",
                          "{fact: (way A), at: 1.9}, {fact: (first), at: 1.9}, {no_fact: (way A), at: 2}, {no_fact: "
                          "(first), at: 2}, {fact: (way C), at: 2}"),
              IsEmpty());
  EXPECT_THAT(failures_of(without("(bell)"), "{fact: (counted 1), at: 4}, {fact: (bound 1), at: 4}"), IsEmpty())
      << "a function that acts is not called again, and nothing is bound";
}

TEST_F(Moments, AFactPointsToFactsThatAreGivenBeforeIt) {
  write("door.clp",
        "(deftemplate door (slot state (allowed-values OPEN SHUT)))\n"
        "(defrule knock (knock) ?w <- (wants ?who ?door) => (retract ?w) (modify ?door (state OPEN)) (assert (let-in "
        "?who)))\n");
  const std::string given =
      "  given:\n    - {fact: (door (state SHUT)), as: <Fact-7>}\n    - {fact: (ada), as: <ada>}\n"
      "    - (wants <ada> <Fact-7>)\n    - (plain)\n  steps: [{at: 1, assert: (knock)}, {at: 2, assert: (sees "
      "<Fact-7>)}]\n";
  EXPECT_THAT(failures_of(given,
                          "{no_fact: (door (state OPEN)), within_s: 0.9}, {fact: (door (state OPEN)), at: 1}, "
                          "{fact: '(let-in ?)', at: 1}, {no_fact: (let-in <ada>)}, {no_fact: (sees <Fact-7>)}, "
                          "{fact: '(sees ?)', at: 2}"),
              IsEmpty());
  EXPECT_THAT(failures_of("  given: [{fact: (door (state (sym-cat AJAR))), as: <d>}]\n", "{fact: '(door)', at: 0}"),
              IsEmpty())
      << "CLIPS does not check the value of an expression";
  for (const auto& [facts, what] : std::initializer_list<std::pair<const char*, const char*>>{
           {"(wants ada <d>), {fact: (door), as: <d>}",
            "t.story.yaml:1: [0]: (wants ada <d>) points to <d>, which is given later (line 5): give it before"},
           {"{fact: (wants ada <d>), as: <d>}", "points to <d>, which is given later"},
           {"{fact: (door), as: d}", "found 'd', expected a word in angle brackets, like <Fact-1>"},
           {"{fact: (a), as: <d>}, {fact: (b), as: <d>}", "the fact on line 5 has the name '<d>', too"},
           {"{fact: (a)}", "key 'as' is missing"},
           {"{fact: (a), as: <d>, ass: <e>}", "unknown key 'ass'"},
           {"{fact: (door (stat OPEN)), as: <d>}",
            "t.story.yaml:5: (door (stat OPEN)): template 'door' has no slot 'stat', did you mean 'state'?"},
           {"{fact: (door (state AJAR)), as: <d>}",
            "t.story.yaml:5: (door (state AJAR)): slot 'state' of template 'door' cannot be AJAR; it holds OPEN, SHUT"},
           {"{fact: (door (state (no-such))), as: <d>}", "t.story.yaml:5: (door (state (no-such))): [EXPRNPSR3]"},
           {"{fact: (ada), as: <d>}, (door (stat <d>))", "t.story.yaml:5: (door (stat <d>)): template 'door' has no"}})
    EXPECT_THAT(failures_of("  given: [" + std::string(facts) + "]\n", "{not_fires: knock}"),
                ElementsAre(HasSubstr(what)))
        << facts;
}

TEST_F(Moments, ATickIsAsLongAsTheStorySays) {
  write("door.clp", "(defrule knock (time ?t) (knock) => (assert (knocked ?t)))\n");
  const auto keys = [](const std::string& tick) {
    return "  begins_s: 0.9\n" + tick + "  steps: [{at: 1.01, assert: (knock)}]\n";
  };
  EXPECT_THAT(failures_of(keys(""), "{fact: (knocked 1.1), within_s: 2}, {no_fact: (knocked 1.104)}"), IsEmpty());
  EXPECT_THAT(failures_of(keys("  tick_s: 0.016\n"), "{fact: (knocked 1.104), within_s: 2}"), IsEmpty());
  EXPECT_THAT(failures_of(keys("  tick_s: 0\n"), "{not_fires: knock}"),
              ElementsAre(HasSubstr("tick_s: found 0, expected seconds above 0")));
  const auto stories = read("- story: s\n  rules: door.clp\n  moment: true\n  end: 105\n  begins_s: 99.9\n" +
                            std::string("  given_at_s: 100\n  expect: [{not_fires: knock}]\n"));
  EXPECT_DOUBLE_EQ(run_story(stories->front(), {interfaces_dir()}).sim_time_s, 5) << "from the moment on";
}

TEST_F(Moments, RequestsThatWereSentBeforeAreAnswered) {
  write(
      "door.clp",
      "(deffacts start (start))\n(defrule open (start) => (ros-msgs-create-client \"/may\" \"std_srvs/srv/SetBool\"))\n"
      "(defrule ask ?a <- (ask) => (retract ?a) (bind ?m (ros-msgs-create-request \"std_srvs/srv/SetBool\"))\n"
      "  (assert (asked (ros-msgs-async-send-request ?m \"/may\"))) (ros-msgs-destroy-message ?m))\n"
      "(defrule hear ?r <- (ros-msgs-response (service \"/may\") (request-id ?id) (msg-ptr ?m)) ?a <- (asked ?id) =>\n"
      "  (retract ?r ?a) (assert (said ?id (ros-msgs-get-field ?m \"message\"))))\n");
  const auto served = [](const std::string& keys, const std::string& name = "/may") {
    return "  given: [(asked 40), (asked 38)]\n  serve: [{service: " + name + ", type: std_srvs/srv/SetBool, " + keys +
           "}]\n  steps: [{at: 3, assert: (ask)}]\n";
  };
  const std::string two =
      "result: {message: new}, under_way: [{id: 38, takes_s: 2, result: {message: late}}, {id: 40, takes_s: 1, result: "
      "{message: soon}}]";
  EXPECT_THAT(failures_of(served(two),
                          "{fact: '(said 40 \"soon\")', at: 1}, {no_fact: '(said 38 $?)', within_s: 1.98}, "
                          "{fact: '(said 38 \"late\")', at: 2}, {fact: '(said 41 \"new\")', within_s: 3.2}"),
              IsEmpty());
  EXPECT_THAT(failures_of(served(two + ", next_id: 77"), "{fact: '(said 77 \"new\")', within_s: 3.2}"), IsEmpty());
  EXPECT_THAT(failures_of(served("next_id: 5"), "{fact: '(said 5 \"\")', within_s: 3.2}, {fact: (asked 38), at: 4}"),
              IsEmpty());
  for (const auto& [keys, what] : std::initializer_list<std::pair<const char*, const char*>>{
           {"under_way: [{takes_s: 1}]", "key 'id' is missing"},
           {"under_way: [{id: 0}]", "found 0, expected the number of a request, from 1"},
           {"under_way: [{id: x}]", "id"},
           {"under_way: [{id: 1, handle: <x>}]", "unknown key 'handle'"},
           {"under_way: [{id: 1, outcome: reject}]", "a service cannot reject"},
           {"next_id: 0", "found 0, expected the number of a request, from 1"}})
    EXPECT_THAT(failures_of(served(keys), "{not_fires: open}"), ElementsAre(HasSubstr(what))) << keys;
  EXPECT_THAT(
      failures_of(served("next_id: 5", "/other"), "{not_fires: open}"),
      ElementsAre(HasSubstr("/other: the agent has no client of this service when the story begins, so no request "
                            "to it can have been sent; open one in `calls`: (ros-msgs-create-client \"/other\" "
                            "\"std_srvs/srv/SetBool\")")));
  EXPECT_THAT(
      read("- story: s\n  rules: door.clp\n" + served("under_way: [{id: 1}]") + "  expect: [{not_fires: open}]\n")
          .error()
          .text(),
      HasSubstr("/may: `under_way` needs a story with `moment: true`"));
}

/// An errand that is run again until it succeeds.
const char* const kErrand =
    "(deftemplate errand (slot state (default NEW)) (slot tries (default 0)))\n"
    "(defrule begin (wanted) => (ros-msgs-create-action-client \"/go\" \"cxlab_skills/action/DriveTo\") (assert "
    "(errand)))\n"
    "(defrule send ?e <- (errand (state NEW) (tries ?n)) (time ?)\n  =>\n"
    "  (bind ?goal (ros-msgs-create-goal-request \"cxlab_skills/action/DriveTo\"))\n"
    "  (ros-msgs-async-send-goal ?goal \"/go\") (modify ?e (state SENT) (tries (+ ?n 1))))\n"
    "(defrule done ?e <- (errand (state SENT)) ?r <- (ros-msgs-wrapped-result (code ?code)) => (retract ?r)\n"
    "  (modify ?e (state (if (eq ?code SUCCEEDED) then DONE else NEW))))\n";

TEST_F(Stories, ChanceDecidesByTheSeed) {
  write("errand.clp", kErrand);
  const auto failed_with = [&](const std::string& faults, const std::string& expect) {
    const auto stories = read(
        "- story: s\n  rules: errand.clp\n  seeds: \"1..40\"\n  given: [(wanted)]\n"
        "  skills: [{action: /go, type: cxlab_skills/action/DriveTo, takes_s: [1, 2]}]\n"
        "  faults: [" +
        faults + "]\n  expect: [{" + expect + "}]\n");
    std::vector<std::uint64_t> failed;
    if (!stories) ADD_FAILURE() << stories.error().text();
    if (!stories) return failed;
    for (const std::uint64_t seed : stories->front().seeds) {
      StorySpec spec = stories->front();
      spec.seed = seed;
      const StoryResult result = run_story(spec, {interfaces_dir()});
      EXPECT_FALSE(result.bad) << result.bad->text();
      if (!result.passed()) failed.push_back(seed);
    }
    return failed;
  };
  const std::string in_time = "fact: (errand (state DONE)), within_s: 2.5";
  EXPECT_THAT(failed_with("", in_time), IsEmpty());
  EXPECT_GT(failed_with("", "fact: (errand (state DONE)), within_s: 1.5").size(), 5u) << "it takes 1 to 2 s";
  EXPECT_EQ(failed_with("{outcome: fail, probability: 1}", in_time).size(), 40u);
  EXPECT_THAT(
      failed_with("{outcome: fail, probability: 1, times: 2}", "fact: (errand (state DONE) (tries 3)), within_s: 5"),
      IsEmpty());
  const auto some = failed_with("{skill: /go, outcome: fail, probability: 0.3, takes_s: 1}",
                                "fact: (errand (state DONE) (tries 1)), within_s: 9");
  EXPECT_GT(some.size(), 4u);
  EXPECT_LT(some.size(), 24u);
  EXPECT_EQ(some,
            failed_with("{skill: /go, outcome: fail, probability: 0.3, takes_s: 1}, {outcome: never, probability: 0}",
                        "fact: (errand (state DONE) (tries 1)), within_s: 9"))
      << "one fault more changes no draw of another";
}

TEST_F(Stories, AGoalGivesFeedbackUntilItEnds) {
  write("errand.clp",
        kErrand + std::string("(defrule on-its-way ?f <- (ros-msgs-feedback (feedback-ptr ?p)) => "
                              "(retract ?f)\n  (assert (at ?p (ros-msgs-get-field ?p \"phase\") "
                              "(ros-msgs-get-field ?p \"remaining_m\") (now))))\n"
                              "(defrule stop (stop) ?r <- (ros-msgs-goal-response "
                              "(client-goal-handle-ptr ?h)) => (ros-msgs-async-cancel-goal \"/go\" ?h))\n"));
  const auto failures_of = [&](const std::string& answer, const std::string& expect, const std::string& more = "") {
    const auto stories = read("- story: s\n  rules: errand.clp\n  given: [(wanted)]\n  end: 9\n" + more +
                              "  skills: [{action: /go, type: cxlab_skills/action/DriveTo, " + answer +
                              "}]\n  expect: [" + expect + "]\n");
    if (!stories) return std::vector{stories.error().text()};
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? std::vector{result.bad->text()} : result.failures;
  };
  const std::string twice =
      "takes_s: 4, feedback: [{after_s: 3, data: {phase: there}}, {after_s: 1, data: {phase: far, remaining_m: 2.5}}, "
      "{after_s: 4}]";
  EXPECT_THAT(failures_of(twice,
                          "{fact: '(at ? \"far\" 2.5 1)', at: 1}, {no_fact: '(at $?)', within_s: 0.98}, "
                          "{no_fact: '(at ? \"there\" $?)', within_s: 2.98}, {fact: '(at ? \"there\" 0.0 3)', at: 3}, "
                          "{fact: '(at ? \"\" 0.0 4)', at: 4}, {fact: (errand (state DONE)), at: 4}"),
              IsEmpty());
  EXPECT_THAT(failures_of(twice, "{fires: on-its-way, count: 4, within_s: 9}"), ElementsAre(HasSubstr("3 s, 4 s")));
  EXPECT_THAT(failures_of("outcome: never, feedback: [{after_s: 2}]", "{fires: on-its-way, after: 2, within_s: 2}"),
              IsEmpty());
  EXPECT_THAT(failures_of(twice, "{not_fires: on-its-way, after: 1.1}", "  steps: [{at: 2, assert: (stop)}]\n"),
              IsEmpty())
      << "a canceled goal says no more";
  EXPECT_THAT(failures_of("outcome: fail, takes_s: 1, feedback: [{after_s: 0.5}], then: [{takes_s: 1, feedback: "
                          "[{after_s: 0.2, data: {phase: again}}]}]",
                          "{fact: '(at ? \"\" 0.0 0.5)', at: 1}, {fact: '(at ? \"again\" $?)', within_s: 1.3}, "
                          "{fires: on-its-way, count: 2, within_s: 2}"),
              IsEmpty());
  const std::string fails = "  faults: [{outcome: fail, probability: 1, takes_s: 9";
  EXPECT_THAT(failures_of(twice, "{not_fires: on-its-way}", fails + "}]\n"), IsEmpty())
      << "a fault is the whole answer";
  EXPECT_THAT(failures_of(twice,
                          "{fact: '(at ? \"\" 0.0 2)', at: 2}, {fires: on-its-way, within_s: 3}, {not_fires: "
                          "on-its-way, within_s: 1.9}, {not_fires: on-its-way, after: 2.1}",
                          fails + ", feedback: [{after_s: 2}]}]\n"),
              IsEmpty());
  for (const auto& [answer, what] : std::initializer_list<std::pair<const char*, const char*>>{
           {"takes_s: 2, feedback: [{after_s: 3}]",
            "t.story.yaml:5: [0].skills[0].feedback[0].after_s: found 3, expected no time after takes_s (2)"},
           {"takes_s: [1, 2], feedback: [{after_s: 2.5}]", "found 2.5, expected no time after takes_s (2)"},
           {"feedback: [{data: {}}]", "key 'after_s' is missing"},
           {"feedback: [{after_s: -1}]", "after_s"},
           {"takes_s: [1, 2], feedback: [{after_s: [0, 1]}]", "feedback[0].after_s: found a list, expected a number"},
           {"feedback: {after_s: 1}", "expected a list"},
           {"feedback: [{after_s: 0, date: {}}]",
            "unknown key 'date' in '[0].skills[0].feedback[0]', did you mean 'data'?"},
           {"feedback: [{after_s: 0, data: {phase: x, speed: 1}}]", "t.story.yaml:5: /go: feedback: "},
           {"outcome: reject, feedback: [{after_s: 0}]",
            "found `feedback` of a goal that is rejected, expected it only for goals that run"}})
    EXPECT_THAT(failures_of(answer, "{fires: send, within_s: 1}"), ElementsAre(HasSubstr(what))) << answer;
  EXPECT_THAT(failures_of("takes_s: 1", "{fires: send, within_s: 1}",
                          "  serve: [{service: /s, type: std_srvs/srv/Trigger, feedback: [{after_s: 0}]}]\n"),
              ElementsAre(HasSubstr("a service gives no feedback")));
}

TEST_F(Stories, MistakesInSeedsAndFaultsAreFound) {
  const auto said = [&](const std::string& more) {
    const auto stories =
        read("- story: s\n  rules: door.clp\n" + more + "\n  expect: [{not_fires: slam, within_s: 1}]\n");
    if (!stories) return stories.error().text();
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? result.bad->text() : "no error";
  };
  for (const auto& [more, what] : std::initializer_list<std::pair<const char*, const char*>>{
           {"  seeds: \"5..1\"", "expected a seed, a range"},
           {"  seeds: []", "expected at least one seed"},
           {"  seeds: [1, 1]", "found seed 1 twice"},
           {"  seed: 1\n  seeds: [2]", "found beside seeds, expected one of the two"},
           {"  faults: [{outcome: fail, probability: 2}]", "found 2, expected a probability from 0 to 1"},
           {"  faults: [{outcome: fail}]", "'probability' is missing"},
           {"  faults: [{probability: 0.5}]", "'outcome' is missing"},
           {"  faults: [{service: /s, outcome: reject, probability: 1}]", "a service cannot reject"},
           {"  faults: [{skill: /pick, outcome: fail, probability: 1}]",
            "nobody serves /pick, so this fault can never strike"},
           {"  faults: [{outcome: fail, probability: 1, times: 0}]", "times: expected at least 1"},
           {"  skills: [{action: /a, type: cxlab_skills/action/Pick, takes_s: [3, 1]}]",
            "expected seconds from 0 to 1e9: 2, or [1, 4]"},
           {"  golden: run",
            "t.story.yaml:2: [0].rules: a golden run has its own agent, world and seed: only `end` may stand beside"}})
    EXPECT_THAT(said(more), HasSubstr(what)) << more;
  EXPECT_THAT(read("- story: s\n  golden: run\n  seed: 4\n").error().text(), HasSubstr("t.story.yaml:3: [0].seed: "));
  EXPECT_THAT(read("- story: s\n- story: t\n").error().text(), HasSubstr("expected one of config, rules, golden"));
  EXPECT_THAT(read("- story: s\n  rules: door.clp\n  end: 1\n").error().text(), HasSubstr("nothing is expected"));
}

TEST_F(Stories, AStoryThatWouldEndAtItsFirstTickIsAMistake) {
  const auto said = [&](const std::string& more) {
    const auto stories = read("- story: s\n  rules: door.clp\n" + more + "\n");
    return stories ? std::string("no error") : stories.error().text();
  };
  const std::string unlimited = "  expect: [{not_fires: slam}, {no_fact: (door)}]";
  EXPECT_THAT(said(unlimited), HasSubstr("no time is named, so the story would end at its first tick"));
  for (const char* time : {"  end: 1\n", "  steps: [{at: 1, assert: (x)}]\n"})
    EXPECT_EQ(said(time + unlimited), "no error");
  EXPECT_EQ(said("  expect: [{not_fires: slam}, {fires: shut, within_s: 1}]"), "no error");
  EXPECT_EQ(said("  expect: [{not_fires: slam, after: 1}]"), "no error");
}

TEST_F(Stories, ErrorOfARuleFailsTheStoryWithItsPlace) {
  write("door.clp", "(deftemplate door (slot state))\n(defrule bad\n  (door)\n  =>\n  (nth$ 1 7))\n");
  EXPECT_THAT(play("fires: bad, within_s: 1").bad ? play("fires: bad, within_s: 1").bad->text() : "",
              HasSubstr("door.clp:"));
  write("door.clp",
        "(deftemplate door (slot state))\n(defrule bad\n  (door (state ?s))\n  =>\n  (+ 1 (str-cat ?s)))\n");
  StoryResult result = play("fires: bad, within_s: 1");
  EXPECT_FALSE(result.passed());
}

/// Rules that open what the story may misspell, and publish three messages.
constexpr const char* kOpen =
    "(defrule begin =>\n"
    "  (ros-msgs-create-client \"/may_i\" \"std_srvs/srv/SetBool\")\n"
    "  (ros-msgs-create-action-client \"/robot1/pick\" \"cxlab_skills/action/Pick\")\n"
    "  (ros-msgs-create-action-client \"/robot3/pick\" \"cxlab_skills/action/Pick\")\n"
    "  (ros-msgs-create-subscription \"/bell\" \"std_msgs/msg/String\")\n"
    "  (ros-msgs-create-publisher \"/door\" \"geometry_msgs/msg/Vector3\"))\n"
    "(defrule say (say ?x ?y) =>\n"
    "  (bind ?m (ros-msgs-create-message \"geometry_msgs/msg/Vector3\"))\n"
    "  (ros-msgs-set-field ?m \"x\" ?x)\n  (ros-msgs-set-field ?m \"y\" ?y)\n"
    "  (ros-msgs-publish ?m \"/door\")\n  (ros-msgs-destroy-message ?m))\n";

TEST_F(Stories, ANameThatNobodyUsesIsANoteWhereItMayBeMisspelt) {
  write("open.clp", kOpen);
  const auto notes = [&](const std::string& more) {
    const auto stories = read("- story: s\n  rules: open.clp\n" + more + "  expect: [{fires: begin, within_s: 1}]\n");
    EXPECT_TRUE(stories) << stories.error().text();
    StoryResult result = run_story(stories->front(), {interfaces_dir()});
    EXPECT_TRUE(result.passed()) << more;
    std::erase_if(result.notes, [](const std::string& note) { return note.find("cleaning up") != note.npos; });
    return result.notes;
  };
  const auto serve = [](const std::string& name) {
    return "  serve: [{service: " + name + ", type: std_srvs/srv/SetBool}]\n";
  };
  const auto skills = [](const std::string& name) {
    return "  skills: [{action: " + name + ", type: cxlab_skills/action/Pick}]\n";
  };
  const auto steps = [](const std::string& step) { return "  steps: [{at: 0.5, " + step + "}]\n"; };
  const std::string pick = ", type: cxlab_skills/action/Pick", text = ", type: std_msgs/msg/String";
  EXPECT_THAT(notes(serve("/my_i")), ElementsAre(HasSubstr("t.story.yaml:3: /my_i: the rules have no client of it, but "
                                                           "one of /may_i, which nobody serves")));
  EXPECT_THAT(notes(skills("/robot1/pik")),
              ElementsAre(HasSubstr("t.story.yaml:3: /robot1/pik: the rules have no client "
                                    "of it, but one of /robot1/pick, which nobody")));
  EXPECT_THAT(notes(skills("/robot1/pick") + steps("skill: /robot1/pck" + pick)),
              ElementsAre(HasSubstr("t.story.yaml:4: /robot1/pck: the rules have no client of it, but one of "
                                    "/robot1/pick")));
  EXPECT_THAT(notes(steps("publish: /bel" + text)),
              ElementsAre(HasSubstr("t.story.yaml:3: /bel: the rules do not subscribe to it, but to /bell")));
  for (const std::string& right :
       {serve("/may_i"), serve("may_i"), serve("/other"), skills("/robot2/pick"), skills("/robot1/pick"),
        steps("publish: /bell" + text), steps("publish: /other" + text)})
    EXPECT_THAT(notes(right), IsEmpty()) << right;
}

TEST_F(Stories, TheNearestMessageHasMostOfTheFields) {
  write("open.clp", kOpen);
  const auto failure = [&](const std::string& expected) {
    const auto stories = read(
        "- story: s\n  rules: open.clp\n"
        "  steps: [{at: 1, assert: (say 1.0 2.0)}, {at: 2, assert: (say 3.0 4.0)}, {at: 3, assert: (say 5.0 6.0)}]\n"
        "  expect: [{published: " +
        expected + ", within_s: 4}]\n");
    EXPECT_TRUE(stories) << stories.error().text();
    return run_story(stories->front(), {interfaces_dir()}).failures;
  };
  const std::string door = "/door, type: geometry_msgs/msg/Vector3, fields: ";
  EXPECT_THAT(failure(door + "{x: 3, y: 5, z: 0}"), ElementsAre(HasSubstr("y: 4.0, z: 0.0} at 2 s")));
  EXPECT_THAT(failure(door + "{x: 7, y: 5}"), ElementsAre(HasSubstr("y: 6.0, z: 0.0} at 3 s"))) << "the last";
  EXPECT_THAT(failure(door + "{x: 1, y: 2}, count: 2"), ElementsAre(HasSubstr("there was 1; nearest: ")));
  EXPECT_THAT(failure(door + "{x: 1}, after: 3.5"), ElementsAre(HasSubstr("y: 2.0, z: 0.0} at 1 s")));
}

TEST_F(Stories, ATopicThatNobodyPublishesIsToldWithTheNearest) {
  write("open.clp", kOpen);
  const auto failure = [&](const std::string& topic) {
    const auto stories =
        read("- story: s\n  rules: open.clp\n  expect: [{published: " + topic + "/msg/Vector3, within_s: 1}]\n");
    return run_story(stories->front(), {interfaces_dir()}).failures;
  };
  EXPECT_THAT(failure("/dor, type: geometry_msgs"),
              ElementsAre(HasSubstr("there was none; nobody publishes this topic, only /door; did you mean '/door'?")));
  for (const char* topic : {"/door", "door"})
    EXPECT_THAT(failure(topic + std::string(", type: geometry_msgs")),
                ElementsAre(::testing::EndsWith("there was none")));
}

TEST_F(Stories, AFactDecisionIsSeenAsAnyOther) {
  write("door.clp",
        "(deftemplate door (slot state))\n(deftemplate decision (slot what))\n"
        "(defrule decide (bell) => (assert (decision (what open))))\n"
        "(defrule told ?d <- (decision) => (retract ?d))\n");
  EXPECT_THAT(play("fact: (decision (what open)), within_s: 1", kBell).failures, IsEmpty());
  EXPECT_THAT(play("no_fact: (decision)", kBell).failures, ElementsAre(HasSubstr("there was (decision (what open))")));
}

TEST_F(Stories, ParametersOfAStoryAreInsteadOfThoseOfItsConfiguration) {
  write("agent.yaml",
        "clips_manager:\n  ros__parameters:\n    environments: [main]\n    main: {plugins: [executive, param, files]}\n"
        "    executive: {plugin: 'cx::ExecutivePlugin'}\n    param: {plugin: 'cx::RosParamPlugin'}\n"
        "    files: {plugin: 'cx::FileLoadPlugin', pkg_share_dirs: [here], load: [rules.clp]}\n    door.width: 3\n");
  write("rules.clp",
        "(deftemplate width (slot of) (slot m))\n"
        "(defrule read (start) => (assert (width (of door) (m (ros-param-get-value \"door.width\" 1)))))\n");
  const auto stories = read(
      "common: {config: agent.yaml, packages: {here: .}, given: [(start)]}\nstories:\n"
      "  - story: configured\n    expect: [{fact: (width (of door) (m 3)), within_s: 1}]\n"
      "  - story: its own\n    params: {clips_manager.door.width: 5}\n"
      "    expect: [{fact: (width (of door) (m 5)), within_s: 1}]\n");
  ASSERT_TRUE(stories) << stories.error().text();
  for (const StorySpec& story : *stories) {
    const StoryResult result = run_story(story, {interfaces_dir()});
    EXPECT_FALSE(result.bad) << result.bad->text();
    EXPECT_THAT(result.failures, IsEmpty()) << story.name;
  }
}

}  // namespace
}  // namespace cxlab::testing
