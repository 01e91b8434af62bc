// Mistakes of a story are told all at once, before it plays.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/stories.h"

namespace cxlab::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(Stories, MistakesOfTheStoryAreNotPasses) {
  const auto text = [](const StoryResult& result) { return result.bad ? result.bad->text() : "no error"; };
  EXPECT_THAT(text(play("not_fires: opne, within_s: 1")),
              HasSubstr("t.story.yaml:5: there is no rule 'opne', did you mean 'open'?"));
  EXPECT_THAT(text(play("not_fire: open")),
              HasSubstr("t.story.yaml:5: unknown key 'not_fire' in '[0].expect[0]', did you mean 'not_fires'?"));
  EXPECT_THAT(
      text(play("fires: open, at: 1")),
      HasSubstr("[0].expect[0].at: it goes with `fact` and `no_fact` only; with `fires` go `count`, `after` and "
                "`within_s`"));
  EXPECT_THAT(text(play("fact: (door (state OPEN)")), HasSubstr("t.story.yaml:5"));
  EXPECT_THAT(text(play("goal: /r/pick, within_s: 1")), HasSubstr("nobody serves /r/pick"));
  EXPECT_THAT(text(play("no_fact: (dor (state OPEN)), within_s: 1")), HasSubstr("did you mean 'door'?"));
  EXPECT_THAT(text(play("no_fact: (door (stat OPEN)), within_s: 1")),
              AllOf(HasSubstr("t.story.yaml:5: "), HasSubstr("'stat'"), HasSubstr("did you mean 'state'?")));
}

TEST_F(Stories, AllNamesThatAreWrongAreTold) {
  const auto stories = read(
      "- story: s\n  rules: door.clp\n  given: [(door (stte OPEN)), (bel)]\n"
      "  steps: [{at: 1, retract: (door (stat OPEN))}, {at: 1, assert: (dor)}]\n"
      "  expect: [{fires: opne, within_s: 1}, {no_fact: (door (sttae OPEN))}, {fact: (dooor), within_s: 1}, {goal: /r, "
      "within_s: 1}, {fact: (dor), within_s: 1}, {fact: (xyz), within_s: 1}, {not_fires: slamm}]\n");
  ASSERT_TRUE(stories) << stories.error().text();
  const StoryResult result = run_story(stories->front(), {interfaces_dir()});
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(),
              HasSubstr("t.story.yaml:3: (door (stte OPEN)): template 'door' has no slot 'stte', did you mean"));
  EXPECT_THAT(result.failures,
              ElementsAre(HasSubstr("t.story.yaml:4: retract (door (stat OPEN)) can match no fact: template"),
                          HasSubstr("t.story.yaml:5: there is no rule 'opne', did you mean 'open'?"),
                          HasSubstr("t.story.yaml:5: (door (sttae OPEN)) can match no fact: template 'door' has no"),
                          HasSubstr("t.story.yaml:5: (dooor) can match no fact: there is no template 'dooor', did you "
                                    "mean 'door'?"),
                          HasSubstr("t.story.yaml:5: nobody serves /r"),
                          HasSubstr("t.story.yaml:5: there is no rule 'slamm', did you mean 'slam'?")));
  EXPECT_THAT(result.notes,
              ElementsAre(HasSubstr("t.story.yaml:3: (bel): no rule has facts 'bel', did you mean 'bell'?"),
                          HasSubstr("t.story.yaml:4: (dor): no rule has facts 'dor', did you mean 'door'?")));
}

TEST_F(Stories, APatternThatCannotBeReadIsToldWithOtherMistakes) {
  const StoryResult result = play(
      "fact: (door (state OPEN), within_s: 1}\n    - {no_fact: (door (state ~OPEN))}\n    - {fires: opne, within_s: 1");
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(), HasSubstr("t.story.yaml:5: fact pattern (door (state OPEN): found no closing"));
  EXPECT_THAT(result.failures, ElementsAre(HasSubstr("t.story.yaml:6: fact pattern (door (state ~OPEN)): &, | and ~"),
                                           HasSubstr("t.story.yaml:7: there is no rule 'opne'")));
}

