// Plots and pages of sweeps, from rows made by hand; the index that they are read from.

#include "lab/sweep/sweep_page.h"

#include <gmock/gmock.h>

#include <chrono>
#include <regex>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "folder.h"
#include "lab/statistics/statistics.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/plots.h"
#include "lab/sweep/score_tables.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr Metric kMetrics[]{{.name = "apples", .what = "apples picked", .from = "a", .title = "apples"},
                            {.name = "red", .what = "red ones", .from = "r", .part_of = "apples"},
                            {.name = "rotten", .what = "rotten ones", .from = "b", .part_of = "apples"}};
constexpr WorldKind kOrchard{.name = "orchard", .what = "trees", .metrics = kMetrics};

const Catalogue& catalogue() {
  static const Catalogue made{{&kOrchard}, {}};
  return made;
}

Row row(const std::string& strategy, std::uint64_t seed, double red, double rotten) {
  Row out;
  out.cell.scenario = "field";
  out.cell.strategy = strategy;
  out.cell.seed = seed;
  out.cell.file = "/where/field.yaml";
  out.cell.overrides = {"a=it's", "seed=" + std::to_string(seed)};
  out.status = "completed";
  out.world = "orchard";
  out.compared = "apples";
  out.journal_hash = "00";
  out.figures = {{"apples", red + rotten}, {"red", red}, {"rotten", rotten}};
  return out;
}

/// Ten games of two strategies; `second` makes 10 more in each but the last, which was not completed.
std::vector<Row> orchard() {
  std::vector<Row> out;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    out.push_back(row("first", seed, 50.0 + static_cast<double>(seed), -10));
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    out.push_back(row("second", seed, 60.0 + static_cast<double>(seed % 3) + static_cast<double>(seed), -10));
  out.back().status = "failed";
  out.back().exit_code = 4;
  out.back().errors = {"the <ladder> broke"};
  out.front().warnings = {"rain & wind"};
  for (std::size_t i = 0; i < out.size(); ++i) out[i].cell.number = i + 1;
  return out;
}

class SweepPageTest : public FolderTest {
 protected:
  Suite suite() const {
    Suite out;
    out.catalogue = &catalogue();
    return out;
  }
  SweepRecord record(const std::vector<Row>& rows) const {
    std::filesystem::create_directories(path("sweep"));
    EXPECT_TRUE(write_index(rows, suite(), path("sweep/runs.sqlite")));
    auto read = read_sweep(path("sweep"), catalogue());
    EXPECT_TRUE(read) << read.error().text();
    return *std::move(read);
  }
  std::string page(const SweepRecord& sweep, const SweepRecord* before = nullptr) const {
    const auto made = sweep_page(sweep, before, {.file = path("sweep/index.html")}, catalogue());
    return made ? *made : "error " + made.error().text();
  }
};

std::vector<std::string> found(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> out;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) out.push_back((*it)[1]);
  return out;
}

TEST_F(SweepPageTest, TheIndexGivesBackItsRows) {
  const std::vector<Row> rows = orchard();
  const SweepRecord read = record(rows);
  ASSERT_EQ(read.rows.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row &was = rows[i], &is = read.rows[i].row;
    EXPECT_EQ(is.cell.number, was.cell.number);
    EXPECT_EQ(is.cell.strategy, was.cell.strategy);
    EXPECT_EQ(is.cell.seed, was.cell.seed);
    EXPECT_EQ(is.counts(), was.counts());
    EXPECT_EQ(is.compared, was.compared);
    EXPECT_EQ(is.errors, was.errors);
    EXPECT_EQ(is.warnings, was.warnings);
    for (const Figure& figure : was.figures) EXPECT_EQ(is.figure(figure.metric), figure.value);
  }
  EXPECT_THAT(words_of_shell(read.rows.front().command),
              ElementsAre("cxlab", "run", "/where/field.yaml", "--set", "a=it's", "--seed", "1"));
}

