#pragma once
// Where comparisons of numbers that change with time can switch between true and false.

#include <optional>
#include <vector>

#include "planner/state/state.h"

namespace cxlab::planner {

/// The first offset (s) in the open interval (0, length) at which `condition` does not hold, while the numbers of
/// `state` change at their rates; none if it holds all along. Looks at each crossing, where the two sides are equal up
/// to rounding errors, and between any two.
std::optional<double> first_break(const Evaluator& evaluator, const Condition& condition, Frame& frame,
                                  const State& state, double duration, double length);

/// A polynomial: coefficient of t^0, t^1, ...
using Polynomial = std::vector<double>;

/// Its real roots in the open interval (0, length), ascending; none for constants.
std::vector<double> roots(Polynomial polynomial, double length);

}  // namespace cxlab::planner
