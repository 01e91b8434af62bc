#include "scenarios/rl/policy.h"

#include <gmock/gmock.h>

#include "scenarios/rl/trainer.h"

namespace cxlab::rl {
namespace {

using testing::HasSubstr;

TEST(QTableTest, LearnsByTheRuleOfWatkins) {
  QTable table({.learning_rate = 0.5, .gamma = 0.9});
  table.learn({"s", "a", 10, "end", {}});
  EXPECT_DOUBLE_EQ(table.value("s", "a"), 5);
  table.learn({"s", "b", -4, "end", {}});
  EXPECT_DOUBLE_EQ(table.value("s", "b"), -2);
  // 0 + 0.5 * (-1 + 0.9 * max(5, -2) - 0)
  table.learn({"r", "go", -1, "s", {"a", "b"}});
  EXPECT_DOUBLE_EQ(table.value("r", "go"), 1.75);
  // Where all that comes next is worse than nothing, that counts.
  table.learn({"q", "go", 0, "s", {"b"}});
  EXPECT_DOUBLE_EQ(table.value("q", "go"), -0.9);
  EXPECT_EQ(table.states(), 3u);
}

TEST(QTableTest, ChoosesTheBestOrByChance) {
  QTable table({});
  RandomStream chance(1, "test");
  table.learn({"s", "b", 1, "", {}});
  EXPECT_EQ(table.choose("s", {"a", "b", "c"}, 0, chance), 1u);
  EXPECT_EQ(table.choose("unknown", {"a", "b", "c"}, 0, chance), 0u) << "the first of equal ones";
  int first = 0;
  for (int i = 0; i < 3000; ++i) first += table.choose("s", {"a", "b", "c"}, 1, chance) == 0 ? 1 : 0;
  EXPECT_NEAR(first, 1000, 110);
}

TEST(QTableTest, ExploresLessInEachEpisode) {
  const QTable table({.exploration = 0.4, .exploration_decay = 0.5});
  EXPECT_DOUBLE_EQ(table.exploration(0), 0.4);
  EXPECT_DOUBLE_EQ(table.exploration(2), 0.1);
}

TEST(QTableTest, ComesBackFromItsText) {
  QTable table({});
  table.learn({"on(a#b)", "move(a#table)", 0.1, "", {}});
  const auto again = QTable::from_text(table.to_text(), {}, "model.json");
  ASSERT_TRUE(again);
  EXPECT_EQ(again->to_text(), table.to_text());
  for (const char* wrong : {"", "[]", "{\"s\": 1}", "{\"s\": {\"a\": \"x\"}}", "{\"s\": {\"a\": 1}"}) {
    const auto refused = QTable::from_text(wrong, {}, "model.json");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_THAT(refused.error().text(), HasSubstr("model.json: not a table of values"));
  }
}

TEST(GroundedTest, IsNameAndParameters) {
  EXPECT_EQ(grounded("on", {"a", "b"}), "on(a#b)");
  EXPECT_EQ(grounded("no-op", {}), "no-op()");
}

}  // namespace
}  // namespace cxlab::rl
