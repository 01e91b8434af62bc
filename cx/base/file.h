#pragma once
// Whole files.

#include <filesystem>
#include <string>
#include <string_view>

#include "cx/base/expected.h"

namespace cxlab {

/// Returns the content. Fails with kInput and the reason if the file cannot be read, is larger than 2 GB, or is a pipe
/// that nobody has opened for writing. The limit for a device or pipe is 16 MB, because it may have no end.
Expected<std::string> read_file(const std::filesystem::path& path);
/// Replaces the content; kResource if that fails.
Status write_file(const std::filesystem::path& path, std::string_view text);
/// The same for a file that a person names: its folder is made where there is none.
Status write_output(const std::filesystem::path& path, std::string_view text);
/// Makes the folder of a file where there is none; kResource if that fails.
Status make_folder_of(const std::filesystem::path& file);

/// What a path is, its links followed; false where it cannot be looked at, as with a circle of links.
bool path_exists(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);
bool is_file(const std::filesystem::path& path);

}  // namespace cxlab
