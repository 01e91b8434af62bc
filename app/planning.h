#pragma once
// What the commands that read PDDL share.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::app {

/// Prints the error on stderr and returns its exit code (planner/pddl/failure.h).
int fail_planning(const Error& error);

/// A metric as all commands print it: in whole millionths, below which sums of doubles are noise.
double rounded_metric(double metric);
std::string metric_text(double metric);

}  // namespace cxlab::app
