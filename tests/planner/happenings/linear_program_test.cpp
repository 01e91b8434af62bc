// Linear programs beside the best corner of their constraints.

#include "planner/happenings/linear_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace cxlab::planner {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;
using ::testing::Pointwise;

auto near(const std::vector<double>& values) { return Optional(Pointwise(DoubleNear(1e-9), values)); }

TEST(LinearProgram, FindsTheLeastOfWhatTheRowsAllow) {
  EXPECT_THAT(minimize({{{-1}, -3}}, {1}), near({3})) << "x >= 3";
  EXPECT_THAT(minimize({{{1}, 5}}, {-1}), near({5})) << "x <= 5, as large as can be";
  EXPECT_THAT(minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {-3, -2}), near({4, 0}));
  EXPECT_THAT(minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {-1, -2}), near({3, 1})) << "where both rows meet";
  EXPECT_THAT(minimize({{{-1, -1}, -2}, {{1, -1}, 0}, {{-1, 1}, 0}}, {1, 0}), near({1, 1})) << "x = y, x + y >= 2";
  EXPECT_THAT(minimize({}, {1, 1}), near({0, 0}));
}

TEST(LinearProgram, HasNoValuesWhereRowsContradictEachOther) {
  EXPECT_EQ(minimize({{{1}, -1}}, {1}), std::nullopt) << "x <= -1";
  EXPECT_EQ(minimize({{{1, 0}, 2}, {{-1, 0}, -3}}, {0, 1}), std::nullopt) << "x <= 2, x >= 3";
  EXPECT_EQ(minimize({{{1, 1}, 1}, {{-1, 0}, -1}, {{0, -1}, -1}}, {0, 0}), std::nullopt);
}

TEST(LinearProgram, KeepsTheRowsWhereTheObjectiveHasNoBound) {
  const auto found = minimize({{{-1, 0}, -3}}, {0, -1});
  ASSERT_TRUE(found);
  EXPECT_GE((*found)[0], 3 - 1e-9);
}

TEST(LinearProgram, ReportsTheCellsThatItLooksAt) {
  std::int64_t none = 0, one = 0, two = 0;
  minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {1, 1}, &none);
  minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {-1, 0}, &one);
  minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {-3, -2}, &two);
  EXPECT_GE(none, 16) << "four rows of four cells";
  EXPECT_GE(one, none + 16) << "each exchange looks at all cells";
  minimize({{{1, 1}, 4}, {{1, 3}, 6}}, {-1, -2}, &two);
  EXPECT_GE(two, one + 2 * 16) << "it is added up";
}

TEST(LinearProgram, OfRowsThatEndAStepTogetherTheFirstDoes) {
  // x ends at 2 by both rows: after the first nothing is left to gain, after the second y would move as well.
  std::int64_t first = 0, last = 0;
  EXPECT_THAT(minimize({{{1, 1}, 2}, {{1, -1}, 2}}, {-2, -1}, &first), near({2, 0}));
  EXPECT_THAT(minimize({{{1, -1}, 2}, {{1, 1}, 2}}, {-2, -1}, &last), near({2, 0}));
  EXPECT_EQ(first, 16 + 16 + 2 * 4) << "one exchange";
  EXPECT_EQ(last, 16 + 2 * 16 + 3 * 4) << "two";
}

/// The best of all points where two of the constraints (those of x, y >= 0 included) hold with equality.
std::optional<double> best_corner(std::vector<LinearRow> rows, const std::vector<double>& objective) {
  rows.push_back({{-1, 0}, 0});
  rows.push_back({{0, -1}, 0});
  std::optional<double> best;
  for (const LinearRow& one : rows)
    for (const LinearRow& other : rows) {
      const double a = one.coefficients[0], b = one.coefficients[1], c = other.coefficients[0],
                   d = other.coefficients[1];
      const double determinant = a * d - b * c;
      if (determinant == 0) continue;
      const double x = (one.bound * d - b * other.bound) / determinant;
      const double y = (a * other.bound - one.bound * c) / determinant;
      bool kept = true;
      for (const LinearRow& row : rows)
        kept = kept && row.coefficients[0] * x + row.coefficients[1] * y <= row.bound + 1e-9;
      const double value = objective[0] * x + objective[1] * y;
      if (kept && (!best || value < *best)) best = value;
    }
  return best;
}

TEST(LinearProgram, IsAsGoodAsTheBestCornerOfRandomProblems) {
  std::mt19937 random(7);
  const auto draw = [&](unsigned most) { return static_cast<double>(random() % (2 * most + 1)) - most; };
  int solved = 0, impossible = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<LinearRow> rows{{{1, 1}, 20}};  // so that all have a bound
    for (int r = 0; r < 4; ++r) rows.push_back({{draw(3), draw(3)}, draw(6)});
    const std::vector<double> objective{draw(3), draw(3)};
    const auto found = minimize(rows, objective);
    const auto best = best_corner(rows, objective);
    ASSERT_EQ(found.has_value(), best.has_value()) << "problem " << i;
    if (!found) {
      ++impossible;
      continue;
    }
    ++solved;
    EXPECT_NEAR(std::inner_product(found->begin(), found->end(), objective.begin(), 0.0), *best, 1e-6)
        << "problem " << i;
    for (const LinearRow& row : rows)
      EXPECT_LE(std::inner_product(found->begin(), found->end(), row.coefficients.begin(), 0.0), row.bound + 1e-6)
          << "problem " << i;
  }
  EXPECT_GT(solved, 200);
  EXPECT_GT(impossible, 200);
}

}  // namespace
}  // namespace cxlab::planner
