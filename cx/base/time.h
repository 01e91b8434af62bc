#pragma once
// Simulated time: integer nanoseconds from the start of the episode. Nothing here reads a wall clock.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace cxlab {

using SimTime = std::chrono::nanoseconds;

/// "Never": later than every due time.
inline constexpr SimTime kNever = SimTime::max();

inline double to_seconds(SimTime t) { return static_cast<double>(t.count()) / 1e9; }
inline SimTime from_seconds(double s) { return SimTime{std::llround(s * 1e9)}; }

/// The k-th due time of a rate (Hz) counted from `start`: `start + k / rate`, rounded to ns, never accumulated.
inline SimTime due_time(SimTime start, std::int64_t k, double rate) {
  return start + SimTime{std::llround(static_cast<double>(k) * 1e9 / rate)};
}

/// The first number from `k` on whose due time is after `now`, also where there are very many before it.
inline std::int64_t due_after(SimTime now, SimTime start, std::int64_t k, double rate) {
  const double passed = std::min(to_seconds(now - start) * rate, 9e18);
  k = std::max(k, static_cast<std::int64_t>(passed - passed * 1e-12) - 2);
  while (due_time(start, k, rate) <= now) ++k;
  return k;
}

/// The first multiple of `tick` that is not before `t`.
inline SimTime tick_not_before(SimTime t, SimTime tick) {
  const auto n = (t.count() + tick.count() - 1) / tick.count();
  return SimTime{n * tick.count()};
}

}  // namespace cxlab