TEST_F(SweepPageTest, WhatIsNoIndexIsAnError) {
  write("sweep/runs.sqlite",
        "no database, but long enough to be looked at as one, which has a head of 100 bytes ......");
  EXPECT_THAT(read_index(path("sweep/runs.sqlite")).error().text(), HasSubstr("is no index of a sweep"));
  write("empty/runs.sqlite", "");
  EXPECT_THAT(read_index(path("empty/runs.sqlite")).error().text(), HasSubstr("version 0, expected 1"));
}

TEST_F(SweepPageTest, WordsOfAShellAreTakenApartAsTheyWerePutTogether) {
  std::string command;
  const std::vector<std::string> words{"plain", "two words", "it's", "", "a\\b", "\"q\" $x `y`", "''"};
  for (const std::string& word : words) command += (command.empty() ? "" : " ") + shell_word(word);
  EXPECT_EQ(words_of_shell(command), words);
}

TEST_F(SweepPageTest, ThePageShowsScoresDifferencesGamesAndFailures) {
  const SweepRecord sweep = record(orchard());
  std::filesystem::create_directories(path("sweep/games/" + std::filesystem::path(sweep.rows[0].file).stem().string()));
  write("sweep/games/" + std::filesystem::path(sweep.rows[0].file).stem().string() + "/index.html", "");
  const std::string text = page(sweep);
  EXPECT_THAT(text, HasSubstr("40, of which 39 were completed"));
  EXPECT_THAT(
      found(text, "<h3>([^<]*)"),
      ElementsAre("Scores", "Differences in the same games", "How many games reach a figure", "What it is made of",
                  "Shares in the same games", "Several figures side by side", "Worst and best games"));
  EXPECT_THAT(found(text, "data-name=\"([^\"]*)"),
              ElementsAre("apples-scores.svg", "apples-differences.svg", "apples-profile.svg", "apples-parts.svg",
                          "apples-shares.svg"));
  // The mean difference of the 19 pairs: 10 and 1, 2 or 0.
  EXPECT_THAT(text, HasSubstr("data-order=\"11.0\">+11.0<"));
  // 3 worst and 3 best games of each strategy, the worst first; one has a page. No game that was not completed.
  EXPECT_THAT(found(text, "<td>(?:worst|best)<td data-order=\"(\\d+)\""),
              ElementsAre("1", "2", "3", "20", "19", "18", "1", "3", "2", "19", "17", "18"));
  EXPECT_THAT(
      found(text, "<a href=\"(games&#x2f;[^\"]*)"),
      ElementsAre("games&#x2f;" + std::filesystem::path(sweep.rows[0].file).stem().string() + "&#x2f;index.html"));
  EXPECT_THAT(text, HasSubstr("failed, exit 4: the &lt;ladder&gt; broke"));
  // Games that were not completed, and those with a warning, are played again into their folders, too.
  const auto commands = found(text, "<code>(cxlab run [^<]*)");
  EXPECT_EQ(commands.size(), 12u + 2u);
  for (const std::string& command : commands) EXPECT_THAT(command, HasSubstr(" --out "));
  EXPECT_THAT(text, HasSubstr("rain &amp; wind"));
  EXPECT_THAT(text, HasSubstr("worse, because 1 game was not completed that the other side completed"));
}

TEST_F(SweepPageTest, ThePageLoadsNothing) {
  const std::string text = page(record(orchard()));
  EXPECT_THAT(text, HasSubstr("default-src 'none'"));
  EXPECT_THAT(found(text, "((?:src|href)=\"(?!#)[^\"]*)"), ElementsAre());
  const auto addresses = found(text, "(https?://[^\"< ]*)");
  for (const std::string& address : addresses) EXPECT_EQ(address, "http://www.w3.org/2000/svg");
}

