// Stories tell what is wrong, where, and what was there instead.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "cx/testing/story.h"
#include "tests/support/files.h"

namespace cxlab::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Stories : public ::testing::Test {
 protected:
  Stories() {
    write("door.clp",
          "(deftemplate door (slot state) (slot by (default NOBODY)))\n"
          "(defrule open \"A bell.\" (bell) ?d <- (door (state CLOSED)) => (modify ?d (state OPEN) (by BELL)))\n"
          "(defrule slam (wind) ?d <- (door (state OPEN)) => (modify ?d (state CLOSED)))\n");
  }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  Expected<std::vector<StorySpec>> read(const std::string& text) {
    write("t.story.yaml", text);
    return read_stories(folder_ / "t.story.yaml");
  }
  /// The one story of a bell and a door, with these expectations.
  StoryResult play(const std::string& expectation, const std::string& more = {}) {
    auto stories = read("- story: s\n  rules: door.clp\n  given: [(door (state CLOSED))]\n" + more +
                        "  expect:\n    - {" + expectation + "}\n");
    if (!stories) {
      StoryResult bad;
      bad.bad = stories.error();
      return bad;
    }
    return run_story(stories->front(), {interfaces_dir()});
  }
  TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
};

const char* const kBell = "  steps: [{at: 1, assert: (bell)}]\n";

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

TEST_F(Stories, FiringIsCounted) {
  EXPECT_THAT(play("fires: open, within_s: 1", kBell).failures, IsEmpty());
  EXPECT_THAT(play("fires: open, count: 2, within_s: 2", kBell).failures, ElementsAre(HasSubstr("it fired at 1 s")));
  EXPECT_THAT(play("fires: slam, within_s: 2", kBell).failures,
              ElementsAre(HasSubstr("condition 1 does not hold: (wind): there is no fact of wind")));
  EXPECT_THAT(play("not_fires: open, within_s: 2", kBell).failures, ElementsAre(HasSubstr("it fired at 1 s")));
}

TEST_F(Stories, MistakesOfTheStoryAreNotPasses) {
  const auto text = [](const StoryResult& result) { return result.bad ? result.bad->text() : "no error"; };
  EXPECT_THAT(text(play("not_fires: opne")),
              HasSubstr("t.story.yaml:5: there is no rule 'opne', did you mean 'open'?"));
  EXPECT_THAT(text(play("not_fire: open")),
              HasSubstr("t.story.yaml:5: unknown key 'not_fire' in '[0].expect[0]', did you mean 'not_fires'?"));
  EXPECT_THAT(text(play("fact: (door (state OPEN)")), HasSubstr("t.story.yaml:5"));
  EXPECT_THAT(text(play("goal: /r/pick, within_s: 1")), HasSubstr("nobody serves /r/pick"));
  EXPECT_THAT(play("no_fact: (dor (state OPEN)), within_s: 1").failures,
              ElementsAre(HasSubstr("did you mean 'door'?")));
  EXPECT_THAT(text(play("no_fact: (door (stat OPEN)), within_s: 1")),
              AllOf(HasSubstr("t.story.yaml:5: "), HasSubstr("'stat'"), HasSubstr("did you mean 'state'?")));
}

TEST_F(Stories, APatternThatNoFactCanMatchIsAMistake) {
  write("door.clp",
        "(deftemplate door (slot state (allowed-symbols OPEN CLOSED)) (slot width (type INTEGER)) (slot x (type "
        "FLOAT)))\n");
  const auto text = [&](const std::string& pattern) {
    const StoryResult result = play("no_fact: '" + pattern + "', within_s: 1");
    return result.bad ? result.bad->text() : "no error";
  };
  for (const char* pattern : {"(door (state OPNE))", "(door (width 1.5))", "(door 7)", "(door (stat OPEN))",
                              "(door (x 1) (x 2))", "(MAIN::door (x OPEN))", "(door (x 1) (width wide))"})
    EXPECT_THAT(text(pattern), HasSubstr("t.story.yaml:5: " + std::string(pattern) + " can match no fact: ["));
  for (const char* pattern : {"(door (state OPEN))", "(door (width 7))", "(door (state ?))", "(anything 7)",
                              "(door (x 3))", "(door (x -3) (width 7.0))", "(MAIN::door (x 3))"})
    EXPECT_EQ(text(pattern), "no error") << pattern;
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
