#pragma once
// Statistics of figures of episodes. Pure functions: the same values give the same bytes, also where they draw samples.
//
// - BCa interval: Efron, "Better bootstrap confidence intervals", JASA 82 (1987)
// - its level for few values: Hesterberg, "What teachers should know about the bootstrap", Am. Statistician 69 (2015)
// - interquartile mean and performance profile (the share of episodes that reach a figure): Agarwal et al., "Deep RL at
//   the edge of the statistical precipice", NeurIPS (2021)
// - probability of improvement: Mann and Whitney, Ann. Math. Statist. 18 (1947), U / (n m)
// - sign-flip test: Fisher, The Design of Experiments (1935); the p of random flips: Phipson and Smyth (2010)
// - Hall's test of a mean: Hall, "On the removal of skewness by transformation", JRSS B 54 (1992)
// - Holm's correction: Holm, Scand. J. Statist. 6 (1979)
// - interval of a share: Wilson, "Probable inference", JASA 22 (1927)
// - number of pairs: Guenther, "Sample size formulas for normal theory t tests", Am. Statistician 35 (1981)

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cxlab::statistics {

using Values = std::span<const double>;

// ---- One sample; NaN where there are too few values

double mean(Values values);
double median(Values values);
/// The mean of the middle half: a quarter of the values, rounded down, is left out at each end.
double interquartile_mean(Values values);
/// The sample standard deviation: the sum of squares is divided by n - 1.
double standard_deviation(Values values);

struct Interval {
  double low = 0, high = 0;  ///< NaN: there are too few values
};

/// How samples are drawn from values.
struct Resampling {
  std::size_t resamples = 9999;
  std::uint64_t seed = 1;
};

/// The BCa bootstrap interval of a statistic, for two or more values; as scipy.stats.bootstrap(method="BCa").
Interval bootstrap_interval(Values values, const std::function<double(Values)>& statistic, double level,
                            const Resampling& resampling = {});
/// The level that bootstrap_interval needs for its interval of a mean to cover `level`: resamples of few values
/// scatter less than their mean does (Hesterberg). The width grows by 1 / n more, because the skewness that BCa
/// corrects is itself uncertain; simulated sweeps have shown that (tests/lab/statistics/promises_test.cpp).
double widened_level(double level, std::size_t n);
/// bootstrap_interval at the widened level of 95 %. NaN for fewer than `kFewestForBootstrap` values: no resample leaves
/// their range, and the range of n values misses the median with a probability of 2^(1 - n).
Interval interval_95(Values values, const std::function<double(Values)>& statistic);
inline constexpr std::size_t kFewestForBootstrap = 6;
/// Half of Student's 95 % interval of the mean; NaN for fewer than two values.
double student_half_95(Values values);
/// interval_95 of the mean; for fewer than `kFewestForBootstrap` values, two at least, the interval of Student's t.
Interval mean_interval_95(Values values);

/// For each threshold the share of the values that reach it; in the other direction the share that stays at or below.
std::vector<double> profile(Values values, Values thresholds, bool more_is_better = true);

// ---- Two samples

/// Mean by standard deviation of differences, Cohen's d of pairs. NaN if all are the same.
double effect_size(Values differences);
/// How often a value of the second sample is above one of the first; equal ones count half.
double probability_of_improvement(Values first, Values second);

/// The interval of Wilson's score for the share of hits in `n` draws, n > 0; as scipy.stats.binomtest(hits, n)
/// .proportion_ci(level, "wilson").
Interval share_interval(std::size_t hits, std::size_t n, double level = 0.95);

struct Counts {
  std::size_t above = 0, equal = 0, below = 0;
};
/// How many differences are above 0, 0, and below.
Counts count_signs(Values differences);

// ---- Tests; both p are of two sides

/// How probable a mean at least as far from 0 is if each difference could as well have the other sign. That holds for
/// pairs of two strategies between which nothing differs, however their figures are distributed. All flips are tried
/// for up to 16 differences, else random ones.
double sign_flip_p(Values differences, const Resampling& flips = {.resamples = 99999});
/// The probability of a mean at least as far from 0 if the true mean is 0. It is the larger one of Student's t test and
/// of Hall's correction for skewness. 1 for fewer than `kFewestForMean` values.
double mean_p(Values values);
inline constexpr std::size_t kFewestForMean = 10;
/// Holm's correction: the p of each, so that with `adjusted <= a` in all of them a false one is among them with
/// a probability of at most a.
std::vector<double> holm(Values p);

/// The pairs with which a test at `alpha` of two sides finds a difference of this effect size with the probability
/// `power`; 0 if the effect is none.
double pairs_needed(double effect, double alpha, double power = 0.8);

}  // namespace cxlab::statistics
