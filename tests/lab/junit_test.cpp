// The report of stories that other programs read.

#include <gmock/gmock.h>

#include "lab/stories.h"

namespace cxlab::lab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

PlayedStory played(const std::string& name) {
  PlayedStory story;
  story.played = true;
  story.spec.file = "a.story.yaml";
  story.spec.name = name;
  return story;
}

TEST(JUnit, HasNoCharacterThatXmlLacks) {
  PlayedStory story = played("a\tb\x01");
  story.result.failures = {
      "one\xef\xbf\xbe two\xef\xbf\xbf three\n\x1f"
      "four"};
  story.result.printed = {"\x1b[1mbold"};
  const auto report = to_junit({story}, true);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(*report, HasSubstr("name=\"a&#9;b?\""));
  EXPECT_THAT(*report, HasSubstr("one? two? three\n?four"));
  EXPECT_THAT(*report, HasSubstr("?[1mbold"));
}

TEST(JUnit, CountsAStoryThatCouldNotBePlayedAsAnErrorOnly) {
  std::vector<PlayedStory> stories{played("right"), played("wrong"), played("broken"), played("later")};
  stories[1].result.failures = {"no"};
  stories[2].result.bad = input_error("there is no such file");
  stories[3].played = false;
  const auto report = to_junit(stories);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(*report, HasSubstr("tests=\"3\" failures=\"1\" errors=\"1\""));
  EXPECT_THAT(*report, HasSubstr("<failure type=\"failure\" message=\"no\">"));
  EXPECT_THAT(*report, HasSubstr("<error type=\"error\""));
  EXPECT_THAT(*report, Not(HasSubstr("later")));
}

}  // namespace
}  // namespace cxlab::lab
