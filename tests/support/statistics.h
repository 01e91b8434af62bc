#pragma once
// Tests whether counts come from one distribution. The result is compared with a limit for a level of 0.1 %.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace cxlab {

using Counts = std::span<const int>;

constexpr double kNormalLimit = 3.0902;  ///< of a standard normal number
constexpr double kCourseLimit = 1.9495;  ///< of `course_difference`

inline double total(Counts counts) { return std::accumulate(counts.begin(), counts.end(), 0.0); }

/// A chi-square as a standard normal number (Wilson and Hilferty).
inline double as_normal(double chi_square, double freedom) {
  const double k = 2 / (9 * freedom);
  return (std::cbrt(chi_square / freedom) - (1 - k)) / std::sqrt(k);
}

/// Chi-square for two samples with classes of few merged, as a standard normal number.
inline double difference(Counts a, Counts b) {
  const double of_a = total(a), of_b = total(b);
  double chi_square = 0, classes = 0, rest_a = 0, rest_b = 0;
  const auto add = [&](double in_a, double in_b) {
    if (in_a + in_b == 0) return;
    const double share = (in_a + in_b) / (of_a + of_b);
    chi_square += std::pow(in_a - of_a * share, 2) / (of_a * share) + std::pow(in_b - of_b * share, 2) / (of_b * share);
    ++classes;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] + b[i] >= 10) {
      add(a[i], b[i]);
    } else {
      rest_a += a[i];
      rest_b += b[i];
    }
  }
  add(rest_a, rest_b);
  return as_normal(chi_square, classes - 1);
}

/// Chi-square against equally likely classes, as a standard normal number.
inline double unevenness(Counts counts) {
  const double each = total(counts) / static_cast<double>(counts.size());
  double chi_square = 0;
  for (const int count : counts) chi_square += (count - each) * (count - each) / each;
  return as_normal(chi_square, static_cast<double>(counts.size()) - 1);
}

/// The statistic of Kolmogorov and Smirnov for two samples of numbers, counted in stretches: the largest difference of
/// the shares up to a stretch, by the sizes of the samples.
inline double course_difference(Counts a, Counts b) {
  const double of_a = total(a), of_b = total(b);
  double up_to_a = 0, up_to_b = 0, most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    up_to_a += a[i] / of_a;
    up_to_b += b[i] / of_b;
    most = std::max(most, std::abs(up_to_a - up_to_b));
  }
  return most * std::sqrt(of_a * of_b / (of_a + of_b));
}

}  // namespace cxlab