TEST_F(Stories, AnEntryIsOneFactAndNothingMore) {
  write("door.clp",
        "(deftemplate door (slot state (allowed-values OPEN CLOSED)) (slot width (type INTEGER) (range 1 9)))\n");
  const auto stories = read(
      "- story: s\n  rules: door.clp\n  given:\n"
      "    - '(bell) (wind)'\n    - '(bell) ; a comment'\n    - '(bell) loud'\n    - '(door (state \"OPEN'\n    - "
      "bell\n"
      "  steps:\n    - {at: 1, assert: '(door (state OPEN)) (bell)'}\n    - {at: 1, retract: '(bell) (wind)'}\n"
      "    - {at: 1, assert: '(bell))'}\n"
      "  expect:\n    - {fact: '(bell) (wind)', within_s: 1}\n    - {no_fact: (bell) loud}\n");
  ASSERT_TRUE(stories) << stories.error().text();
  const StoryResult result = run_story(stories->front(), {interfaces_dir()});
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(),
              HasSubstr("t.story.yaml:4: found (wind) after (bell), expected one fact: give each an "
                        "entry of its own"));
  EXPECT_THAT(result.failures,
              ElementsAre(HasSubstr(":6: found loud after (bell), expected one fact"),
                          HasSubstr(":7: (door (state \"OPEN: found no closing parenthesis for (door ...)"),
                          HasSubstr(":8: found 'bell', expected a fact in parentheses"),
                          HasSubstr(":10: found (bell) after (door (state OPEN)), expected one fact"),
                          HasSubstr(":11: fact pattern (bell) (wind): expected one pattern in parentheses"),
                          HasSubstr(":12: (bell)): found ')' that closes nothing"),
                          HasSubstr(":14: fact pattern (bell) (wind): expected one pattern in parentheses"),
                          HasSubstr(":15: fact pattern (bell) loud: expected one pattern in parentheses")));
}

TEST_F(Stories, ValuesOfFactsAreLookedAtBeforeThePlay) {
  write("door.clp",
        "(deftemplate door (slot state (allowed-values OPEN CLOSED)) (slot width (type INTEGER) (range 1 9))\n"
        "  (slot bell (type FACT-ADDRESS SYMBOL) (allowed-symbols NONE)) (multislot of))\n");
  const auto stories = read(
      "- story: s\n  rules: door.clp\n  given:\n"
      "    - {fact: (bell), as: <Fact-1>}\n    - (door (state OPNE))\n    - (door (width wide) (bell <Fact-1>))\n"
      "    - (door (state OPEN) (bell <Fact-1>) (of a b))\n    - (door (width 3 4))\n    - (door (state))\n"
      "    - (door (width (+ 1 2)))\n"
      "  steps:\n    - {at: 1, assert: (door (width 12))}\n    - {at: 1, assert: (door (width 2.5))}\n"
      "  expect:\n    - {no_fact: (door (width 3 4))}\n");
  ASSERT_TRUE(stories) << stories.error().text();
  const StoryResult result = run_story(stories->front(), {interfaces_dir()});
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(),
              HasSubstr("t.story.yaml:5: (door (state OPNE)): slot 'state' of template 'door' cannot "
                        "be OPNE; it holds OPEN, CLOSED; did you mean 'OPEN'?"));
  EXPECT_THAT(
      result.failures,
      ElementsAre(
          HasSubstr(":6: (door (width wide) (bell <Fact-1>)): slot 'width' of template 'door' cannot be"),
          HasSubstr(":8: (door (width 3 4)): slot 'width' of template 'door' holds one value, found 2"),
          HasSubstr(":9: (door (state)): slot 'state' of template 'door' holds one value, found none"),
          HasSubstr(":12: (door (width 12)): slot 'width' of template 'door' cannot be 12; its range is 1 to 9"),
          HasSubstr(":13: (door (width 2.5)): slot 'width' of template 'door' cannot be 2.5; its type is"),
          HasSubstr(":15: (door (width 3 4)) can match no fact: slot 'width' of template 'door' holds")));
}

