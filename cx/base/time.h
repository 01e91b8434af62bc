#pragma once
// Simulated time: integer nanoseconds from the start of the episode. Nothing here reads a wall clock.

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

/// The first multiple of `tick` that is not before `t`.
inline SimTime tick_not_before(SimTime t, SimTime tick) {
  const auto n = (t.count() + tick.count() - 1) / tick.count();
  return SimTime{n * tick.count()};
}

}  // namespace cxlab
