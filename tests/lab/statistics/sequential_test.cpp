#include "lab/statistics/sequential.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::statistics::sequential_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Question differences(std::size_t n, double value) {
  Question out;
  out.values.assign(n, value);
  return out;
}

TEST(Looks, ComeAfterEachTenthAndAtTheEnd) {
  EXPECT_THAT(looks(0), IsEmpty());
  EXPECT_THAT(looks(100), ElementsAre(20, 30, 40, 50, 60, 70, 80, 90, 100));
  EXPECT_THAT(looks(45), ElementsAre(14, 18, 23, 27, 32, 36, 41, 45));
  EXPECT_THAT(looks(12), ElementsAre(11, 12));
  EXPECT_THAT(looks(3), ElementsAre(3));
  EXPECT_THAT(looks(60, 20), ElementsAre(20, 40, 60));
}

TEST(Decide, StopsWithTheFirstLookThatIsCertain) {
  // Eleven differences of one sign have p = 2 / 2^11 < 0.001; the first look is after fifteen.
  const Decision all = decide({differences(50, 5)}, looks(50)).front();
  EXPECT_EQ(all.side, Side::kAbove);
  EXPECT_EQ(all.after, 15u);
  EXPECT_EQ(decide({differences(50, -5)}, looks(50)).front().side, Side::kBelow);
}

TEST(Decide, WaitsForTheLookAfterTheGamesThatAreThere) {
  EXPECT_EQ(decide({differences(14, 5)}, looks(50)).front().side, Side::kUndecided);
  EXPECT_EQ(decide({differences(14, 5)}, looks(50)).front().after, 0u);
  EXPECT_EQ(decide({differences(15, 5)}, looks(50)).front().side, Side::kAbove);
}

TEST(Decide, TakesLessAtTheLastLook) {
  EXPECT_EQ(decide({differences(6, 5)}, looks(6)).front().side, Side::kAbove) << "p = 2 / 2^6 = 0.031";
  EXPECT_EQ(decide({differences(5, 5)}, looks(5)).front().side, Side::kUndecided) << "p = 2 / 2^5 = 0.0625";
  EXPECT_EQ(decide({differences(6, 5)}, looks(60)).front().side, Side::kUndecided);
}

TEST(Decide, CorrectsForTheOtherQuestions) {
  // Two questions double the p of six differences: 0.0625.
  const std::vector<Decision> both = decide({differences(6, 5), differences(6, 0)}, looks(6));
  EXPECT_EQ(both[0].side, Side::kUndecided);
  EXPECT_DOUBLE_EQ(both[0].p, 0.0625);
  EXPECT_EQ(both[1].side, Side::kUndecided);
}

TEST(Decide, NeedsTheFewestGames) {
  for (const std::size_t questions : {1u, 2u, 3u, 20u, 100u}) {
    const std::size_t fewest = fewest_games(Question::About::kDifferences, questions);
    const auto side_after = [questions](std::size_t games) {
      std::vector<Question> asked{differences(games, 5)};
      asked.resize(questions, differences(games, 0));
      return decide(asked, {games}).front().side;
    };
    EXPECT_EQ(side_after(fewest), Side::kAbove) << questions;
    EXPECT_EQ(side_after(fewest - 1), Side::kUndecided) << questions;
  }
  const auto mean_after = [](std::size_t games) {
    Question asked = differences(games, 5);
    asked.about = Question::About::kMean;
    return decide({asked}, {games}).front().side;
  };
  const std::size_t fewest = fewest_games(Question::About::kMean, 1);
  EXPECT_EQ(mean_after(fewest), Side::kAbove);
  EXPECT_EQ(mean_after(fewest - 1), Side::kUndecided);
}

TEST(Decide, TellsAMeanAboveZeroEarlyFromThirtyGamesOn) {
  const auto decided = [](double middle) {
    Question asked{Question::About::kMean, {}};
    for (int i = 0; i < 100; ++i) asked.values.emplace_back(i % 2 == 0 ? middle - 1 : middle + 1);
    return decide({asked}, looks(100)).front();
  };
  EXPECT_EQ(decided(5).side, Side::kAbove);
  EXPECT_EQ(decided(5).after, 30u);
  EXPECT_EQ(decided(-5).side, Side::kBelow);
  EXPECT_EQ(decided(-5).after, 20u);
}

TEST(Decide, TellsNothingEarlyOfGamesThatAreAllAlike) {
  for (const double value : {3.0, -3.0}) {
    const Question asked{Question::About::kMean, std::vector<std::optional<double>>(100, value)};
    const Decision decision = decide({asked}, looks(100)).front();
    EXPECT_EQ(decision.side, value > 0 ? Side::kAbove : Side::kBelow);
    EXPECT_EQ(decision.after, 100u) << "a loss that comes in one of ten games is missing in 28 % of twelve games";
  }
}

TEST(Decide, KeepsADecisionWhileOthersAreOpen) {
  Question later = differences(20, 5), open = differences(20, 0);
  for (std::size_t i = 14; i < 20; ++i) later.values[i] = -50;
  const std::vector<Decision> both = decide({later, open}, looks(20));
  EXPECT_EQ(both[0].side, Side::kAbove);
  EXPECT_EQ(both[0].after, 12u);
  EXPECT_EQ(both[1].after, 20u);
}

TEST(Decide, LeavesGamesWithoutAFigureOut) {
  Question gaps = differences(12, 5);
  for (std::size_t i = 0; i < 12; i += 2) gaps.values[i].reset();
  const Decision decision = decide({gaps}, looks(12)).front();
  EXPECT_EQ(decision.side, Side::kAbove);
  EXPECT_DOUBLE_EQ(decision.p, 2.0 / 64);
}

}  // namespace
}  // namespace cxlab::statistics::sequential_test