TEST_F(Stories, WhatIsNoFactIsToldInWords) {
  const auto told = [&](const std::string& fact) {
    const auto stories = read("- story: s\n  rules: door.clp\n  calls: ['(defglobal ?*name* = Ada)']\n  given: ['" +
                              fact + "']\n  expect: [{not_fires: slam, within_s: 1}]\n");
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? result.bad->text() : "played";
  };
  for (const auto& [fact, found] : std::initializer_list<std::pair<const char*, const char*>>{{"(door (by ?x))", "?x"},
                                                                                              {"(bell ?)", "?"},
                                                                                              {"(bell $?x)", "$?x"},
                                                                                              {"(bell a&b)", "&"},
                                                                                              {"(door (by ~A))", "~"}})
    EXPECT_THAT(told(fact), HasSubstr("t.story.yaml:4: " + std::string(fact) + ": found " + found +
                                      ", expected a value: a fact has no variables, and no &, | or ~"));
  for (const std::string fact : {"()", "((bell))"})
    EXPECT_THAT(told(fact), HasSubstr("t.story.yaml:4: found '" + fact + "', expected the name of a template first"));
  for (const char* fact : {"(door (by ?*name*))", "(bell ?*name*)", "(door (by (str-cat a b)))", "(bell \"?x & y\")",
                           "(bell (length$ (find-all-facts ((?f door)) (eq ?f:by A))))"})
    EXPECT_EQ(told(fact), "played") << fact;
  EXPECT_THAT(play("fires: MAN::opne, within_s: 1").bad->text(),
              HasSubstr("no rule 'MAN::opne', did you mean 'open'?"));
}

TEST_F(Stories, OnlyCallsThatMakeAnyNameHideMisspeltOnes) {
  const auto told = [&](const std::string& action) {
    write("door.clp", "(deftemplate slide (slot loaded))\n(defrule r ?s <- (slide) (poke ?) => " + action + ")\n");
    const auto stories = read("- story: s\n  rules: door.clp\n  expect: [{no_fact: (poek 1), within_s: 1}]\n");
    EXPECT_TRUE(stories) << stories.error().text();
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? result.bad->text() : result.passed() ? "passed" : result.failures.front();
  };
  for (const char* action : {"(modify ?s (loaded 1))", "(assert (loading 1))", "(assert (builder))",
                             "(assert (evaluated))", "(assert-string \"(barx 1)\")", "(eval \"(+ 1 2)\")"})
    EXPECT_THAT(told(action), HasSubstr("(poek 1) can match no fact: there is no template 'poek'")) << action;
  EXPECT_EQ(told("(assert-string (str-cat \"(x\" 1 \")\"))"), "passed");
  for (const char* action : {"(build (str-cat \"(deffacts x)\"))", "(load* \"none.clp\")", "(load-facts \"none\")"})
    EXPECT_THAT(told(action), HasSubstr("there is no template 'poek', so this says nothing")) << action;
}

TEST_F(Stories, AWrongValueInRetractIsAMistake) {
  write("door.clp", "(deftemplate door (slot state (allowed-values OPEN CLOSED)))\n");
  const auto stories = read(
      "- story: s\n  rules: door.clp\n  steps: [{at: 1, retract: (door (state OPNE))}]\n  expect: [{no_fact: "
      "(door)}]\n");
  ASSERT_TRUE(stories) << stories.error().text();
  const StoryResult result = run_story(stories->front(), {interfaces_dir()});
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(),
              AllOf(HasSubstr(":3: retract (door (state OPNE)) can match no fact: "), HasSubstr("cannot be OPNE")));
}

TEST_F(Stories, NamesThatRulesMakeOfTextAreNotDoubted) {
  write("door.clp",
        "(defrule make (n ?n) => (assert-string (str-cat \"(goal-\" ?n \" x)\")))\n(defrule read (goal-1 ?) (visitor "
        "?) =>)\n");
  const auto played = [&](const std::string& story) {
    const auto stories = read("- story: s\n  rules: door.clp\n" + story);
    EXPECT_TRUE(stories) << stories.error().text();
    return run_story(stories->front(), {interfaces_dir()});
  };
  StoryResult result =
      played("  given: ['(n 30)']\n  expect: [{fact: '(goal-30 x)', within_s: 1}, {no_fact: '(goal-3 x)'}]\n");
  EXPECT_TRUE(result.passed()) << (result.bad ? result.bad->text() : ::testing::PrintToString(result.failures));
  EXPECT_THAT(result.notes, IsEmpty());
  result = played("  given: ['(visitr ada)']\n  expect: [{no_fact: '(goal-3 x)', within_s: 1}]\n");
  EXPECT_THAT(result.notes,
              ElementsAre(HasSubstr("(visitr ada): no rule has facts 'visitr', did you mean 'visitor'?")));
}

