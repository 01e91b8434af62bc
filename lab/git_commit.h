#pragma once
// Finds the checked out commit in the files of git. It does not start the program git, which would run commands from
// the configuration of a stranger's repository.

#include <filesystem>
#include <string>

namespace cxlab::lab {

/// The commit that is checked out in the repository around this folder, as 40 or 64 hex digits; empty if there is none.
/// It does not say whether files have been changed since.
std::string git_commit_of(const std::filesystem::path& folder);

}  // namespace cxlab::lab