TEST_F(SweepPageTest, TwoSweepsAreComparedInTheSameGames) {
  std::vector<Row> before = orchard(), now = orchard();
  for (Row& one : now) one.figures[0].value = *one.figures[0].value - 5;
  const SweepRecord sweep = record(now);
  const SweepRecord earlier{"runs/before", record(before).rows};
  const std::string text = page(sweep, &earlier);
  EXPECT_THAT(text, HasSubstr("Compared with runs&#x2f;before: <span class=\"worse\">worse</span>"));
  EXPECT_THAT(text, HasSubstr("data-order=\"-5.0\">-5.0<"));
  EXPECT_THAT(page(sweep), Not(HasSubstr("Compared with")));
}

TEST_F(SweepPageTest, ASweepWithoutACompletedGameHasAPage) {
  std::vector<Row> rows = orchard();
  for (Row& one : rows) {
    one.status = "crashed";
    one.exit_code = 139;
    one.errors = {"killed by SIGSEGV"};
  }
  const std::string text = page(record(rows));
  EXPECT_THAT(text, HasSubstr("No completed game"));
  EXPECT_THAT(
      text,
      HasSubstr("<td class=\"number\" data-order=\"20\">20<td class=\"long\">crashed, exit 139: killed by SIGSEGV"));
}

TEST_F(SweepPageTest, WrongNamesAreErrors) {
  const SweepRecord sweep = record(orchard());
  const auto error = [&](const SweepPageOptions& options) {
    const auto made = sweep_page(sweep, nullptr, options, catalogue());
    return made ? "none" : made.error().text();
  };
  EXPECT_THAT(error({.metric = "appels"}),
              HasSubstr("no row has a metric 'appels'; there are apples, red, rotten; did you mean 'apples'?"));
  EXPECT_THAT(error({.against = "thrid"}), HasSubstr("there is no strategy 'thrid'"));
}

TEST(Plots, PartsAddUpToTheMean) {
  const auto table = part_table(orchard(), "", catalogue());
  ASSERT_TRUE(table) << table.error().text();
  for (const auto& line : table->rows) {
    std::vector<double> numbers;
    for (const TableCell& cell : line)
      if (const auto* value = std::get_if<double>(&cell.value)) numbers.push_back(*value);
    ASSERT_EQ(numbers.size(), 3u);
    EXPECT_NEAR(numbers[0], numbers[1] + numbers[2], 1e-9);
  }
  const auto plot = parts_plot(orchard(), "", catalogue());
  ASSERT_TRUE(plot);
  EXPECT_THAT(found(*plot, "<title>([^<]*)"), ElementsAre("first, red ones: 60.5", "first, rotten ones: -10.0",
                                                          "second, red ones: 71.0", "second, rotten ones: -10.0"));
  for (const Error& error :
       {parts_plot(orchard(), "red", catalogue()).error(), part_table(orchard(), "red", catalogue()).error()})
    EXPECT_THAT(error.message, HasSubstr("red has no parts; expected a metric that has some: apples"));
}

TEST(Plots, ProfilesEndAtNoGame) {
  const auto plot = profile_plot(orchard(), "", catalogue());
  ASSERT_TRUE(plot);
  // Each of the 20 (19) games is a step down, from all games to none, which is the line below.
  for (const std::string& steps : found(*plot, "d=\"([^\"]*)")) {
    const auto heights = found(steps, "V([0-9.]+)");
    EXPECT_TRUE(heights.size() == 20 || heights.size() == 19) << steps;
    EXPECT_EQ(std::stod(heights.back()), 264);
    EXPECT_TRUE(std::ranges::is_sorted(heights, {}, [](const std::string& y) { return std::stod(y); }));
  }
}

TEST(Plots, ProfilesNameBothAxes) {
  const auto plot = profile_plot(orchard(), "", catalogue());
  ASSERT_TRUE(plot);
  EXPECT_THAT(found(*plot, "<text class=\"caption\"[^>]*>([^<]*)"),
              ElementsAre("apples of a game", "games with at least so much"));
}

TEST(Plots, AnEqualProfileDoesNotHideTheFirst) {
  std::vector<Row> rows;
  for (const char* const strategy : {"first", "twin"})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) rows.push_back(row(strategy, seed, static_cast<double>(seed), 0));
  const auto plot = profile_plot(rows, "", catalogue());
  ASSERT_TRUE(plot);
  EXPECT_THAT(found(*plot, "<path class=\"series[^>]*(stroke-dasharray=\"7 9\")"), testing::SizeIs(1));
  EXPECT_THAT(*plot, HasSubstr(">twin (as first)<"));
}

