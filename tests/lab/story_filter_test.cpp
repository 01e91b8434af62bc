// Which stories the words of `cxlab test -k` mean: those that pytest would take.

#include "lab/story_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::lab {
namespace {

using ::testing::HasSubstr;

constexpr const char* kStory = "door.story.yaml::A bell (not a horn) opens the door";

TEST(StoryFilter, TakesWhatItsWordsSay) {
  struct Row {
    const char* expression;
    bool takes;
  };
  for (const auto& [expression, takes] : std::initializer_list<Row>{
           {"door", true},
           {"DOOR", true},
           {"a", true},
           {"slam", false},
           {"door.story", true},
           {"'the door'", true},
           {"\"bell opens\"", false},
           {"'(not a horn)'", true},
           {"not slam", true},
           {"not door", false},
           {"not not door", true},
           {"bell and door", true},
           {"bell and slam", false},
           {"slam or bell", true},
           {"slam or horn and wind", false},
           {"bell or horn and wind", true},  // `and` binds more than `or`
           {"(bell or horn) and wind", false},
           {"not slam and not wind", true},  // `not` binds most
           {"not (slam or bell)", false},
           {"not(slam)and(bell)", true},
           {"  bell\tand\n door ", true},
           {"'and'", false},
           {"'not'", true},
           {"android or order", false},
       }) {
    const auto filter = StoryFilter::parse(expression);
    ASSERT_TRUE(filter) << expression << ": " << filter.error().text();
    EXPECT_EQ(filter->takes(kStory), takes) << expression;
  }
  EXPECT_TRUE(StoryFilter().takes("anything"));
}

TEST(StoryFilter, SaysWhereAnExpressionIsWrong) {
  struct Row {
    std::string expression, said;
  };
  for (const auto& [expression, said] : std::initializer_list<Row>{
           {"", "found the end at column 1, expected a word, `not` or `(`"},
           {"bell and", "found the end at column 9, expected a word"},
           {"and bell", "found and at column 1, expected a word"},
           {"bell door", "found door at column 6, expected `and` or `or`; words that belong together stand in quotes"},
           {"(bell door)", "found door at column 7, expected `and` or `or`"},
           {"(bell", "found the end at column 6, expected `and`, `or` or `)`"},
           {"bell)", "found ) at column 5, expected `and`, `or` or the end"},
           {"()", "found ) at column 2, expected a word"},
           {"'bell", "found a quote without its end at column 1"},
           {"''", "found '' at column 1, expected a word"},
           {"not", "found the end at column 4"},
           {std::string(100000, '('), "more than 200 parentheses"},
           {std::string(400, ' ') + "bell not", "at column 406, expected `and`"},
       }) {
    const auto filter = StoryFilter::parse(expression);
    ASSERT_FALSE(filter) << expression;
    EXPECT_EQ(filter.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(filter.error().text(), HasSubstr(said));
  }
}

}  // namespace
}  // namespace cxlab::lab
