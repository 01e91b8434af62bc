#include "lab/sweep/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lab/statistics/statistics.h"
#include "lab/table_text.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

const Summary& of(const TableLine& line, std::string_view metric) {
  static const Summary kNone;
  const auto found = std::ranges::find(line.metrics, metric, [](const auto& one) { return one.metric->name; });
  return found == line.metrics.end() ? kNone : found->summary;
}

Row row(const std::string& strategy, std::uint64_t seed, double points, const std::string& status = "completed",
        const std::string& scenario = "game") {
  Row out;
  out.cell.scenario = scenario;
  out.cell.strategy = strategy;
  out.cell.seed = seed;
  out.status = status;
  out.world = "rcll";
  out.compared = "points";
  out.figures = {{"points", points}, {"deliveries", 1.0}, {"busy", std::nullopt}, {"real_time_factor", 100.4}};
  return out;
}

TEST(Summarize, GivesMeanAndStudentsInterval) {
  const Summary s = summarize({10, 12, 14, 16});
  EXPECT_EQ(s.n, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 13);
  EXPECT_EQ(s.min, 10);
  EXPECT_EQ(s.max, 16);
  EXPECT_NEAR(s.half, 3.18244630528 * std::sqrt(20.0 / 3 / 4), 1e-9);
}

TEST(Summarize, HasNoIntervalForFewerThanTwoValues) {
  EXPECT_TRUE(std::isnan(summarize({7}).half));
  EXPECT_TRUE(std::isnan(summarize({}).half));
  EXPECT_EQ(summarize({}).n, 0u);
}

TEST(Summarize, GivesTheMeanThatOtherTablesGive) {
  std::vector<double> values;
  for (int i = 0; i < 20; ++i) values.push_back(i % 2 ? 448.4 : 448.5);
  EXPECT_EQ(summarize(values).mean, statistics::mean(values)) << "to the last bit, so that both round one way";
}

TEST(TableOf, KeepsTheOrderOfScenariosAndStrategies) {
  const auto table = table_of({row("b", 1, 0), row("b", 2, 0), row("a", 1, 0), row("b", 1, 0, "completed", "other")});
  ASSERT_EQ(table.size(), 3u);
  EXPECT_EQ(table[0].strategy, "b");
  EXPECT_EQ(table[0].episodes, 2u);
  EXPECT_EQ(table[1].strategy, "a");
  EXPECT_EQ(table[2].scenario, "other");
}

TEST(TableOf, ComparesWithTheFirstStrategySeedBySeed) {
  const auto table =
      table_of({row("first", 1, 100), row("first", 2, 200), row("second", 1, 103), row("second", 2, 205)});
  EXPECT_EQ(table[0].against_first.n, 0u);
  EXPECT_EQ(table[1].against_first.n, 2u);
  EXPECT_DOUBLE_EQ(table[1].against_first.mean, 4);
  EXPECT_EQ(table[1].against_first.min, 3);
}

TEST(TableOf, ComparesGameByGame) {
  std::vector<Row> rows{row("first", 1, 100), row("first", 1, 200), row("second", 1, 205), row("second", 1, 103)};
  rows[0].cell.game = rows[3].cell.game = "a";
  rows[1].cell.game = rows[2].cell.game = "b";
  const auto table = table_of(rows);
  EXPECT_DOUBLE_EQ(table[1].against_first.mean, 4);
  EXPECT_EQ(table[1].against_first.max, 5);
}

TEST(TableOf, ComparesWithinAScenario) {
  const auto table = table_of({row("first", 1, 100), row("second", 1, 101), row("first", 1, 10, "completed", "other"),
                               row("second", 1, 12, "completed", "other")});
  EXPECT_EQ(table[3].against_first.mean, 2);
}