TEST(Plots, APartThatNoGameHasIsLeftOutAndNoOther) {
  for (const char* const lacking : {"red", "rotten"}) {
    std::vector<Row> rows = orchard();
    for (Row& one : rows) std::erase_if(one.figures, [&](const auto& figure) { return figure.metric == lacking; });
    const auto table = part_table(rows, "", catalogue());
    ASSERT_TRUE(table) << table.error().text();
    std::vector<std::string> columns;
    for (const Column& column : table->columns) columns.push_back(column.key);
    EXPECT_THAT(columns, ElementsAre("scenario", "strategy", "metric", "mean",
                                     lacking == std::string("red") ? "rotten" : "red"));
    for (const auto& line : table->rows) EXPECT_EQ(line.size(), columns.size());
  }
}

TEST(Plots, PartsWithoutAFigureAreAnError) {
  std::vector<Row> rows = orchard();
  for (Row& one : rows) one.figures.resize(1);
  for (const Error& error : {parts_plot(rows, "", catalogue()).error(), part_table(rows, "", catalogue()).error()})
    EXPECT_THAT(error.message, HasSubstr("no row has the parts of apples; expected some of the columns red, rotten"));
}

TEST(Plots, DifferencesOfGamesThatNobodyCompletedAreAnError) {
  std::vector<Row> rows = orchard();
  for (Row& one : rows) {
    one.status = "failed";
    one.exit_code = 4;
  }
  const auto answers = compare_strategies(rows, "", "", catalogue());
  ASSERT_TRUE(answers);
  EXPECT_EQ(difference_plot(*answers).error().message, "no game was completed by two strategies");
}

TEST(Plots, DifferencesHaveTheColourOfTheirAnswer) {
  std::vector<Row> rows = orchard();
  rows.pop_back();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) rows.push_back(row("worst", seed, 1, -10));
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    rows.push_back(row("same", seed, 50.0 + static_cast<double>(seed) + (seed % 2 ? 1 : -1), -10));
  const auto answers = compare_strategies(rows, "", "", catalogue());
  ASSERT_TRUE(answers);
  const auto plot = difference_plot(*answers);
  ASSERT_TRUE(plot);
  EXPECT_THAT(found(*plot, "<circle class=\"([a-z]*)"), ElementsAre("better", "worse", "undecided"));
}

TEST(MoreGames, AreAsManyAsADecisionNeedsBesidesTheOtherComparisons) {
  const auto more_games = [](const std::vector<Answer>& answers) {
    std::vector<std::int64_t> out;
    const Table table = difference_table(answers);
    for (const auto& line : table.rows) out.push_back(std::get<std::int64_t>(line.back().value));
    return out;
  };
  Answer few, many;
  few.is_difference = many.is_difference = true;
  few.values = {5, 6, 7.5};  // however large: three pairs have a p of 0.25, and six are needed for 0.04, seven for 0.02
  for (int i = 0; i < 20; ++i) many.values.push_back(i % 3 - 0.6);
  for (Answer* one : {&few, &many}) one->first = one->second = one->values;
  const double effect = statistics::effect_size(many.values);
  EXPECT_THAT(more_games({few}), ElementsAre(3));
  Answer constant = few;
  constant.values = {10, 10};
  EXPECT_THAT(more_games({constant}), ElementsAre(4));
  EXPECT_THAT(more_games({few, few}), ElementsAre(4, 4));
  EXPECT_THAT(more_games({many}), ElementsAre(statistics::pairs_needed(effect, 0.04) - 20));
  // Holm corrects the clearer one for both, and the other one for itself.
  ASSERT_LT(statistics::sign_flip_p(many.values), 0.25);
  EXPECT_THAT(more_games({few, many}), ElementsAre(3, statistics::pairs_needed(effect, 0.02) - 20));
}

