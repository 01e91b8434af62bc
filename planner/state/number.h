#pragma once
// Arithmetic and comparison of numbers as PDDL 2.1 defines them: exact, as far as a double can tell two numbers apart.
//
// A double stands for the shortest decimal that it is nearest to: ten times 0.1 is 1, and 0.1 + 0.2 is 0.3. Sums,
// products and quotients of such decimals are computed on whole numbers and rounded once, so that a result that has at
// most 15 digits is exact. Results without such a decimal (1/3) carry rounding errors; only they are compared with a
// tolerance.

#include <cmath>
#include <cstdint>

namespace cxlab::planner {

/// Whole numbers below it, and no others, are all told apart: 2^53.
inline constexpr double kMostWhole = 9007199254740992.0;

inline bool is_whole(double value) {
  return std::abs(value) <= kMostWhole && static_cast<double>(static_cast<std::int64_t>(value)) == value;
}

double decimal_sum(double a, double b);
double decimal_product(double a, double b);
double decimal_quotient(double a, double b);

inline double sum(double a, double b) { return is_whole(a) && is_whole(b) ? a + b : decimal_sum(a, b); }
inline double difference(double a, double b) { return sum(a, -b); }
inline double product(double a, double b) { return is_whole(a) && is_whole(b) ? a * b : decimal_product(a, b); }
inline double quotient(double a, double b) { return is_whole(a) && is_whole(b) ? a / b : decimal_quotient(a, b); }

/// Whether the value is a whole number, or a decimal of at most 15 digits (16 where it has at most six places).
bool is_exact(double value);

/// Whether two numbers are the same: equal, or one of them has no decimal and they differ by rounding errors only.
bool is_same(double a, double b);

}  // namespace cxlab::planner
