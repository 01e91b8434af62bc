#pragma once
// A folder for temporary files.

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "cx/base/expected.h"
#include "cx/base/servant.h"

namespace cxlab {

/// Who removes a temporary folder. A servant can do it where this process has given up the right to, behind a wall
/// (cx/wall/wall.h), and does it at once where the process was killed.
enum class RemovedBy { kThisProcess, kServant };

/// A folder below the system's temporary folder. The destructor removes it with its content; where a process was killed
/// before that, the next one that makes such a folder removes it.
class ScratchFolder {
 public:
  static Expected<std::unique_ptr<ScratchFolder>> create(RemovedBy remover = RemovedBy::kThisProcess);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  ScratchFolder(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}
  std::filesystem::path path_;
  int lock_;  // the folder's descriptor, locked as long as this object lives
  std::optional<Servant> servant_;
};

}  // namespace cxlab
