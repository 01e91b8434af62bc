#pragma once
// Where comparisons of numbers that change with time can switch between true and false.

#include <vector>

#include "planner/state/state.h"

namespace cxlab::planner {

/// Offsets (s) in the open interval (0, length) at which `condition` must be evaluated to know it everywhere in the
/// interval, while the numbers of `state` change at their rates: each crossing, and a point between any two, ascending.
std::vector<double> sample_points(const Evaluator& evaluator, const Condition& condition, Frame& frame,
                                  const State& state, double duration, double length);

/// A polynomial: coefficient of t^0, t^1, ...
using Polynomial = std::vector<double>;

/// Its real roots in the open interval (0, length), ascending; none for constants.
std::vector<double> roots(Polynomial polynomial, double length);

}  // namespace cxlab::planner
