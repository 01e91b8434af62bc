#include "planner/happenings/timed_number.h"

#include <algorithm>
#include <cmath>

namespace cxlab::planner {

namespace {

constexpr double kNoWeight = 1e-12;  ///< weights that are left by rounding

}  // namespace

TimedNumber plus(const TimedNumber& a, const TimedNumber& b, double factor) {
  TimedNumber sum{a.constant + factor * b.constant, a.weights};
  for (const auto& [point, weight] : b.weights) {
    const auto place = std::ranges::lower_bound(sum.weights, point, {}, &std::pair<int, double>::first);
    if (place != sum.weights.end() && place->first == point)
      place->second += factor * weight;
    else
      sum.weights.insert(place, {point, factor * weight});
  }
  std::erase_if(sum.weights, [](const auto& entry) { return std::abs(entry.second) < kNoWeight; });
  return sum;
}

TimedNumber scaled(TimedNumber number, double factor) {
  number.constant *= factor;
  for (auto& entry : number.weights) entry.second *= factor;
  std::erase_if(number.weights, [](const auto& entry) { return std::abs(entry.second) < kNoWeight; });
  return number;
}

TimedNumber time_between(int from, int to, double factor) {
  TimedNumber value;
  if (from == to) return value;
  value.weights = {{from, -factor}, {to, factor}};
  std::ranges::sort(value.weights);
  return value;
}

void simplify(const Zone& zone, TimedNumber& value) {
  for (std::size_t i = 0; i < value.weights.size();) {
    const auto [point, weight] = value.weights[i];
    int same = 0;
    while (same < point && !zone.is_fixed(same, point)) ++same;
    if (same == point) {
      ++i;
      continue;
    }
    const double away = weight * in_seconds(zone.most(same, point));
    value.weights.erase(value.weights.begin() + static_cast<std::ptrdiff_t>(i));
    value.constant += away;
    value = plus(value, TimedNumber{0, {{same, weight}}}, 1);
    i = 0;
  }
}

}  // namespace cxlab::planner
