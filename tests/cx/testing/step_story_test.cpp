// The agent of the league, told step by step: no world, no sleep.

#include "cx/testing/step_story.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/files.h"

namespace cxlab::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

StorySpec rcll_rules() {
  StorySpec spec;
  spec.config = source_dir() / "scenarios/rcll/agent/params/agent.yaml";
  spec.packages = {{"rcll_agent", source_dir() / "scenarios/rcll/agent"}};
  return spec;
}
StorySetup setup() { return {interfaces_dir()}; }

void fail_here(const Story::Where& where, const std::string& what) {
  ADD_FAILURE_AT(where.file_name(), static_cast<int>(where.line())) << what;
}

/// A robot that is to bring a carrier from the shelf to the belt.
void tell_of_a_carrier(Story& story) {
  story.skill("/R1/drive_to", "cxlab_skills/action/DriveTo");
  story.skill("/R1/pick", "cxlab_skills/action/Pick");
  story.given("(machine (name \"C-CS1\") (kind CS) (state PROCESSING) (x 1.0) (y 1.0))");
  story.given("(robot (name \"R1\") (state BUSY))");
  story.given(
      "(job (id 1) (purpose BUFFER) (station \"C-CS1\") (from \"C-CS1-SHELF-LEFT\") (to \"C-CS1-INPUT\") (robot "
      "\"R1\") (step GO-FETCH))");
}

TEST(StepStory, RobotWhosePickFailsTriesAgain) {
  Story story(rcll_rules(), setup(), fail_here);
  tell_of_a_carrier(story);
  story.given("(held-up (job 1) (step PUT))");  // so that it picks, and does not transport
  story.expect_command("R1", "drive_to", "C-CS1-SHELF-LEFT");
  story.skill_succeeds("R1", "drive_to");
  story.expect_command("R1", "pick", "C-CS1-SHELF-LEFT");

  story.skill_fails("R1", "pick", 206);
  story.expect_fact("(job (id 1) (step FETCH) (tries 1))");
  story.expect_command("R1", "pick", "C-CS1-SHELF-LEFT");
  EXPECT_GT(story.now_s(), 1.0);

  story.skill_succeeds("R1", "pick");
  story.expect_command("R1", "drive_to", "C-CS1-INPUT");
  story.expect_no_fact("(job (step FETCH))");
}

TEST(StepStory, SaysWhatCameInstead) {
  std::vector<std::string> failures;
  Story story(rcll_rules(), setup(), [&](const Story::Where& where, const std::string& what) {
    EXPECT_THAT(where.file_name(), HasSubstr("step_story_test.cpp"));
    failures.push_back(what);
  });
  story.set_patience(2);
  tell_of_a_carrier(story);
  story.expect_command("R1", "drive_to", "C-CS2-SHELF-LEFT");
  story.expect_fact("(job (id 1) (step PUT))");
  story.expect_no_fact("(job (id 1))");
  story.expect_no_fact("(jobs (id 1))");
  story.skill_fails("R1", "pick", 206);
  story.given("(job (id many))");
  EXPECT_THAT(failures,
              ElementsAre(HasSubstr("there came /R1/drive_to {target: \"C-CS1-SHELF-LEFT\""),
                          HasSubstr("step is GO-FETCH"), HasSubstr("there is (job (id 1)"),
                          HasSubstr("no template 'jobs'"), HasSubstr("taken no goal"), HasSubstr("(job (id many))")));
}

TEST(StepStory, RulesThatCannotBeUsedFailOnce) {
  std::vector<std::string> failures;
  StorySpec spec;
  spec.rules = {source_dir() / "no-such.clp"};
  Story story(spec, setup(), [&](const Story::Where&, const std::string& what) { failures.push_back(what); });
  story.given("(a)");
  story.expect_command("R1", "pick", "X");
  EXPECT_THAT(failures, ElementsAre(HasSubstr("there is no rule file")));
}

}  // namespace
}  // namespace cxlab::testing
