#include "cx/base/random.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <vector>

namespace cxlab {
namespace {

using testing::ElementsAre;

// How far the counts are from what they should be. For k cells, k + 4 sqrt(2 k) is passed by less than one in 10,000.
double chi_square(const std::vector<int>& counts) {
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
  double sum = 0;
  for (const int n : counts) sum += (n - mean) * (n - mean) / mean;
  return sum;
}
double chi_limit(std::size_t cells) {
  return static_cast<double>(cells) + 4 * std::sqrt(2 * static_cast<double>(cells));
}

// Computed by another implementation: FNV-1a of the name, splitmix64 with the seed, mt19937_64.
TEST(RandomStream, DrawsAreTheSameOnEveryPlatform) {
  const auto draws = [](std::uint64_t seed, std::string_view name) {
    RandomStream random(seed, name);
    std::vector<std::uint64_t> three;
    for (int i = 0; i < 3; ++i) three.push_back(random.next());
    return three;
  };
  EXPECT_THAT(draws(1, "orders"), ElementsAre(0x1cef661fa0327d16u, 0xd26a9845e3a39442u, 0x82d861952cc85dc3u));
  EXPECT_THAT(draws(2, "orders"), ElementsAre(0xb2b912afb08eef8u, 0xb3082d2235c53e09u, 0x871d1eec8d5acd12u));
  EXPECT_THAT(draws(1, "layout"), ElementsAre(0x7da1bf4f062dfa35u, 0xa3495a5a4061eba2u, 0x8eed1173960375ecu));
  EXPECT_THAT(draws(0, ""), ElementsAre(0xf185cbe32414264au, 0xdb599dcdd08f1558u, 0xd7be4b25790efef7u));
  EXPECT_THAT(draws(UINT64_MAX, "x"), ElementsAre(0xa26decd7e27e4a2u, 0x36fe4094cbf3ba54u, 0x2157c722b13f0a76u));
}

TEST(RandomStream, MoreDrawsInOneStreamMoveNoOther) {
  RandomStream first(7, "a"), alone(7, "a"), other(7, "b");
  for (int i = 0; i < 10; ++i) {
    other.next();
    EXPECT_EQ(first.next(), alone.next());
    other.next();
  }
}

TEST(RandomStream, BelowIsUniform) {
  RandomStream random(1, "below");
  std::vector<int> counts(7);
  for (int i = 0; i < 70'000; ++i) ++counts.at(random.below(7));
  EXPECT_LT(chi_square(counts), chi_limit(7));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(random.below(1), 0u);
}

TEST(RandomStream, BelowALargeNumberHasNoBias) {
  // Without rejection the lower half would come twice as often.
  constexpr std::uint64_t kThreeQuarters = 3ULL << 62;
  RandomStream random(1, "below");
  std::vector<int> counts(3);
  for (int i = 0; i < 30'000; ++i) ++counts.at(random.below(kThreeQuarters) >> 62);
  EXPECT_LT(chi_square(counts), chi_limit(3));
}

TEST(RandomStream, BetweenHasBothEnds) {
  RandomStream random(1, "between");
  std::map<std::int64_t, int> counts;
  for (int i = 0; i < 50'000; ++i) ++counts[random.between(-2, 2)];
  ASSERT_EQ(counts.size(), 5u);
  EXPECT_EQ(counts.begin()->first, -2);
  EXPECT_EQ(counts.rbegin()->first, 2);
  std::vector<int> list;
  for (const auto& [value, n] : counts) list.push_back(n);
  EXPECT_LT(chi_square(list), chi_limit(5));
  EXPECT_EQ(random.between(9, 9), 9);
}

TEST(RandomStream, UniformFillsItsRangeEvenly) {
  RandomStream random(1, "uniform");
  std::vector<int> counts(10);
  for (int i = 0; i < 100'000; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    ++counts.at(static_cast<std::size_t>(10 * x));
  }
  EXPECT_LT(chi_square(counts), chi_limit(10));
  counts.assign(10, 0);
  for (int i = 0; i < 100'000; ++i) ++counts.at(static_cast<std::size_t>(random.uniform(-5, 5) + 5));
  EXPECT_LT(chi_square(counts), chi_limit(10));
}

TEST(RandomStream, NormalHasItsMeanSigmaAndTails) {
  RandomStream random(1, "normal");
  constexpr int kDraws = 100'000;
  double sum = 0, squares = 0;
  std::vector<int> within(4);  // one, two, three sigma, beyond
  for (int i = 0; i < kDraws; ++i) {
    const double z = (random.normal(15, 2) - 15) / 2;
    sum += z;
    squares += z * z;
    ++within[std::min<std::size_t>(3, static_cast<std::size_t>(std::abs(z)))];
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.015);
  EXPECT_NEAR(squares / kDraws, 1, 0.02);
  EXPECT_NEAR(within[0] / double(kDraws), 0.6827, 0.006);
  EXPECT_NEAR(within[1] / double(kDraws), 0.2718, 0.006);
  EXPECT_NEAR(within[2] / double(kDraws), 0.0428, 0.003);
  EXPECT_NEAR(within[3] / double(kDraws), 0.0027, 0.001);
}

TEST(RandomStream, ChanceComesAsOftenAsItsProbability) {
  RandomStream random(1, "chance");
  int struck = 0;
  for (int i = 0; i < 100'000; ++i) struck += random.chance(0.3);
  EXPECT_NEAR(struck, 30'000, 600);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(random.chance(0));
    EXPECT_TRUE(random.chance(1));
  }
}

TEST(RandomStream, ShuffleGivesEachOrderEquallyOften) {
  RandomStream random(1, "shuffle");
  std::map<std::string, int> counts;
  for (int i = 0; i < 24'000; ++i) {
    std::string letters = "abcd";
    random.shuffle(letters);
    ++counts[letters];
  }
  ASSERT_EQ(counts.size(), 24u);
  std::vector<int> list;
  for (const auto& [order, n] : counts) list.push_back(n);
  EXPECT_LT(chi_square(list), chi_limit(24));
  std::vector<int> none;
  random.shuffle(none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace cxlab
