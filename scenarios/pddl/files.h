#pragma once
// Which PDDL files rules may name to a PDDL manager although no package holds them.

#include <filesystem>
#include <set>

#include "scenarios/scenario.h"

namespace cxlab::pddl {

/// Real paths of regular files `*.pddl`: those beside the scenario and in folders there, and those in folders that a
/// rule file of a package names by an absolute path. What is hidden, and what is a link, is not among them.
std::set<std::filesystem::path> files(const Scenario& scenario);

}  // namespace cxlab::pddl