TEST(TableOf, LeavesOutEpisodesThatDidNotComplete) {
  Row unexpected = row("first", 3, 1000);
  unexpected.exit_code = 1;
  const auto table = table_of(
      {row("first", 1, 100, "failed"), row("first", 2, 200), unexpected, row("second", 1, 103), row("second", 2, 205)});
  EXPECT_EQ(table[0].episodes, 3u);
  EXPECT_EQ(table[0].completed, 1u);
  EXPECT_EQ(of(table[0], "points").n, 1u);
  EXPECT_EQ(of(table[0], "points").mean, 200);
  EXPECT_EQ(of(table[0], "busy").n, 0u) << "it has no value";
  EXPECT_EQ(table[1].against_first.n, 1u) << "seed 1 has no partner";
}

TEST(TableText, ShowsAStrategyOnALine) {
  const std::string text = to_text(table_of({row("first", 1, 100), row("first", 2, 102), row("second", 1, 90)}));
  EXPECT_THAT(text, HasSubstr("game                 first                  2/2    101.0 +- 12.7         100    102"));
  EXPECT_THAT(text, HasSubstr("deliveries     busy           x real time    points against the first strategy\n"));
  EXPECT_THAT(text, HasSubstr("100    102  1.0 +- 0.0     -              100 +- 0       -\n"));
  EXPECT_THAT(text, HasSubstr(" 90     90  1.0            -              100            -10.0\n"));
}

TEST(TableText, CountsTheGamesOfTheSuite) {
  std::vector<TableLine> table = table_of({row("first", 1, 100), row("first", 2, 102, "failed")});
  EXPECT_THAT(to_text(table), HasSubstr("  1/2 "));
  table.front().planned = 30;
  EXPECT_THAT(to_text(table), HasSubstr("  1/30 "));
}

TEST(TableText, KeepsItsColumnsBesideLongNames) {
  const std::string text = to_text(table_of({row("first", 1, 100), row("robots=2 patience=20000", 1, 90)}));
  const std::size_t second = text.find('\n') + 1, third = text.find('\n', second) + 1;
  EXPECT_EQ(text.find("done"), text.find("1/1", second) - second + 1) << text;
  EXPECT_EQ(text.find("done"), text.find("1/1", third) - third + 1) << text;
}

/// A world with one metric, of which less is better, and one without any.
constexpr Metric kCost[]{
    {.name = "cost", .what = "what it cost", .from = "cost", .more_is_better = false, .title = "cost", .digits = 0}};
constexpr WorldKind kShop{.name = "shop", .what = "a shop", .metrics = kCost};

Row shop(const std::string& strategy, std::uint64_t seed, double cost) {
  Row out = row(strategy, seed, 0, "completed", "shop");
  out.world = "shop";
  out.compared = "cost";
  out.figures = {{"cost", cost}, {"real_time_factor", 5.0}};
  return out;
}

TEST(TableOf, ComparesWhatTheWorldDeclaresFirst) {
  Catalogue catalogue = shipped();
  catalogue.worlds.push_back(&kShop);
  Row plain = row("first", 1, 0, "completed", "plain");
  plain.world = "none";
  plain.compared = "";
  plain.figures = {{"real_time_factor", 7.0}};
  const auto table = table_of({row("first", 1, 100), shop("first", 1, 30), shop("second", 1, 26), plain}, catalogue);
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(of(table[2], "cost").mean, 26);
  EXPECT_EQ(of(table[2], "points").n, 0u);
  EXPECT_EQ(table[2].against_first.mean, -4);
  EXPECT_THAT(to_text(table),
              testing::AllOf(HasSubstr("cost                  min    max  x real time    cost against the first "
                                       "strategy (less is better)\n"),
                             HasSubstr("26                     26     26  5              -4\n"),
                             HasSubstr("\n\nscenario             strategy                done  x real time\n"
                                       "plain                first                  1/1    7\n")));
  EXPECT_THAT(to_json(table),
              testing::AllOf(HasSubstr("\"cost_against_first\": {\n      \"n\": 1"),
                             HasSubstr("\"more_is_better\": false"), HasSubstr("\"points_against_first\"")));
}

