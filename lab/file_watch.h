#pragma once
// Notices that files change, in whatever way an editor writes them: in place, or by a new file of the name.

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>

namespace cxlab::lab {

/// Looks at the files when it is asked, so that it works on any file system.
class FileWatch {
 public:
  /// Watches these files from now on. It keeps the changes of files that it watched before. A new file has changed if
  /// it was written after `since` (ns of the system's clock), the time when somebody began to read it.
  void watch(const std::set<std::filesystem::path>& files, std::int64_t since);
  /// The files that were changed or removed, each change once. A change is reported only when the file is the same as
  /// at the last call, so a program can write a file in several steps.
  std::set<std::filesystem::path> changed();
  std::size_t size() const { return files_.size(); }

 private:
  struct State {
    std::uint64_t device = 0, inode = 0;
    std::int64_t size = -1, written_ns = 0, changed_ns = 0;  // size -1: it is not there
    bool operator==(const State&) const = default;
  };
  struct Watched {
    State told, last;
  };
  static State look(const std::filesystem::path& file);

  std::map<std::filesystem::path, Watched> files_;
};

}  // namespace cxlab::lab
