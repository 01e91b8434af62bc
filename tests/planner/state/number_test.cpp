#include "planner/state/number.h"

#include <gtest/gtest.h>

#include <random>

#include "planner/state/state.h"

namespace cxlab::planner {
namespace {

TEST(Number, DecimalsAddUpAsPeopleWriteThem) {
  double total = 0;
  for (int i = 0; i < 10; ++i) total = sum(total, 0.1);
  EXPECT_EQ(total, 1);
  EXPECT_EQ(sum(0.1, 0.2), 0.3);
  EXPECT_EQ(difference(0.3, 0.1), 0.2);
  EXPECT_EQ(product(0.1, 3), 0.3);
  EXPECT_EQ(product(1.1, 1.1), 1.21);
  EXPECT_EQ(quotient(0.3, 0.1), 3);
  EXPECT_EQ(sum(1700000000.123456, 0.000001), 1700000000.123457);
  EXPECT_EQ(sum(1e-9, 2e-9), 3e-9);
}

/// Sums of decimals that fit into whole numbers are those of the whole numbers.
TEST(Number, ArithmeticIsThatOfWholeNumbers) {
  std::mt19937 random(1);  // NOLINT: the same numbers every time
  const auto draw = [&](std::int64_t most) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * most)) - most;
  };
  for (int i = 0; i < 20'000; ++i) {
    const std::int64_t a = draw(1'000'000'000), b = draw(1'000'000'000), c = draw(30'000'000), d = draw(30'000'000);
    const double a_milli = static_cast<double>(a) / 1e3, b_milli = static_cast<double>(b) / 1e3;
    EXPECT_EQ(sum(a_milli, b_milli), static_cast<double>(a + b) / 1e3) << a << " " << b;
    EXPECT_EQ(difference(a_milli, b_milli), static_cast<double>(a - b) / 1e3) << a << " " << b;
    EXPECT_EQ(product(static_cast<double>(c) / 1e3, static_cast<double>(d) / 1e2), static_cast<double>(c * d) / 1e5)
        << c << " " << d;
  }
}

TEST(Number, WhatIsWrittenIsToldApart) {
  constexpr std::pair<double, double> kDifferent[] = {{1700000000, 1700000001},
                                                      {4200000001, 4200000002},
                                                      {9007199254740991, 9007199254740992},
                                                      {9007199254740992, 9007199254740994},
                                                      {1, 1.000000000001},
                                                      {1700000000.123456, 1700000000.123457},
                                                      {1e-15, 2e-15},
                                                      {0, 1e-20},
                                                      {0.1, 0.100000000000001}};
  for (const auto& [less, more] : kDifferent) {
    EXPECT_FALSE(is_same(less, more)) << less;
    EXPECT_TRUE(compare(less, Comparison::kLess, more)) << less;
    EXPECT_TRUE(compare(-less, Comparison::kGreater, -more)) << less;
    EXPECT_FALSE(compare(less, Comparison::kGreaterEqual, more)) << less;
  }
}

TEST(Number, RoundingErrorsOfQuotientsAreNone) {
  double total = 0;
  for (int i = 0; i < 49; ++i) total = sum(total, quotient(1, 49));
  EXPECT_TRUE(is_same(total, 1));
  EXPECT_TRUE(is_same(product(quotient(1, 49), 49), 1));
  EXPECT_TRUE(is_same(difference(quotient(1, 3), quotient(2, 6)), 0));
  EXPECT_FALSE(is_same(quotient(1, 3), 0.333333333333)) << "twelve digits are not a third";
}

}  // namespace
}  // namespace cxlab::planner
