#pragma once
// Numbers that depend on when things happen.

#include <utility>
#include <vector>

#include "planner/ground/task.h"
#include "planner/happenings/zone.h"

namespace cxlab::planner {

inline constexpr double kLongestTime = 1e9;     ///< seconds; validators accept no later time
inline constexpr double kSlackInProofs = 1e-6;  ///< by which a value may miss what is asked for in proofs

/// Constant + sum of weight * time of the point, in seconds. The weights add up to 0.
struct TimedNumber {
  double constant = 0;
  std::vector<std::pair<int, double>> weights;  ///< by point, ascending, none 0
  bool is_constant() const { return weights.empty(); }
  bool operator==(const TimedNumber&) const = default;
};

/// What must be true of the times: the value is > 0, >= 0 or = 0.
struct TimedDemand {
  TimedNumber value;
  GroundComparison::Kind kind = GroundComparison::Kind::kNotNegative;
  bool operator==(const TimedDemand&) const = default;
};

/// a + factor * b
TimedNumber plus(const TimedNumber& a, const TimedNumber& b, double factor);
TimedNumber scaled(TimedNumber number, double factor);
/// factor * (time of `to` - time of `from`)
TimedNumber time_between(int from, int to, double factor = 1);
/// Writes points at a fixed distance as one.
void simplify(const Zone& zone, TimedNumber& value);

}  // namespace cxlab::planner
