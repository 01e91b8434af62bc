// Values beside those of SciPy 1.17; tests/readers/statistics_of_sweeps.py compares other ones with the SciPy that is
// installed.

#include "lab/statistics/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cx/base/random.h"
#include "lab/statistics/distributions.h"

namespace cxlab::statistics {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Pointwise;

const std::vector<double> kPoints{650, 530, 712, 604, 655, 590, 707, 668, 631, 570.5};
const std::vector<double> kOthers{590, 540, 640, 604, 610, 575, 690, 605, 640, 520};

std::vector<double> differences() {
  std::vector<double> out;
  for (std::size_t i = 0; i < kPoints.size(); ++i) out.push_back(kPoints[i] - kOthers[i]);
  return out;
}

// The numbers come from SciPy:
//   python3 -c 'from scipy.stats import norm, t; print([norm.cdf(z) for z in (-3, -1.5, 0, 2)], [norm.ppf(p) for p in
//   (.001, .3, .975)], [t.cdf(x, k) for x, k in ((-2, 1), (1.5, 9), (3, 29.5))], [t.ppf(p, k) for p, k in
//   ((.975, 1), (.9, 9), (.001, 30))])'
TEST(Distributions, AreThoseOfSciPy) {
  EXPECT_NEAR(normal_below(-3), 0.0013498980316300933, 1e-15);
  EXPECT_NEAR(normal_below(-1.5), 0.06680720126885807, 1e-15);
  EXPECT_EQ(normal_below(0), 0.5);
  EXPECT_NEAR(normal_below(2), 0.9772498680518208, 1e-15);
  EXPECT_NEAR(normal_quantile(0.001), -3.090232306167813, 1e-13);
  EXPECT_NEAR(normal_quantile(0.3), -0.5244005127080409, 1e-13);
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-13);
  EXPECT_NEAR(student_below(-2, 1), 0.14758361765043326, 1e-13);
  EXPECT_NEAR(student_below(1.5, 9), 0.9160746719714625, 1e-13);
  EXPECT_NEAR(student_below(3, 29.5), 0.9972782401768125, 1e-13);
  EXPECT_NEAR(student_quantile(0.975, 1), 12.706204736174694, 1e-10);
  EXPECT_NEAR(student_quantile(0.9, 9), 1.3830287383966329, 1e-12);
  EXPECT_NEAR(student_quantile(0.001, 30), -3.385184866829305, 1e-12);
}

// numpy.median, scipy.stats.trim_mean(points, .25), numpy.std(points, ddof=1)
TEST(OneSample, HasTheFiguresOfNumPyAndSciPy) {
  EXPECT_DOUBLE_EQ(mean(kPoints), 631.75);
  EXPECT_DOUBLE_EQ(median(kPoints), 640.5);
  EXPECT_DOUBLE_EQ(interquartile_mean(kPoints), 633);
  EXPECT_NEAR(standard_deviation(kPoints), 58.60282985203587, 1e-12);
}

TEST(OneSample, OfOddAndSmallNumbers) {
  EXPECT_EQ(median(std::vector{3.0, 1.0, 2.0}), 2);
  EXPECT_EQ(median(std::vector{7.0}), 7);
  EXPECT_EQ(interquartile_mean(std::vector{0.0, 1.0, 2.0, 300.0}), 1.5);
  EXPECT_EQ(interquartile_mean(std::vector{0.0, 1.0, 5.0}), 2);
  EXPECT_TRUE(std::isnan(mean({})) && std::isnan(median({})) && std::isnan(interquartile_mean({})));
  EXPECT_TRUE(std::isnan(standard_deviation(std::vector{7.0})));
  EXPECT_EQ(mean(std::vector{0.1, 0.1, 0.1, 0.1, 0.1, 0.1}), 0.1) << "equal values have themselves as their mean";
}

// scipy.stats.bootstrap((points,), statistic, confidence_level=..., n_resamples=99999, method="BCa"): with three seeds
// the ends of the mean's interval differ by 0.5 at most.
TEST(BootstrapInterval, IsThatOfSciPyButForChance) {
  const Resampling many{.resamples = 99999, .seed = 1};
  const auto check = [&](const auto& statistic, double level, double low, double high, double chance) {
    const Interval found = bootstrap_interval(kPoints, statistic, level, many);
    EXPECT_NEAR(found.low, low, chance) << level;
    EXPECT_NEAR(found.high, high, chance) << level;
  };
  check(mean, 0.95, 595.65, 664.45, 0.5);
  check(mean, 0.99, 584.1, 673.6, 0.9);
  check(median, 0.95, 590, 681, 1e-9);
  check(median, 0.99, 570.5, 707, 1e-9);
  check(interquartile_mean, 0.95, 588.5, 672.45, 0.9);
  check(interquartile_mean, 0.99, 574, 683.17, 1.2);
}

