#pragma once
// Judges whether the expectations of a story were met, and tells what happened instead.

#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/testing/play.h"

namespace cxlab::testing {

/// After the last tick: `file:line: what was expected, by when, what was there` for each expectation that was not met.
std::vector<std::string> judge(const Play& play);

/// After the last tick: notes on stand-ins and messages of the story that nobody uses. Rules use a name that is the
/// same but for a slip of the finger.
std::vector<std::string> slips_in_names(const Play& play);

/// Whether all that the YAML `wanted` names is in `found`; numbers are compared as numbers.
bool contains(const std::string& found, const std::string& wanted);

}  // namespace cxlab::testing
