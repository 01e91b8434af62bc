#pragma once
// Which PDDL files rules may name to a PDDL manager although no package holds them.

#include <filesystem>
#include <set>

#include "scenarios/scenario.h"

namespace cxlab::pddl {

/// Real paths of regular files `*.pddl`: those beside the scenario and in folders there, and those in folders that a
/// rule file of a package names by an absolute path. Hidden files and links are left out.
std::set<std::filesystem::path> files(const Scenario& scenario);

}  // namespace cxlab::pddl
