#include "lab/sweep/suite.h"

#include <gmock/gmock.h>

#include "folder.h"
#include "lab/sweep/row.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"
#include "scenarios/share.h"

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
  EXPECT_EQ(suite->size(), 8u);
  for (std::size_t number = 1; number <= 8; ++number) {
    const std::vector<Cell> alone = suite->cells(number, number);
    ASSERT_EQ(alone.size(), 1u);
    EXPECT_EQ(alone[0].number, number);
    EXPECT_EQ(row_name(alone[0]), row_name(cells[number - 1]));
  }
  EXPECT_EQ(suite->cells(3, 5).back().scenario, "b");
}

TEST_F(SuiteTest, AGridIsAStrategyForEachCombination) {
  const auto suite = load(
      "scenarios: [a.yaml]\nseeds: [7]\nstrategies: {plain: []}\n"
      "grid: {world.robots: [3, 1], planner.patience: [1000, \"5\"]}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  std::vector<std::string> names;
  for (const Strategy& strategy : suite->strategies) names.push_back(strategy.name);
  EXPECT_THAT(names, ElementsAre("plain", "robots=3 patience=1000", "robots=3 patience=5", "robots=1 patience=1000",
                                 "robots=1 patience=5"));
  const std::vector<Cell> cells = suite->cells();
  ASSERT_EQ(cells.size(), 5u);
  EXPECT_TRUE(cells[0].parameters.empty());
  EXPECT_THAT(cells[2].overrides, ElementsAre("world.robots=3", "planner.patience=\"5\"", "seed=7"));
  EXPECT_THAT(cells[2].parameters, ElementsAre(Parameter{"robots", "3"}, Parameter{"patience", "5"}));
  EXPECT_EQ(cells[2].number, 3u);
}

TEST_F(SuiteTest, NamesOfParametersAreAsLongAsTheyMustBe) {
  const auto suite =
      load("scenarios: [a.yaml]\nseeds: [7]\ngrid: {x.robots: [3], y.robots: [1], y.rob: [2], z: [0]}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  ASSERT_EQ(suite->strategies.size(), 1u);
  EXPECT_EQ(suite->strategies[0].name, "x.robots=3 y.robots=1 rob=2 z=0");
}

TEST_F(SuiteTest, AStrategyHasItsOwnGridOnTopOfItsOverrides) {
  const auto suite = load(
      "scenarios: [a.yaml]\nseeds: [7]\ntags: [night]\nstrategies:\n  base: {set: [x=1], tags: [old, night]}\n"
      "  fast: {set: [x=2], grid: {mode: {one: [y=1, z=1], two: []}, w: [a]}, tags: [new]}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  const std::vector<Cell> cells = suite->cells();
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(cells[0].strategy, "base");
  EXPECT_THAT(cells[0].tags, ElementsAre("night", "old"));
  EXPECT_EQ(cells[1].strategy, "fast mode=one w=a");
  EXPECT_THAT(cells[1].overrides, ElementsAre("x=2", "y=1", "z=1", "w=a", "seed=7"));
  EXPECT_THAT(cells[2].overrides, ElementsAre("x=2", "w=a", "seed=7"));
  EXPECT_THAT(cells[2].tags, ElementsAre("night", "new"));
}

TEST_F(SuiteTest, WrongGridsAreErrors) {
  const auto error = [this](const std::string& grid) {
    return error_of("scenarios: [a.yaml]\nseeds: [1]\nstrategies: {robots=2: []}\ngrid: " + grid + "\n");
  };
  EXPECT_THAT(error("{}"), HasSubstr("suite.yaml:4: grid: expected parameters, each with its values"));
  EXPECT_THAT(error("[1]"), HasSubstr("expected a map"));
  EXPECT_THAT(error("{a.b: []}"), HasSubstr("grid.a.b: expected at least one value of a.b"));
  EXPECT_THAT(error("{a.b: 3}"), HasSubstr("expected a list"));
  EXPECT_THAT(error("{a.b: [1, 2, 1]}"), HasSubstr("found the value '1' twice"));
  EXPECT_THAT(error("{a.b: [{c: 1}]}"), HasSubstr("other values need a label: a.b: {LABEL: [PATH=VALUE]}"));
  EXPECT_THAT(error("{a.b: [x/y]}"), HasSubstr("without '/'"));
  EXPECT_THAT(error("{a.robots: [2]}"), HasSubstr("found strategy 'robots=2' twice"));
  EXPECT_THAT(error("{a: {x: y}}"), HasSubstr("expected a list"));
  EXPECT_THAT(error("{seed: [5, 6]}"), HasSubstr("sets seed=5, but the suite has `seeds`, which wins"));
  std::string many = "{";
  for (int i = 0; i < 14; ++i) many += "p" + std::to_string(i) + ": [1, 2], ";
  EXPECT_THAT(error(many + "q: [1]}"), HasSubstr("more than 10000 combinations"));
  EXPECT_THAT(error_of("scenarios: [a.yaml]\nseeds: [1]\nstrategies: {s: {sett: []}}\n"),
              HasSubstr("did you mean 'set'"));
}

TEST_F(SuiteTest, TheCommandOfACellPlaysItAgainFromAnyFolder) {
  write("games/g 1.yaml", "down: []\n");
  write("s.yaml", "schema: 1\nworld: {kind: rcll}\n");
  const auto suite =
      load("scenarios: [s.yaml]\ngames: games\nseeds: [4]\ntier: timed\nstrategies: {s: [world.robots=2]}\n");
  ASSERT_TRUE(suite) << suite.error().text();
  const std::string quote = R"('\'')";  // a single quote, for a shell
  EXPECT_EQ(command_of(suite->cells().front()), "cxlab run " + path("s.yaml").string() +
                                                    " --set world.robots=2 --set tier=timed --set 'world.game=" +
                                                    quote + path("games/g 1.yaml").string() + quote + "' --seed 4");
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

TEST_F(SuiteTest, SeedsOfAListHave64Bits) {
  const auto seeds = [this](const std::string& list) {
    return load("scenarios: [a.yaml]\nstrategies: {s: []}\nseeds: " + list + "\n");
  };
  EXPECT_THAT(seeds("[0, 9223372036854775808, 18446744073709551615]")->seeds,
              ElementsAre(0, 9223372036854775808U, 18446744073709551615U));
  for (const char* wrong : {"[-1]", "[18446744073709551616]", "[1.5]", "[one]", "[[1]]"})
    EXPECT_THAT(seeds(wrong).error().text(),
                HasSubstr("expected a seed, which is an integer from 0 to 18446744073709551615"))
        << wrong;
}

TEST_F(SuiteTest, AScenarioThatIsNotThereNamesTheNearest) {
  write("folder/x.txt", "");
  const std::string rest = "]\nseeds: [1]\nstrategies: {s: []}\n";
  for (const auto& [scenario, said] : {std::pair("rcll/gmae", "did you mean 'rcll/game'?"),
                                       {"qwertzuiop", "cxlab list scenarios shows the names"},
                                       {"folder", "folder: is a folder, expected a file"}}) {
    const auto suite = load("# a suite\nscenarios: [" + std::string(scenario) + rest);
    const Status checked = suite->check();
    ASSERT_FALSE(checked) << scenario;
    EXPECT_THAT(checked.error().text(), testing::AllOf(HasSubstr("suite.yaml:2: "), HasSubstr(said)));
  }
  EXPECT_EQ(load("scenarios: [rcll/game" + rest)->scenarios[0].file, own_scenario("rcll/game")->string());
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

TEST_F(SuiteTest, SeedsAreNumbersAndRanges) {
  for (const auto& [text, seeds] : std::vector<std::pair<std::string, std::vector<std::uint64_t>>>{
           {"3", {3}}, {"\"3..5\"", {3, 4, 5}}, {"\"7,3..4, 1\"", {7, 3, 4, 1}}, {"[7, 3]", {7, 3}}}) {
    const auto suite = load("scenarios: [a.yaml]\nseeds: " + text + "\nstrategies: {s: }\n");
    ASSERT_TRUE(suite) << text;
    EXPECT_EQ(suite->seeds, seeds) << text;
  }
  EXPECT_THAT(error_of("scenarios: [a.yaml]\nseeds: \"1..600000,700000..1200000\"\nstrategies: {s: }\n"),
              HasSubstr("seeds: found more seeds, expected at most 1000000"));
}

TEST_F(SuiteTest, WrongSeedsAreErrors) {
  for (const char* seeds : {"[-1]", "[x]", "\"-1..-1\"", "\"0..-1\"", "\"..3\"", "\"9..3\"", "\"1,\"", "\",1\"",
                            "\"1..3,2\"", "\"0..2000000\"", "\"1..2..3\"", "[]"})
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
  scenario("game", "(defrule wrong (time ?) => (assert (x))\n");
  checked = suite("[]").check();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().kind, ErrorKind::kInput);
  EXPECT_THAT(checked.error().message, HasSubstr("strategy 's': "));
  EXPECT_THAT(checked.error().message, HasSubstr(".clp:1: "));
  scenario("game", "(deffacts f (go))(defrule wrong (go) => (+ 1 (nth$ 1 (create$ one))))\n");
  EXPECT_TRUE(suite("[]").check()) << "a rule that fails is told by its games";
  std::filesystem::remove(path("agent.yaml"));
  checked = suite("[]").check();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().kind, ErrorKind::kInput);
  EXPECT_THAT(checked.error().text(), HasSubstr("agent.yaml"));
}

}  // namespace
}  // namespace cxlab::lab
