#pragma once
// The folder that one run writes (its files: docs/journal.md).

#include <filesystem>
#include <string>
#include <string_view>

#include "cx/base/expected.h"

namespace cxlab {

/// Replaces `path` by `text`: a reader sees the old file or the whole new one. kResource if that fails; the old file
/// then stays.
Status replace_file(const std::filesystem::path& path, std::string_view text);

class RunFolder {
 public:
  /// `parent/name`, or with the first number appended (`name-2`, ...) that is not there yet. Two processes never get
  /// the same one. kResource if it cannot be made.
  static Expected<RunFolder> create_numbered(const std::filesystem::path& parent, const std::string& name);
  /// A folder that the user named: made if it is missing, else it must be empty (kUsage) unless `force`, which takes
  /// away the files of a former run and leaves all others.
  static Expected<RunFolder> create_at(const std::filesystem::path& path, bool force);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  /// A folder below, made if it is missing ("logs", "snapshots").
  Expected<std::filesystem::path> subfolder(std::string_view name) const;
  /// Writes a file whole, by rename (`result.json`, `manifest.json`, `index.html`).
  Status write(std::string_view name, std::string_view text) const;

 private:
  explicit RunFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace cxlab
