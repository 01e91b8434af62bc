#include "lab/statistics/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "cx/base/random.h"
#include "lab/statistics/distributions.h"

namespace cxlab::statistics {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double count(Values values) { return static_cast<double>(values.size()); }

/// Linear between the two nearest, as numpy.quantile.
double quantile_of_sorted(Values sorted, double share) {
  const double at = share * (count(sorted) - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (sorted[above] - sorted[below]) * (at - std::floor(at));
}

bool all_equal(Values values) {
  return std::ranges::all_of(values, [&values](double value) { return value == values.front(); });
}

}  // namespace

double mean(Values values) {
  if (values.empty()) return kNone;
  // Around the first value: the mean of equal values is that value to the last bit.
  double sum = 0;
  for (const double value : values) sum += value - values.front();
  return values.front() + sum / count(values);
}

double median(Values values) {
  if (values.empty()) return kNone;
  std::vector<double> sorted(values.begin(), values.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return sorted.size() % 2 == 1 ? *middle : (*std::max_element(sorted.begin(), middle) + *middle) / 2;
}

double interquartile_mean(Values values) {
  if (values.empty()) return kNone;
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const std::size_t out = sorted.size() / 4;
  return mean(Values(sorted).subspan(out, sorted.size() - 2 * out));
}

double standard_deviation(Values values) {
  if (values.size() < 2) return kNone;
  const double middle = mean(values);
  double squares = 0;
  for (const double value : values) squares += (value - middle) * (value - middle);
  return std::sqrt(squares / (count(values) - 1));
}

Interval bootstrap_interval(Values values, const std::function<double(Values)>& statistic, double level,
                            const Resampling& resampling) {
  if (values.size() < 2) return {kNone, kNone};
  if (all_equal(values)) return {statistic(values), statistic(values)};
  const double found = statistic(values);
  RandomStream random(resampling.seed, "bootstrap");
  std::vector<double> sample(values.size()), statistics;
  statistics.reserve(resampling.resamples);
  double below = 0;  // those that are equal count half
  for (std::size_t i = 0; i < resampling.resamples; ++i) {
    for (double& value : sample) value = values[random.below(values.size())];
    const double one = statistics.emplace_back(statistic(sample));
    below += one < found ? 1 : one == found ? 0.5 : 0;
  }
  std::ranges::sort(statistics);

  // The statistic without each value in turn; of many values without each of some groups,
  // because all of them would take the square of the time.
  constexpr std::size_t kMany = 1000, kGroups = 200;
  const std::size_t groups = values.size() <= kMany ? values.size() : kGroups;
  std::vector<double> without, rest;
  for (std::size_t group = 0; group < groups; ++group) {
    rest.clear();
    for (std::size_t i = 0; i < values.size(); ++i)
      if (i % groups != group) rest.push_back(values[i]);
    without.push_back(statistic(rest));
  }
  const double middle = mean(without);
  double squares = 0, cubes = 0;
  for (const double one : without) {
    squares += (middle - one) * (middle - one);
    cubes += (middle - one) * (middle - one) * (middle - one);
  }
  const double acceleration = squares > 0 ? cubes / (6 * std::pow(squares, 1.5)) : 0;
  const double resamples = static_cast<double>(resampling.resamples);
  const double bias = normal_quantile(std::clamp(below / resamples, 0.5 / resamples, 1 - 0.5 / resamples));
  const auto end = [&](double z) {
    const double shifted = bias + z, scale = 1 - acceleration * shifted;
    // Past the pole of the formula the end lies beyond all resamples.
    const double share = scale > 0 ? normal_below(bias + shifted / scale) : z < 0 ? 0 : 1;
    return quantile_of_sorted(statistics, share);
  };
  constexpr double kWidest = 1 - 1e-15;  // the quantile of 1 is infinite
  const double z = normal_quantile((1 + std::min(level, kWidest)) / 2);
  return {end(-z), end(z)};
}

double widened_level(double level, std::size_t n) {
  if (n < 2) return level;
  const double freedom = static_cast<double>(n - 1);
  const double of_noise = 1 + 1 / (freedom + 1);
  const double z = of_noise * std::sqrt((freedom + 1) / freedom) * student_quantile((1 + level) / 2, freedom);
  return 2 * normal_below(z) - 1;
}

Interval interval_95(Values values, const std::function<double(Values)>& statistic) {
  if (values.size() < kFewestForBootstrap) return {kNone, kNone};
  constexpr std::size_t kMany = 2000;  // values of which fewer draws are enough, and many would take seconds
  return bootstrap_interval(values, statistic, widened_level(0.95, values.size()),
                            {.resamples = values.size() > kMany ? 1999u : 9999u, .seed = 1});
}

double student_half_95(Values values) {
  if (values.size() < 2) return kNone;
  const double n = count(values);
  return student_quantile(0.975, n - 1) * standard_deviation(values) / std::sqrt(n);
}

Interval mean_interval_95(Values values) {
  if (values.size() >= kFewestForBootstrap) return interval_95(values, mean);
  const double half = student_half_95(values);
  return {mean(values) - half, mean(values) + half};
}

std::vector<double> profile(Values values, Values thresholds, bool more_is_better) {
  std::vector<double> out;
  for (const double threshold : thresholds)
    out.push_back(static_cast<double>(std::ranges::count_if(
                      values, [&](double value) { return more_is_better ? value >= threshold : value <= threshold; })) /
                  count(values));
  return out;
}

double effect_size(Values differences) {
  const double scatter = standard_deviation(differences);
  return scatter > 0 ? mean(differences) / scatter : kNone;
}

double probability_of_improvement(Values first, Values second) {
  std::vector<double> sorted(first.begin(), first.end());
  std::ranges::sort(sorted);
  double improved = 0;
  for (const double b : second) {
    const auto [equal, above] = std::equal_range(sorted.begin(), sorted.end(), b);
    improved += static_cast<double>(equal - sorted.begin()) + static_cast<double>(above - equal) / 2;
  }
  return improved / (count(first) * count(second));
}

Interval share_interval(std::size_t hits, std::size_t n, double level) {
  const double z = normal_quantile((1 + level) / 2), draws = static_cast<double>(n);
  const double share = static_cast<double>(hits) / draws, more = z * z / draws;
  const double middle = (share + more / 2) / (1 + more);
  const double half = z / (1 + more) * std::sqrt(share * (1 - share) / draws + more / (4 * draws));
  return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

Counts count_signs(Values differences) {
  Counts out;
  for (const double difference : differences) ++(difference > 0 ? out.above : difference < 0 ? out.below : out.equal);
  return out;
}

namespace {

constexpr std::size_t kAllFlips = 16;  ///< differences of which all flips are tried

/// The share of all flips whose sum is as far from 0.
double share_of_all_flips(Values sizes, double found) {
  // In the order of a Gray code, so that each flip changes one sign. The sum is computed again now and then, because of
  // rounding.
  const std::uint64_t flips = std::uint64_t{1} << sizes.size();
  std::vector<double> signed_sizes(sizes.begin(), sizes.end());
  double sum = 0;
  std::uint64_t as_far = 0;
  for (std::uint64_t i = 0; i < flips; ++i) {
    if (i > 0) {
      double& one = signed_sizes[static_cast<std::size_t>(std::countr_zero(i))];
      one = -one;
      sum += 2 * one;
    }
    if (i % 64 == 0) sum = std::accumulate(signed_sizes.begin(), signed_sizes.end(), 0.0);
    if (std::abs(sum) >= found) ++as_far;
  }
  return static_cast<double>(as_far) / static_cast<double>(flips);
}

double share_of_random_flips(Values sizes, double found, const Resampling& flips) {
  RandomStream random(flips.seed, "sign flips");
  std::uint64_t as_far = 1;  // what was found is one of them
  for (std::size_t i = 0; i < flips.resamples; ++i) {
    double sum = 0;
    std::uint64_t signs = 0;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      if (k % 64 == 0) signs = random.next();
      const double sign = static_cast<double>(static_cast<int>((signs & 1) * 2) - 1);
      sum += sign * sizes[k];
      signs >>= 1;
    }
    if (std::abs(sum) >= found) ++as_far;
  }
  return static_cast<double>(as_far) / static_cast<double>(flips.resamples + 1);
}

}  // namespace

double sign_flip_p(Values differences, const Resampling& flips) {
  std::vector<double> sizes;
  double sum = 0, size = 0;
  for (const double difference : differences) {
    if (difference == 0) continue;  // the same with either sign
    sizes.push_back(std::abs(difference));
    sum += difference;
    size += std::abs(difference);
  }
  if (sizes.empty()) return 1;
  const double found = std::abs(sum) - 1e-12 * size;  // sums that differ by rounding only are as far
  if (sizes.size() <= kAllFlips) return share_of_all_flips(sizes, found);
  constexpr std::size_t kFewest = 9999, kWork = 200'000'000;  // signs drawn: a second
  const std::size_t most = std::max(kFewest, kWork / sizes.size());
  return share_of_random_flips(sizes, found, {std::min(flips.resamples, most), flips.seed});
}

double mean_p(Values values) {
  if (values.size() < kFewestForMean) return 1;
  const double n = count(values), middle = mean(values);
  if (all_equal(values)) return middle == 0 ? 1 : std::pow(2, 1 - n);  // as if each could have the other sign
  double squares = 0, cubes = 0;
  for (const double value : values) {
    squares += (value - middle) * (value - middle);
    cubes += (value - middle) * (value - middle) * (value - middle);
  }
  const double skewness = (cubes / n) / std::pow(squares / n, 1.5);
  const double t = middle / std::sqrt(squares / (n - 1) / n);
  const double root = std::sqrt(n);
  const double hall = t + skewness / root * (t * t / 3 + 1.0 / 6) + skewness * skewness * t * t * t / (27 * n);
  const double of_noise = 1 + 1 / n;  // as in widened_level
  return 2 * student_below(-std::min(std::abs(t), std::abs(hall)) / of_noise, n - 1);
}

std::vector<double> holm(Values p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&p](std::size_t i) { return p[i]; });
  std::vector<double> out(p.size());
  double least = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    least = std::max(least, std::min(1.0, p[order[rank]] * static_cast<double>(order.size() - rank)));
    out[order[rank]] = least;
  }
  return out;
}

double pairs_needed(double effect, double alpha, double power) {
  if (std::isnan(effect) || effect == 0) return 0;
  const double z = normal_quantile(1 - alpha / 2);
  const double n = std::pow((z + normal_quantile(power)) / effect, 2) + z * z / 2;
  return std::ceil(n);
}

}  // namespace cxlab::statistics
