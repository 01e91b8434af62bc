#pragma once
// Which PDDL files rules may name to a PDDL manager although no package holds them.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace cxlab {

struct Scenario;

/// Absolute paths that stand in a text, as in a scenario's stimuli or a rule file.
std::vector<std::filesystem::path> paths_in(const std::string& text);

/// Real paths of regular files `*.pddl`: those beside the scenario and in folders there, and those in folders that a
/// rule file of a package names by an absolute path. What is hidden, and what is a link, is not among them.
std::set<std::filesystem::path> pddl_files(const Scenario& scenario);

}  // namespace cxlab