TEST(BootstrapInterval, IsTheSameEachTimeAndAnotherWithAnotherSeed) {
  const Interval a = bootstrap_interval(kPoints, mean, 0.95), b = bootstrap_interval(kPoints, mean, 0.95);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_NE(bootstrap_interval(kPoints, mean, 0.95, {.resamples = 9999, .seed = 2}).low, a.low);
}

TEST(BootstrapInterval, OfTooFewAndOfEqualValues) {
  EXPECT_TRUE(std::isnan(mean_interval_95(std::vector{3.0}).low));
  EXPECT_EQ(mean_interval_95(std::vector{3.0, 3.0, 3.0}).low, 3);
  EXPECT_EQ(mean_interval_95(std::vector{3.0, 3.0, 3.0}).high, 3);
  EXPECT_EQ(interval_95(std::vector(6, 3.0), median).high, 3);
}

TEST(MeanInterval, OfFewValuesIsStudents) {
  const Interval two = mean_interval_95(std::vector{1.0, 2.0});  // 1.5 +- 12.7062 / 2
  EXPECT_NEAR(two.low, -4.8531, 1e-4);
  EXPECT_NEAR(two.high, 7.8531, 1e-4);
  const std::vector five{4.0, 1.0, 5.0, 2.0, 3.0}, six{4.0, 1.0, 5.0, 2.0, 3.0, 6.0};
  EXPECT_NEAR(mean_interval_95(five).high, 3 + 2.7764 * std::sqrt(2.5 / 5), 1e-3);
  EXPECT_TRUE(std::isnan(interval_95(five, median).low));
  EXPECT_LE(interval_95(six, median).high, 6);
  EXPECT_EQ(mean_interval_95(six).high, interval_95(six, mean).high);
}

TEST(MeanInterval, OfFewValuesCoversWhatItPromises) {
  constexpr int kSweeps = 4000;
  RandomStream random(1, "few values");
  for (const std::size_t n : {2u, 3u, 5u}) {
    int covered = 0;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      std::vector<double> values(n);
      for (double& value : values) value = random.normal(0, 1);
      const Interval interval = mean_interval_95(values);
      covered += interval.low <= 0 && 0 <= interval.high;
    }
    EXPECT_NEAR(static_cast<double>(covered) / kSweeps, 0.95, 0.012) << n << " values";
  }
}

TEST(WidenedLevel, GivesIntervalsOfFewValuesTheWidthOfStudentsAndMore) {
  // n = 10: 1.1 * sqrt(10 / 9) * 2.2622 = 2.6230, and 2 * norm.cdf(2.6230) - 1 = 0.99128
  EXPECT_NEAR(widened_level(0.95, 10), 0.99128, 1e-5);
  EXPECT_NEAR(widened_level(0.95, 100000), 0.95, 1e-4);
  EXPECT_EQ(widened_level(0.95, 1), 0.95);
}

TEST(Profile, CountsThoseThatReachEachThreshold) {
  const std::vector<double> values{10, 20, 20, 40}, thresholds{0, 20, 21, 40, 41};
  EXPECT_THAT(profile(values, thresholds), ElementsAre(1, 0.75, 0.25, 0.25, 0));
  EXPECT_THAT(profile(values, thresholds, false), ElementsAre(0, 0.75, 0.75, 1, 1));
}

TEST(TwoSamples, EffectSignsAndImprovement) {
  EXPECT_DOUBLE_EQ(effect_size(std::vector{1.0, 2.0, 3.0}), 2);
  EXPECT_TRUE(std::isnan(effect_size(std::vector{4.0, 4.0})));
  const Counts signs = count_signs(differences());
  EXPECT_EQ(signs.above, 7u);
  EXPECT_EQ(signs.equal, 1u);
  EXPECT_EQ(signs.below, 2u);
  // scipy.stats.mannwhitneyu(points, others).statistic / 100 = 0.65
  EXPECT_DOUBLE_EQ(probability_of_improvement(kOthers, kPoints), 0.65);
  EXPECT_DOUBLE_EQ(probability_of_improvement(kPoints, kOthers), 0.35);
}

// Wilson's formula, evaluated with Python's statistics.NormalDist.
TEST(ShareInterval, IsWilsons) {
  struct Row {
    std::size_t hits, n;
    double level, low, high;
  };
  for (const Row& row :
       {Row{170, 200, 0.95, 0.79394420715833, 0.89286406437758}, Row{7, 20, 0.9, 0.20226004005676, 0.53348731115133},
        Row{0, 10, 0.95, 0, 0.27753279986289}, Row{10, 10, 0.95, 0.72246720013711, 1}}) {
    const Interval interval = share_interval(row.hits, row.n, row.level);
    EXPECT_NEAR(interval.low, row.low, 1e-12);
    EXPECT_NEAR(interval.high, row.high, 1e-12);
  }
}

