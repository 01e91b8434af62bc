#pragma once
// The packages of rules and messages that come with cxlab: of a package of the user's with the same name they have the
// files that it lacks.

#include <filesystem>
#include <map>
#include <string>

namespace cxlab::cx {

/// The same for all that a process plays, and set before that.
void set_own_packages(std::map<std::string, std::filesystem::path> folders);

}  // namespace cxlab::cx