TEST_F(Stories, AHandleOfNothingIsAMistake) {
  const auto told = [&](const std::string& fact) {
    const auto stories = read(
        "- story: s\n  rules: door.clp\n  given:\n    - {fact: (wind), as: <Fact-1>}\n"
        "    - {fact: (key), as: <Key>}\n    - " +
        fact + "\n  expect: [{fact: (wind), at: 1}]\n");
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return result.bad ? result.bad->text() : "played";
  };
  EXPECT_THAT(told("(door (by <Fact-2>))"),
              HasSubstr("t.story.yaml:6: (door (by <Fact-2>)): no fact or goal of this story is <Fact-2>; known: "
                        "<Fact-1>, <Key>; did you mean '<Fact-1>'?"));
  EXPECT_THAT(told("(door (by <Kye>))"), HasSubstr("no fact or goal of this story is <Kye>; known: "));
  EXPECT_THAT(told("(door (by <Pointer-C-0x5>))"), HasSubstr("no fact or goal of this story is <Pointer-C-0x5>"));
  for (const char* fact : {"(door (by <Fact-1>))", "(door (by <Key>))", "(door (by <=>))", "(door (by \"<Fact-2>\"))"})
    EXPECT_EQ(told(fact), "played") << fact;
  EXPECT_THAT(play("not_fires: slam, within_s: 1", "  steps: [{at: 1, assert: (bell <Fact-2>)}]\n").bad->text(),
              HasSubstr(":4: (bell <Fact-2>): no fact or goal of this story is <Fact-2>; name a fact that is given "
                        "before: {fact: (...), as: <Fact-2>}"));
}

TEST_F(Stories, MistakesInMessagesHideNoOthers) {
  const auto stories = read(
      "- story: s\n  rules: door.clp\n"
      "  skills:\n"
      "    - {action: /r/pick, type: cxlab_skills/action/Pikc}\n"
      "    - {action: /r/place, type: cxlab_skills/action/Place, result: {a: 1}, then: [{result: {b: 1}}]}\n"
      "  faults: [{outcome: fail, probability: 1, result: {c: 1}}, {skill: /r/plce, outcome: fail, probability: 1}]\n"
      "  steps:\n"
      "    - {at: 1, publish: /x, type: std_msgs/msg/Strin}\n"
      "    - {at: 1, publish: /y, type: std_msgs/msg/String, data: {dat: a}}\n"
      "    - {at: 1, publish: /y, type: std_msgs/msg/Int32}\n"
      "    - {at: 1, skill: /r/place, type: cxlab_skills/action/Pick}\n"
      "  expect:\n"
      "    - {fires: opne, within_s: 1}\n"
      "    - {goal: /r/pick, fields: {d: 1}, within_s: 1}\n"
      "    - {goal: /r/place, fields: {e: 1}, within_s: 1}\n"
      "    - {published: /z, type: std_msgs/msg/String, fields: {f: 1}, within_s: 1}\n"
      "    - {published: /z, type: std_msgs/msg/Strng, within_s: 1}\n"
      "    - {published: /x, type: std_msgs/msg/String, within_s: 1}\n");
  ASSERT_TRUE(stories) << stories.error().text();
  StoryResult result = run_story(stories->front(), {interfaces_dir()});
  ASSERT_TRUE(result.bad);
  EXPECT_THAT(result.bad->text(), HasSubstr("t.story.yaml:4: /r/pick: 'cxlab_skills/action/Pikc' is not defined"));
  EXPECT_THAT(
      result.failures,
      ElementsAre(HasSubstr(":5: /r/place: cxlab_skills/action/Place_Result has no field 'a'"),
                  HasSubstr(":5: /r/place: cxlab_skills/action/Place_Result has no field 'b'"),
                  HasSubstr(":6: /r/place: cxlab_skills/action/Place_Result has no field 'c'"),
                  HasSubstr(":6: nobody serves /r/plce"),
                  HasSubstr(":6: /r/place: cxlab_skills/action/Pick_Result has no field 'c'"),
                  HasSubstr(":8: /x: 'std_msgs/msg/Strin' is not"),
                  HasSubstr(":9: /y: std_msgs/msg/String has no field 'dat'"),
                  HasSubstr(":10: /y: found std_msgs/msg/Int32, expected std_msgs/msg/String, its type on line 9"),
                  HasSubstr(":11: /r/place: found cxlab_skills/action/Pick, expected cxlab_skills/action/Place"),
                  HasSubstr(":13: there is no rule 'opne'"),
                  HasSubstr(":15: /r/place: cxlab_skills/action/Place_Goal has no field 'e'"),
                  HasSubstr(":15: /r/place: cxlab_skills/action/Pick_Goal has no field 'e'"),
                  HasSubstr(":16: /z: std_msgs/msg/String has no field 'f'"),
                  HasSubstr(":17: /z: 'std_msgs/msg/Strng' is not defined")));
  Stage stage(stories->front(), {interfaces_dir()});
  EXPECT_EQ(stage.play(stories->front()).failures, result.failures);

  write("door.clp", "(defrule open (bell) => (assert))\n(defrule)\n");
  EXPECT_THAT(run_story(stories->front(), {interfaces_dir()}).failures, ::testing::Contains(result.bad->text()))
      << "also where the rules do not load";
}

