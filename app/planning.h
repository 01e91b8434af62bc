#pragma once
// What the commands that read PDDL share.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::app {

/// Exit codes of `plan` and `validate` beside the common ones (docs/contracts.md).
inline constexpr int kExitInput = 31;
inline constexpr int kExitUnsupported = 34;

/// Prints the error on stderr and gives its exit code: 31, or 34 for what is not supported.
int fail_planning(const Error& error);

/// A metric as all commands print it: in whole millionths, below which sums of doubles are noise.
double rounded_metric(double metric);
std::string metric_text(double metric);

}  // namespace cxlab::app