TEST(Plots, SharesLieAroundWhatIsAllOfTheOther) {
  std::vector<Row> rows;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    rows.push_back(row("first", seed, 40, 0));
    rows.push_back(row("around", seed, seed % 2 ? 20 : 60, 0));
    rows.push_back(row("half", seed, 20, 0));
  }
  rows.push_back(row("first", 9, 0, 0));  // nothing is a share of it
  rows.push_back(row("around", 9, 20, 0));
  const auto answers = compare_strategies(rows, "", "", catalogue());
  ASSERT_TRUE(answers);
  const auto plot = share_plot(*answers);
  ASSERT_TRUE(plot);
  const std::string all = found(*plot, "<line class=\"zero\" x1=\"([0-9.]+)").front();
  const auto games = found(*plot, "<circle class=\"game\" cx=\"([0-9.]+)");
  ASSERT_EQ(games.size(), 16u);
  EXPECT_EQ(std::ranges::count(games, games.front()), 12) << "half of it, as often as it is: 4 of around, 8 of half";
  const auto means = found(*plot, "<circle class=\"series[^\"]*\" cx=\"([0-9.]+)");
  EXPECT_THAT(means, ElementsAre(all, games.front()));
  EXPECT_THAT(found(*plot, "<text class=\"caption\"[^>]*>([^<]*)"),
              ElementsAre("share of the apples of first in the same game, in %: grey each game,",
                          "coloured the mean with its 95 % interval"));
  EXPECT_THAT(share_plot({}).error().message, HasSubstr("only one strategy"));
}

TEST(Plots, IntervalsOfFewGamesAreWithinTheScale) {
  std::vector<Row> rows;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    rows.push_back(row("first", seed, 40.0 + 60 * static_cast<double>(seed), 0));
    rows.push_back(row("second", seed, 90.0 - 10 * static_cast<double>(seed), 0));
  }
  const auto answers = compare_strategies(rows, "", "", catalogue());
  ASSERT_TRUE(answers);
  for (const auto& plot : {score_plot(rows, "", "", catalogue()), share_plot(*answers), difference_plot(*answers)}) {
    ASSERT_TRUE(plot);
    const auto scale = found(*plot, "<line class=\"grid\" x1=\"([0-9.]+)");
    const auto from = found(*plot, "<line class=\"[^\"]*\" x1=\"(-?[0-9.]+)[^>]*stroke-width=\"3\"");
    const auto to = found(*plot, "x2=\"(-?[0-9.]+)\"[^>]*stroke-width=\"3\"");
    ASSERT_FALSE(from.empty());
    for (std::size_t i = 0; i < from.size(); ++i) {
      EXPECT_LT(std::stod(from[i]), std::stod(to[i]));
      EXPECT_GE(std::stod(from[i]), std::stod(scale.front()));
      EXPECT_LE(std::stod(to[i]), std::stod(scale.back()));
    }
  }
}

TEST(Plots, DoNotGrowWithTheSweep) {
  std::vector<Row> rows;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed)
    rows.push_back(row("a", seed, static_cast<double>(seed * 7919 % 1000), 0));
  const auto plot = score_plot(rows, "", "", catalogue());
  ASSERT_TRUE(plot);
  EXPECT_EQ(found(*plot, "<circle class=\"(game)").size(), 300u);
  EXPECT_THAT(*plot, HasSubstr("300 quantiles"));
  EXPECT_EQ(found(*plot, "<circle class=\"(series)").size(), 1u);
  const auto ends = [](const std::string& drawn) {
    std::vector<double> places;
    for (const std::string& x : found(drawn, "<circle class=\"game[^>]* cx=\"([^\"]*)")) places.push_back(std::stod(x));
    return std::pair(std::ranges::min(places), std::ranges::max(places));
  };
  rows.clear();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) rows.push_back(row("a", seed, seed % 2 ? 0 : 999, 0));
  const auto few = score_plot(rows, "", "", catalogue());
  ASSERT_TRUE(few);
  EXPECT_EQ(ends(*plot), ends(*few)) << "the least and the most are among them";
}

