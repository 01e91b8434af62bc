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
  /// From now on these files. Of files that were watched before, changes are not forgotten; one that is new here has
  /// changed if it was written after `since`, ns of the system's clock: when somebody began to read it.
  void watch(const std::set<std::filesystem::path>& files, std::int64_t since);
  /// The files that are others than they were, or not there any more, once they are the same as at the call before:
  /// who writes one in several steps is not interrupted. Each change is told once.
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
