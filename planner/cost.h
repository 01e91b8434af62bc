#pragma once
// What planning costs in simulated time.

#include <cstdint>

namespace cxlab::planner {

/// A plan that took u work units is answered latency_a + latency_b * u seconds after it was asked for.
struct PlanningCost {
  double latency_a = 0.0;            ///< s that any answer takes
  double latency_b = 1e-6;           ///< s a work unit; a unit is about a microsecond of one core
  std::int64_t budget = 60'000'000;  ///< work units that a plan may take
  bool charge = true;                ///< false: answers come at once
};

}  // namespace cxlab::planner
