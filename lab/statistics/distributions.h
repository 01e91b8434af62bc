#pragma once
// Distribution functions and quantiles, from Boost.Math.

namespace cxlab::statistics {

/// P(Z <= z) of the standard normal distribution.
double normal_below(double z);
/// The inverse; `p` within 0 and 1, both excluded.
double normal_quantile(double p);
/// P(T <= t) of Student's distribution; `freedom` above 0.
double student_below(double t, double freedom);
/// The inverse; `p` within 0 and 1, both excluded.
double student_quantile(double p, double freedom);

}  // namespace cxlab::statistics