TEST(Plots, HaveRoomForTheLongestNameWhereverItStands) {
  const auto drawn = [](const char* first, const char* second) {
    const auto plot = score_plot({row(first, 1, 10, 0), row(second, 1, 20, 0)}, "", "", catalogue());
    EXPECT_TRUE(plot);
    return found(*plot, "viewBox=\"0 0 ([0-9.]+)");
  };
  const auto width = drawn("a rather long name", "b");
  EXPECT_EQ(width.size(), 1u);
  EXPECT_EQ(width, drawn("b", "a rather long name"));
  EXPECT_NE(width, drawn("a", "b"));
}

TEST(Plots, ScoresHaveTheColoursOfProfiles) {
  const auto scores = score_plot(orchard(), "", "", catalogue()), profile = profile_plot(orchard(), "", catalogue());
  ASSERT_TRUE(scores && profile);
  const auto colours = found(*profile, "<path class=\"series[^>]* stroke=\"([^\"]*)");
  ASSERT_EQ(colours.size(), 2u);
  EXPECT_NE(colours[0], colours[1]);
  EXPECT_EQ(found(*scores, "<circle class=\"series[^>]* fill=\"([^\"]*)"), colours);
}

TEST(Plots, GamesDoNotLieBehindTheirMean) {
  const auto scores = score_plot(orchard(), "", "", catalogue());
  ASSERT_TRUE(scores);
  const auto means = found(*scores, "<circle class=\"series[^>]* cy=\"([^\"]*)");
  ASSERT_EQ(means.size(), 2u);
  for (const std::string& y : found(*scores, "<circle class=\"game[^>]* cy=\"([^\"]*)")) {
    EXPECT_GE(std::abs(std::stod(y) - std::stod(means[0])), 5) << y;
    EXPECT_GE(std::abs(std::stod(y) - std::stod(means[1])), 5) << y;
  }
}

TEST(Plots, TheScaleOfScoresHasNoRoomWithoutGames) {
  const auto scores = score_plot(orchard(), "", "", catalogue());  // 41 to 71
  ASSERT_TRUE(scores);
  const auto ticks = found(*scores, "<text class=\"axis[^>]*>([^<]*)");
  ASSERT_GE(ticks.size(), 4u);
  EXPECT_GE(std::stod(ticks.front()), 35);
  EXPECT_LE(std::stod(ticks.front()), 41);
}

Answer answer(std::vector<double> values, Judgement judgement, bool more_is_better = true) {
  Answer out;
  out.scenario = "field";
  out.strategy = "second";
  out.asked = "mean(apples) >= 5";
  out.metric.more_is_better = more_is_better;
  out.values = std::move(values);
  for (std::uint64_t seed = 1; seed <= out.values.size(); ++seed) out.games.emplace_back("", seed);
  out.judgement = judgement;
  return out;
}

TEST(Requirements, NameTheThreeWorstGames) {
  const std::vector<double> values{5, 1, 9, 1, 0};
  EXPECT_THAT(worst_games(answer(values, Judgement::kWorse)), ElementsAre(4, 1, 3));
  EXPECT_THAT(worst_games(answer(values, Judgement::kWorse, false)), ElementsAre(2, 0, 1));
  EXPECT_THAT(worst_games(answer({7}, Judgement::kWorse)), ElementsAre(0));
}

TEST(Requirements, SayHowManyGamesAreMissing) {
  const std::vector<double> nine(9, 1.0), ten(10, 1.0);
  EXPECT_THAT(remarks_on({answer(nine, Judgement::kUndecided)}),
              ElementsAre(HasSubstr("found 9 games, expected at least 10")));
  EXPECT_THAT(remarks_on({answer(nine, Judgement::kUndecided), answer(nine, Judgement::kUndecided)}),
              ElementsAre(HasSubstr("found 9 games")))
      << "two requirements have the same to say";
  Answer of_files = answer(nine, Judgement::kUndecided);
  of_files.of_folder = true;
  EXPECT_THAT(remarks_on({of_files}), ElementsAre(HasSubstr("; add games to the suite's folder of games")));
  EXPECT_TRUE(remarks_on({answer(ten, Judgement::kUndecided)}).empty());
  EXPECT_TRUE(remarks_on({answer(nine, Judgement::kWorse)}).empty());
}