// scipy.stats.permutation_test((differences,), numpy.mean, permutation_type="samples", n_resamples=numpy.inf).pvalue
TEST(SignFlips, GiveThePOfSciPy) {
  EXPECT_DOUBLE_EQ(sign_flip_p(differences()), 0.0234375);
  std::vector<double> less = differences();
  for (double& one : less) one -= 20;
  EXPECT_DOUBLE_EQ(sign_flip_p(less), 0.314453125);
}

// The same with n_resamples=999999 for numpy.round(numpy.random.default_rng(5).normal(12, 30, 30)): 0.2729 and 0.2740.
TEST(SignFlips, OfManyDifferencesAreDrawn) {
  const std::vector<double> many{-12, -28, 5,   25, 46, 15, -5, -12, 34, 61, 20, -25, -17, 60,  18,
                                 -40, 9,   -23, -7, -3, -9, 29, 10,  -6, 24, 37, -37, 4,   -17, 7};
  EXPECT_NEAR(sign_flip_p(many), 0.2734, 0.005);
  EXPECT_EQ(sign_flip_p(many), sign_flip_p(many));
  EXPECT_EQ(sign_flip_p(std::vector<double>(40, 5.0), {.resamples = 999, .seed = 1}), 0.001);
}

TEST(SignFlips, CountEachFlipOnce) {
  EXPECT_EQ(sign_flip_p({}), 1);
  EXPECT_EQ(sign_flip_p(std::vector{0.0, 0.0}), 1);
  EXPECT_EQ(sign_flip_p(std::vector{5.0, 5.0, 5.0}), 0.25);
  EXPECT_EQ(sign_flip_p(std::vector{5.0, 0.0, 5.0, 5.0}), 0.25) << "0 has no sign";
  EXPECT_EQ(sign_flip_p(std::vector{0.1, 0.7, -0.8}), 1) << "rounding makes no difference";
  EXPECT_EQ(sign_flip_p(std::vector<double>(16, -1.0)), std::pow(2, -15));
}

TEST(MeanP, IsStudentsWithoutSkewness) {
  std::vector<double> values;
  for (int i = 0; i < 4; ++i)
    for (const double one : {-2.0, 0.0, 2.0, 4.0}) values.push_back(one);
  const double t = 1 / (standard_deviation(values) / 4) / (1 + 1.0 / 16);
  EXPECT_NEAR(mean_p(values), 2 * student_below(-t, 15), 1e-12);
  EXPECT_EQ(mean_p(std::vector<double>(9, 5.0)), 1) << "too few";
  EXPECT_EQ(mean_p(std::vector<double>(11, 5.0)), std::pow(2, -10));
  EXPECT_EQ(mean_p(std::vector<double>(11, 0.0)), 1);
}

TEST(MeanP, TakesALongTailIntoAccount) {
  std::vector<double> values(20, 10.0);
  values[3] = 90, values[7] = 60;
  const auto p_at = [&values](double to_mean, bool mirrored) {
    std::vector<double> moved;
    for (const double value : values) moved.push_back((value - mean(values) + to_mean) * (mirrored ? -1 : 1));
    return mean_p(moved);
  };
  const double t = 12 / (standard_deviation(values) / std::sqrt(20)) / (1 + 1.0 / 20);
  const double students = 2 * student_below(-t, 19);
  EXPECT_NEAR(p_at(12, false), students, 1e-12) << "far values on the other side: the mean is rather greater";
  EXPECT_GT(p_at(-12, false), 2 * students) << "few values pull the mean up, and might be missing";
  EXPECT_DOUBLE_EQ(p_at(12, true), p_at(12, false));
  EXPECT_DOUBLE_EQ(p_at(-12, true), p_at(-12, false));
}

TEST(Holm, CorrectsStepByStep) {
  // By hand: 4 * 0.01, max(0.04, 3 * 0.02), max(0.06, 2 * 0.02), 1 * 0.5
  EXPECT_THAT(holm(std::vector{0.02, 0.01, 0.5, 0.02}),
              Pointwise(DoubleNear(1e-12), std::vector{0.06, 0.04, 0.5, 0.06}));
  EXPECT_THAT(holm(std::vector{0.6, 0.9}), ElementsAre(1, 1));
  EXPECT_THAT(holm(std::vector{0.03}), ElementsAre(0.03));
  EXPECT_TRUE(holm({}).empty());
}

// The least n for which the power with scipy.stats.nct is 0.8: 199, 34, 11, 71.
TEST(PairsNeeded, AreThoseOfTheNoncentralTWithinOne) {
  EXPECT_NEAR(pairs_needed(0.2, 0.05), 199, 1);
  EXPECT_NEAR(pairs_needed(-0.5, 0.05), 34, 1);
  EXPECT_NEAR(pairs_needed(1, 0.04), 11, 1);
  EXPECT_NEAR(pairs_needed(0.35, 0.04), 71, 1);
  EXPECT_EQ(pairs_needed(0, 0.05), 0);
}

}  // namespace
}  // namespace cxlab::statistics
