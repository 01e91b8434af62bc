#pragma once
// A plan as a picture: who does what when, how late it may be, and what waits for what.

#include <string>

#include "planner/planner.h"

namespace cxlab::app {

/// An SVG: one row a step, a bar from start to end, a thin line to the latest end that keeps the makespan, an arrow for
/// every ordering between two steps, and a legend. As wide as its bars need, between bounds.
std::string plan_picture(const planner::TimedPlan& plan, const planner::Task& task);

}  // namespace cxlab::app