TEST_F(Stories, WrongNamesInStepsAreToldBeforeThePlay) {
  const auto told = [&](const std::string& step) {
    const StoryResult result = play("not_fires: slam, within_s: 3", "  steps: [{at: 2, " + step + "}]\n");
    EXPECT_EQ(result.sim_time_s, 0) << step;
    return result.bad ? result.bad->text() : "no error";
  };
  for (const auto& [step, why] : std::initializer_list<std::pair<const char*, const char*>>{
           {"assert: (dor (state OPEN))", "(dor (state OPEN)): there is no template 'dor', did you mean 'door'?"},
           {"assert: (xyz (state OPEN))", "(xyz (state OPEN)): there is no template 'xyz'"},
           {"assert: (bell (state OPEN))", "(bell (state OPEN)): template 'bell' has no slots: its facts are ordered"},
           {"assert: (door (stte OPEN))",
            "(door (stte OPEN)): template 'door' has no slot 'stte', did you mean 'state'?"},
           {"retract: (dor (state OPEN))", "retract (dor (state OPEN)): there is no template 'dor', did you mean"},
           {"retract: (bel)", "retract (bel): there is no template 'bel', did you mean 'bell'?"},
           {"retract: (xyz 7)", "retract (xyz 7): there is no template 'xyz'"},
           {"retract: \"(door (state ~OPEN))\"", "fact pattern (door (state ~OPEN)): &, | and ~ are not"}})
    EXPECT_THAT(told(step), HasSubstr(std::string("t.story.yaml:4: ") + why));
  const StoryResult given = play("not_fires: open", "  steps: [{at: 1, assert: (bel)}, {at: 2, retract: (bel)}]\n");
  EXPECT_FALSE(given.bad);
  EXPECT_THAT(given.failures, IsEmpty());
  EXPECT_THAT(given.notes, ElementsAre(HasSubstr("t.story.yaml:4: (bel): no rule has facts 'bel', did you mean")));
}

TEST_F(Stories, AMisspeltOrderedFactIsAMistakeWhereItCannotBeMeant) {
  const auto told = [&](const std::string& expectation, const std::string& more = {}) {
    const StoryResult result = play(expectation + ", within_s: 1", more);
    return result.bad ? result.bad->text() : "played";
  };
  for (const char* kind : {"fact: ", "no_fact: "}) {
    EXPECT_THAT(
        told(kind + std::string("(bel 7)")),
        HasSubstr("t.story.yaml:5: (bel 7) can match no fact: there is no template 'bel', did you mean 'bell'?"));
    EXPECT_EQ(told(kind + std::string("(xyz 7)")), "played") << "nothing is near";
    EXPECT_EQ(told(kind + std::string("(winder 7)")), "played") << "this may be another word";
    EXPECT_EQ(told(kind + std::string("(bell 7)")), "played") << "a rule reads it";
    EXPECT_EQ(told(kind + std::string("(tim 7)"), "  steps: [{at: 1, assert: (tim 7)}]\n"), "played")
        << "the story makes it";
    EXPECT_EQ(told(kind + std::string("(time 7)")), "played") << "a plugin makes it";
    EXPECT_THAT(told(kind + std::string("(tiem 7)")), HasSubstr("did you mean 'time'?"));
  }
  EXPECT_THAT(play("fact: (xyz 7), within_s: 1").failures,
              ElementsAre(HasSubstr("expected fact (xyz 7) by 1 s; there is no template 'xyz'")));
  EXPECT_THAT(play("no_fact: (xyz 7), within_s: 1").failures,
              ElementsAre(HasSubstr("there is no template 'xyz', so this says nothing")));
  EXPECT_THAT(play("not_fires: slam", "  given: [(xyz 7), (bell)]\n").notes, IsEmpty());
}