TEST(Requirements, AGameThatWasNotCompletedIsWorse) {
  std::vector<std::string> notes;
  const std::vector<Row> whole = [] {
    std::vector<Row> rows = orchard();
    rows.back().status = "completed";
    rows.back().exit_code = 0;
    return rows;
  }();
  const auto same = compare_sweeps(whole, whole, "", notes, catalogue());
  const auto broken = compare_sweeps(whole, orchard(), "", notes, catalogue());
  const auto mended = compare_sweeps(orchard(), whole, "", notes, catalogue());
  ASSERT_TRUE(same && broken && mended);
  EXPECT_EQ(exit_code_of(*same), kUndecidedExit);
  EXPECT_EQ((*broken)[0].judgement, Judgement::kUndecided);
  EXPECT_EQ((*broken)[1].judgement, Judgement::kWorse);
  EXPECT_EQ((*broken)[1].lost, 1u);
  EXPECT_EQ(exit_code_of(*broken), 1);
  EXPECT_THAT(remarks_on(*broken),
              ElementsAre("field, second: worse, because 1 game was not completed that the other side completed"));
  EXPECT_EQ(exit_code_of(*mended), kUndecidedExit);
  EXPECT_THAT(remarks_on(*mended), ElementsAre(HasSubstr("1 game was completed that the other side did not")));
}

TEST_F(SweepPageTest, KeepsTheAnswersToRequirements) {
  const SweepRecord sweep = record(orchard());
  EXPECT_THAT(page(sweep), Not(HasSubstr("Requirements")));
  ASSERT_TRUE(keep_requirements(path("sweep"), {answer(std::vector<double>(9, 4.0), Judgement::kUndecided)}));
  EXPECT_THAT(page(sweep), HasSubstr("mean(apples) &gt;= 5"));
  EXPECT_THAT(page(sweep), HasSubstr("expected at least 10"));
  const Json kept = parse_json(*read_file(path("sweep/requirements.json")));
  EXPECT_EQ(kept["requirements"][0]["answer"], "undecided") << "as bench --json prints them";
  EXPECT_EQ(kept["requirements"][0]["found"], 4);
  ASSERT_TRUE(keep_requirements(path("sweep"), {}));
  EXPECT_THAT(page(sweep), Not(HasSubstr("Requirements")));
  for (const char* broken : {"[1]", "{", R"({"remarks": [], "shown": 1})"}) {
    write("sweep/requirements.json", broken);
    EXPECT_THAT(page(sweep), HasSubstr("requirements.json: found no table of requirements")) << broken;
  }
}

TEST(Statistics, TheIntervalOfManyValuesIsNearThatOfTheNormalDistribution) {
  std::vector<double> values;
  for (int i = 0; i < 4000; ++i) values.push_back(static_cast<double>(i * 7919 % 4001));
  const auto interval = statistics::mean_interval_95(values);
  const double half = 1.96 * statistics::standard_deviation(values) / std::sqrt(4000.0);
  EXPECT_NEAR(interval.low, statistics::mean(values) - half, half / 10);
  EXPECT_NEAR(interval.high, statistics::mean(values) + half, half / 10);
}

TEST(Statistics, ProbabilityOfImprovementCountsPairs) {
  const std::vector<double> first{3, 1, 2, 2, 5}, second{2, 4, 2};
  double pairs = 0;
  for (const double a : first)
    for (const double b : second) pairs += b > a ? 1 : b == a ? 0.5 : 0;
  EXPECT_EQ(statistics::probability_of_improvement(first, second), pairs / 15);
}

}  // namespace
}  // namespace cxlab::lab
