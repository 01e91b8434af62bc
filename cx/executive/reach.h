#pragma once
// What rules reach of the disk: which folders are packages, and which files in them they may read.

#include <filesystem>

#include "cx/wall/wall.h"

namespace cxlab::cx {

/// Whether the name of the file or of a folder on the way begins with a dot, as that of keys and settings does.
bool is_hidden(const std::filesystem::path& relative);

/// Whether the folder holds all that a user has: the home folder, or one that this lies in. It is no package.
bool holds_a_home(const std::filesystem::path& folder);

/// Adds the folder of a package to what is read behind a wall, with the libraries of its prefix.
void add_package(const std::filesystem::path& folder, Wall& wall);

}  // namespace cxlab::cx
