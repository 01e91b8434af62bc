#include "lab/sweep/suite.h"

#include <gmock/gmock.h>

#include "folder.h"
#include "lab/sweep/row.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class SuiteTest : public FolderTest {
 protected:
  Expected<Suite> load(const std::string& text) const { return Suite::load(write("suite.yaml", text)); }
  std::string error_of(const std::string& text) const {
    const auto suite = load(text);
    return suite ? "no error" : suite.error().text();
  }
};

TEST_F(SuiteTest, HasACellForEachScenarioStrategyAndSeed) {
  const auto suite =
      load("scenarios: [a.yaml, b.yaml]\nseeds: \"3..4\"\nstrategies: {s: [], t: [world.robots=2]}\ntier: timed\n");
  ASSERT_TRUE(suite) << suite.error().text();
  const std::vector<Cell> cells = suite->cells();
  ASSERT_EQ(cells.size(), 8u);
  EXPECT_EQ(cells[0].scenario, "a");
  EXPECT_EQ(cells[0].file, path("a.yaml"));
  EXPECT_THAT(cells[0].overrides, ElementsAre("tier=timed", "seed=3"));
  EXPECT_EQ(cells[3].strategy, "t");
  EXPECT_EQ(cells[3].seed, 4u);
  EXPECT_THAT(cells[3].overrides, ElementsAre("world.robots=2", "tier=timed", "seed=4"));
  EXPECT_EQ(cells[4].scenario, "b");
}

TEST_F(SuiteTest, PlaysEachGameOfAFolderOnceUnlessSeedsAreNamed) {
  write("games/b.yaml", "down: []\n");
  write("games/a.yaml", "down: []\n");
  write("games/notes.txt", "");
  write("s.yaml", "schema: 1\nworld: {kind: rcll}\n");
  auto suite = load("scenarios: [s.yaml]\ngames: games\nstrategies: {s: []}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  std::vector<Cell> cells = suite->cells();
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].game, "a");
  EXPECT_THAT(cells[0].overrides, ElementsAre("world.game='" + path("games/a.yaml").string() + "'", "seed=1"));
  EXPECT_NE(row_name(cells[0]), row_name(cells[1]));
  suite = load("scenarios: [s.yaml]\ngames: games\nseeds: [4, 5]\nstrategies: {s: []}\n");
  cells = suite->cells();
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[2].game, "b");
  EXPECT_EQ(cells[2].seed, 4u);
}

TEST_F(SuiteTest, GamesAreForAWorldThatIsMadeFromThem) {
  write("games/a.yaml", "down: []\n");
  write("s.yaml", "schema: 1\nworld: {kind: turtlesim}\n");
  const auto suite = load("scenarios: [s.yaml]\ngames: games\nstrategies: {s: []}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  EXPECT_THAT(suite->cells().front().overrides, ElementsAre("seed=1"));
  const Status checked = suite->check();
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().text(), HasSubstr("suite.yaml:2: games: the world of "));
  EXPECT_THAT(checked.error().text(), HasSubstr("turtlesim, is not made from files of games"));
}

TEST_F(SuiteTest, AMetricMustNotHaveTheNameOfAnotherKeyOfARow) {
  static constexpr Metric kSeed[]{{.name = "seed", .what = "x", .from = "seed"}};
  static constexpr Metric kLost[]{{.name = "lost", .what = "x", .from = "score.lost"}};
  for (const auto& [metrics, said] :
       {std::pair(std::span<const Metric>(kSeed), "metric 'seed', which is the name of another key of a row"),
        {std::span<const Metric>(kLost), "metric 'lost' from 'score.lost', but its sample"}}) {
    WorldKind own{.name = "own", .what = "nothing", .metrics = metrics};
    Catalogue catalogue = shipped();
    catalogue.worlds.push_back(&own);
    write("s.yaml", "schema: 1\nworld: {kind: own}\n");
    auto suite = load("scenarios: [s.yaml]\nseeds: [1]\nstrategies: {s: []}\n");
    suite->catalogue = &catalogue;
    const Status checked = suite->check();
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().kind, ErrorKind::kBug);
    EXPECT_THAT(checked.error().message, HasSubstr(said));
  }
}

TEST_F(SuiteTest, GamesAreAFolderThatHasSome) {
  write("empty/notes.txt", "");
  EXPECT_THAT(error_of("scenarios: [s.yaml]\ngames: nowhere\nstrategies: {s: []}\n"),
              HasSubstr("suite.yaml:2: games: found 'nowhere', expected a folder"));
  EXPECT_THAT(error_of("scenarios: [s.yaml]\ngames: empty\nstrategies: {s: []}\n"), HasSubstr("NAME.yaml"));
}

TEST_F(SuiteTest, ScenariosOfOneFileNameAreKeptApartByTheirFolders) {
  const auto suite =
      load("scenarios: [x/game.yaml, y/game.yaml, z/y/game.yaml, other.yaml]\nseeds: [1]\nstrategies: {s: }\n");
  ASSERT_TRUE(suite) << suite.error().text();
  std::vector<std::string> names;
  for (const SuiteScenario& s : suite->scenarios) names.push_back(s.name);
  EXPECT_THAT(names, ElementsAre("x/game", HasSubstr("/y/game"), "z/y/game", "other"));
  EXPECT_NE(names[1], names[2]);
}

TEST_F(SuiteTest, NothingMayComeTwice) {
  EXPECT_THAT(error_of("scenarios: [a.yaml]\nseeds: [1, 2, 1]\nstrategies: {s: }\n"), HasSubstr("suite.yaml:2: "));
  EXPECT_THAT(error_of("scenarios: [a.yaml]\nseeds: [1, 2, 1]\nstrategies: {s: }\n"), HasSubstr("found seed 1 twice"));
  EXPECT_THAT(error_of("scenarios: [a.yaml, ./a.yaml]\nseeds: [1]\nstrategies: {s: }\n"),
              HasSubstr("'./a.yaml' twice"));
  EXPECT_THAT(error_of("scenarios: [a.yaml]\nseeds: [1]\nstrategies: {s: , s: }\n"), HasSubstr("'s'"));
}

TEST_F(SuiteTest, WrongSeedsAreErrors) {
  for (const char* seeds :
       {"[-1]", "[x]", "\"-1..-1\"", "\"0..-1\"", "\"..3\"", "\"3\"", "\"9..3\"", "\"0..200000\"", "\"1..2..3\"", "[]"})
    EXPECT_NE(error_of("scenarios: [a.yaml]\nseeds: " + std::string(seeds) + "\nstrategies: {s: }\n"), "no error")
        << seeds;
}

TEST_F(SuiteTest, CheckFindsWhatCannotBePlayed) {
  scenario("game", kQuietRules);
  const auto suite = [&](const std::string& overrides) {
    return *load("scenarios: [game.yaml]\nseeds: [1, 2]\nstrategies: {s: " + overrides + "}\n");
  };
  EXPECT_TRUE(suite("[]").check());
  Status checked = suite("[world.robotz=2]").check();
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().message, HasSubstr("strategy 's': "));
  std::filesystem::remove(path("agent.yaml"));
  checked = suite("[]").check();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().kind, ErrorKind::kInput);
  EXPECT_THAT(checked.error().text(), HasSubstr("agent.yaml"));
}

}  // namespace
}  // namespace cxlab::lab
