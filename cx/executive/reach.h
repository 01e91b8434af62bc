#pragma once
// What rules reach of the disk: which folders are packages, and which files in them they may read.

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "cx/wall/wall.h"

namespace cxlab::cx {

/// Whether the name of the file or of a folder on the way begins with a dot, as that of keys and settings does.
bool is_hidden(const std::filesystem::path& relative);

/// Whether the folder holds all that a user has: the home folder, or one that this lies in. It is no package.
bool holds_a_home(const std::filesystem::path& folder);

/// Absolute paths that stand in a text, as in a rule file.
std::vector<std::filesystem::path> paths_in(const std::string& text);

/// Calls `visit` with an iterator at each entry of a folder, at most 20,000; `Iterator` says whether folders are
/// entered.
template <class Iterator, class Visit>
void for_each_entry(const std::filesystem::path& folder, Visit visit) {
  constexpr int kMostEntries = 20000;
  std::error_code error;
  int seen = 0;
  for (Iterator entry(folder, std::filesystem::directory_options::skip_permission_denied, error), end;
       !error && entry != end && seen < kMostEntries; entry.increment(error), ++seen)
    visit(entry);
}

/// Adds the folder of a package to what is read behind a wall, with the libraries of its prefix.
void add_package(const std::filesystem::path& folder, Wall& wall);

}  // namespace cxlab::cx