TEST_F(Stories, FactsThatRulesMayMakeByTextsOrFilesAreNoMistake) {
  const auto told = [&](const std::string& rules) {
    write("door.clp", "(deftemplate door (slot state))\n(defrule open (bell) => (assert (light)))\n" + rules);
    auto stories =
        read("- story: s\n  rules: door.clp\n  steps: [{at: 1, assert: (bell)}, " +
             std::string("{at: 2, assert: (dor (state OPEN))}]\n  expect: [{fact: (lihgt 1), within_s: 1}]\n"));
    const StoryResult result = run_story(stories->front(), {interfaces_dir()});
    return std::vector{result.bad ? result.bad->text() : std::string("played"), std::to_string(result.failures.size())};
  };
  EXPECT_THAT(told(""), ElementsAre(HasSubstr("there is no template 'dor'"), "1"));
  EXPECT_THAT(told("(defrule text (bell) => (assert-string \"(lihgt 1)\"))\n"),
              ElementsAre(HasSubstr("there is no template 'dor'"), "0"));
  EXPECT_THAT(told("(defrule text (bell) => (assert-string \"(lihgt 1)\")\n"
                   "  (build (str-cat \"(deftemplate d\" \"or (slot state))\")))\n"),
              ElementsAre("played", "0"));
  EXPECT_THAT(told("(defrule file (wind) => (load-facts \"lights\"))\n"),
              ElementsAre(HasSubstr("(dor (state OPEN)): there is no template 'dor', did you mean 'door'?"), "0"))
      << "when its time comes";
}

TEST_F(Stories, FactsOfRulesInOtherModulesAreKnown) {
  write("door.clp",
        "(defmodule NAV)\n(deftemplate way (slot to))\n(deffacts nav (bells) (way (to x)))\n"
        "(defrule open (bells) (way) => (printout t a))\n");
  const auto stories = read(
      "- story: s\n  rules: door.clp\n  expect: [{fact: (NAV::bells), at: 1}, {fact: (NAV::way (to x)), at: 1}, "
      "{no_fact: (NAV::bells)}]\n");
  const StoryResult result = run_story(stories->front(), {interfaces_dir()});
  EXPECT_FALSE(result.bad) << result.bad->text();
  EXPECT_THAT(result.failures, ElementsAre(HasSubstr("expected no fact (NAV::bells); there was (bells) from 0 s")));
  EXPECT_THAT(result.notes, IsEmpty());
}

TEST_F(Stories, APatternThatNoFactCanMatchIsAMistake) {
  write("door.clp",
        "(deftemplate door (slot state (allowed-symbols OPEN CLOSED)) (slot width (type INTEGER)) (slot x (type "
        "FLOAT)))\n");
  const auto text = [&](const std::string& pattern) {
    const StoryResult result = play("no_fact: '" + pattern + "', within_s: 1");
    return result.bad ? result.bad->text() : "no error";
  };
  for (const auto& [pattern, why] : std::initializer_list<std::pair<const char*, const char*>>{
           {"(door (state OPNE))",
            "slot 'state' of template 'door' cannot be OPNE; it holds OPEN, CLOSED; did you mean"},
           {"(door (width 1.5))", "slot 'width' of template 'door' cannot be 1.5; its type is INTEGER"},
           {"(door 7)", "template 'door' has slots; write (door (SLOT VALUE))"},
           {"(door (stat OPEN))", "template 'door' has no slot 'stat', did you mean 'state'?"},
           {"(door (x 1) (x 2))", "slot 'x' is in the pattern twice"},
           {"(MAIN::door (x OPEN))", "slot 'x' of template 'door' cannot be OPEN; its type is FLOAT"},
           {"(door (x 1) (width wide))", "slot 'width' of template 'door' cannot be wide; its type is INTEGER"}})
    EXPECT_THAT(text(pattern), HasSubstr("t.story.yaml:5: " + std::string(pattern) + " can match no fact: " + why));
  for (const char* pattern : {"(door (state OPEN))", "(door (width 7))", "(door (state ?))", "(anything 7)",
                              "(door (x 3))", "(door (x -3) (width 7.0))", "(MAIN::door (x 3))"})
    EXPECT_EQ(text(pattern), "no error") << pattern;
}

}  // namespace
}  // namespace cxlab::testing
