#pragma once
// Finds what the real CX would do differently with the rules of an agent, by reading them. The checks that need a run
// are where they happen: parameters, messages of other types, what is left open (docs/reference/strict-cx.md lists
// all).

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/engine.h"
#include "cx/executive/run_settings.h"

namespace cxlab::cx {

/// In order of the constructs; each has the place of the construct, and begins with the name of the check.
/// `own_plugins`: those that CX does not have, by name, with their classes.
std::vector<Error> differences_in_rules(const RuleEngine& engine, RosRelease release,
                                        const std::map<std::string, std::string>& own_plugins = {});

/// Facts that were there before the first reset, by template: it takes them away.
std::vector<Error> facts_lost_by_reset(const RuleEngine& engine);

}  // namespace cxlab::cx