TEST(TableOf, ALineOfCrashedEpisodesStandsUnderTheHeaderOfTheOthers) {
  Row crashed = row("second", 1, 0, "crashed");
  crashed.world = crashed.compared = "";
  crashed.figures.clear();
  EXPECT_THAT(to_text(table_of({row("first", 1, 100), crashed})),
              testing::EndsWith("game                 second                 0/1\n"));
}

TEST(TableText, HasNoFiguresOfAStrategyWithoutACompleteEpisode) {
  Row broken = row("broken", 1, 100);
  broken.status = "failed";
  const auto table = table_of({broken});
  EXPECT_THAT(to_text(table), testing::ContainsRegex("broken +0/1 +- +- +- +- +- +- +-\n"));
  EXPECT_THAT(to_json(table), testing::AllOf(HasSubstr("\"min\": null"), HasSubstr("\"mean\": null")));
}

TEST(TableText, SaysBelowTheTableWhatEpisodesHaveToSay) {
  Row misspelt = row("misspelt", 1, 100), again = row("misspelt", 2, 90), other = row("misspelt", 3, 95);
  misspelt.errors = {"found 'x'", "found 'y'"};
  again.errors = {"found 'x'", "found 'x'"};
  const auto table = table_of({row("first", 1, 100), misspelt, again, other});
  EXPECT_THAT(to_text(table), testing::EndsWith("\nerrors and warnings:\n"
                                                "game, misspelt, 2 of 3 episodes: found 'x'\n"
                                                "game, misspelt, 1 of 3 episodes: found 'y'\n\n"));
  EXPECT_THAT(to_json(table), HasSubstr("\"text\": \"found 'x'\",\n        \"episodes\": 2"));
  EXPECT_THAT(to_text(table_of({row("first", 1, 100)})), testing::Not(HasSubstr("errors")));
}

TEST(TableText, NamesTheFirstOfManyErrors) {
  Row bad = row("bad", 1, 100);
  for (char c = 'a'; c < 'h'; ++c) bad.errors.emplace_back(1, c);
  EXPECT_THAT(to_text(table_of({bad})),
              HasSubstr("game, bad, 1 of 1 episodes: e\ngame, bad: 2 more, in rows/*.json\n"));
}

TEST(LinesOfATable, UseTheWholeWidthButNoMore) {
  using Kind = Column::Kind;
  std::string words = "a";  // they can be broken behind each second character
  for (int i = 0; i < 300; ++i) words += " a";
  const Column number{.key = "n", .title = "n", .kind = Kind::kNumber},
      why{.key = "why", .title = "why", .kind = Kind::kText},
      other{.key = "other", .title = "other", .kind = Kind::kText};
  const Table two{"", "", {number, why}, {{TableCell(12345), TableCell(words)}}};
  const Table three{"", "", {number, other, why}, {{TableCell(12345), TableCell(words), TableCell(words)}}};
  const auto longest_line = [](const std::string& text) {
    std::size_t most = 0;
    for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
      most = std::max(most, end - begin);
    return most;
  };
  constexpr std::size_t kBefore = 5 + 2;  // the number and the blanks behind it
  for (std::size_t width = kBefore + 37; width < 120; ++width) {
    const std::size_t rest = width - kBefore;
    EXPECT_EQ(longest_line(table_text(two, width)), kBefore + rest - (rest % 2 == 0 ? 1U : 0U)) << width;
  }
  for (std::size_t width = 64; width < 120; ++width) {
    EXPECT_LE(longest_line(table_text(three, width)), width);
    EXPECT_GE(longest_line(table_text(three, width)), width - 1);
  }
}

TEST(TableJson, WritesAMissingIntervalAsNull) {
  EXPECT_THAT(to_json(table_of({row("first", 1, 100)})), HasSubstr("\"interval_95\": null"));
  const std::string two = to_json(table_of({row("first", 1, 100), row("first", 2, 102)}));
  EXPECT_THAT(two, testing::AllOf(HasSubstr("88.2937"), HasSubstr("113.706")));  // 101 +- 12.7062
}

}  // namespace
}  // namespace cxlab::lab
