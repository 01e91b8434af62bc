#pragma once
// The folder that one run writes (its files: docs/reference/run-folder.md).

#include <filesystem>
#include <string>
#include <string_view>

#include "cx/base/expected.h"

namespace cxlab {

/// Makes a folder and those above it where they are missing; kResource if that fails.
Status make_folder(const std::filesystem::path& folder);

/// Replaces `path` by `text`: a reader sees the old file or the whole new one. kResource if that fails; the old file
/// then stays.
Status replace_file(const std::filesystem::path& path, std::string_view text);
/// The same by way of a file that is named, for processes that may write the same one.
Status replace_file(const std::filesystem::path& path, std::string_view text, const std::filesystem::path& unfinished);
/// The end of it: the file that was written takes the other's place; one that could not be written is removed.
Status put_in_place(Status written, const std::filesystem::path& unfinished, const std::filesystem::path& path);

/// Makes `parent/name`, or with the first number appended (`name-2`, ...) that is not there yet. Two processes never
/// get the same one. kResource if it cannot be made.
Expected<std::filesystem::path> make_numbered_folder(const std::filesystem::path& parent, const std::string& name);

/// Makes a folder that the user named, if it is missing. An existing one must be empty (else kUsage). With `force` it
/// need not be: the files of a former run are removed, and all others stay.
Status make_output_folder(const std::filesystem::path& path, bool force);

}  // namespace cxlab
