#pragma once
// When two numbers are equal.

namespace cxlab::planner {

/// Numbers that differ by no more than this are equal; above 1, by no more than this share of the larger one.
inline constexpr double kEqualWithin = 1e-9;

}  // namespace cxlab::planner
