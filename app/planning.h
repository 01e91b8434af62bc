#pragma once
// Code that the commands for PDDL share.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::app {

/// Prints the error on stderr and returns its exit code (planner/pddl/failure.h).
int fail_planning(const Error& error);

/// The JSON object in a file, for templates; `{}` without a file. Fails if neither the domain nor the problem is a
/// template.
Expected<std::string> read_template_data(const std::string& file, const std::string& domain,
                                         const std::string& problem);

/// A metric as all commands print it: in whole millionths, below which sums of doubles are noise.
double rounded_metric(double metric);
std::string metric_text(double metric);

}  // namespace cxlab::app
