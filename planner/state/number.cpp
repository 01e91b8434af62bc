#include "planner/state/number.h"

#include <algorithm>
#include <array>
#include <optional>

namespace cxlab::planner {

namespace {

/// Rounding errors of a hundred operations, as a share of the larger number, or absolute below 1.
constexpr double kRounding = 0x1p-46;

constexpr int kMostPlaces = 22;  ///< powers of ten up to this one are exact doubles
constexpr int kFewPlaces = 6;    ///< Unix times in microseconds have sixteen digits
constexpr double kMostDigits = 1e15;

constexpr std::array<double, kMostPlaces + 1> kPowers = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// `digits` / 10^`places`
struct Decimal {
  double digits = 0;
  int places = 0;
};

double nearest_whole(double value) { return static_cast<double>(std::llround(value)); }

std::optional<Decimal> to_decimal(double value) {
  if (is_whole(value)) return Decimal{value, 0};
  for (int places = 1; places <= kMostPlaces; ++places) {
    const double scaled = value * kPowers[static_cast<std::size_t>(places)];
    if (!(std::abs(scaled) < (places <= kFewPlaces ? kMostWhole : kMostDigits))) break;
    const double digits = nearest_whole(scaled);
    if (digits / kPowers[static_cast<std::size_t>(places)] == value) return Decimal{digits, places};
  }
  return std::nullopt;
}

/// The double that stands for a decimal; none if it has too many digits or places.
std::optional<double> to_double(double digits, int places) {
  if (!(std::abs(digits) < kMostWhole) || places > kMostPlaces) return std::nullopt;
  return digits / kPowers[static_cast<std::size_t>(places)];
}

double scaled_to(const Decimal& decimal, int places) {
  return decimal.digits * kPowers[static_cast<std::size_t>(places - decimal.places)];
}

}  // namespace

double decimal_sum(double a, double b) {
  const auto one = to_decimal(a), other = one ? to_decimal(b) : std::nullopt;
  if (!other) return a + b;
  const int places = std::max(one->places, other->places);
  const double left = scaled_to(*one, places), right = scaled_to(*other, places);
  if (!(std::abs(left) < kMostWhole) || !(std::abs(right) < kMostWhole)) return a + b;
  return to_double(left + right, places).value_or(a + b);
}

double decimal_product(double a, double b) {
  const auto one = to_decimal(a), other = one ? to_decimal(b) : std::nullopt;
  if (!other) return a * b;
  return to_double(one->digits * other->digits, one->places + other->places).value_or(a * b);
}

double decimal_quotient(double a, double b) {
  const auto one = to_decimal(a), other = one ? to_decimal(b) : std::nullopt;
  if (!other) return a / b;
  const int places = std::max(one->places, other->places);
  const double above = scaled_to(*one, places), below = scaled_to(*other, places);
  return std::abs(above) < kMostWhole && std::abs(below) < kMostWhole ? above / below : a / b;
}

bool is_exact(double value) { return std::abs(value) >= kMostWhole || to_decimal(value).has_value(); }

bool is_same(double a, double b) {
  if (a == b) return true;
  if (!(std::abs(a - b) <= kRounding * std::max({1.0, std::abs(a), std::abs(b)}))) return false;
  return !is_exact(a) || !is_exact(b);
}

}  // namespace cxlab::planner
