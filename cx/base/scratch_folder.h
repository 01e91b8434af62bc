#pragma once
// A folder for files that nobody wants to keep.

#include <filesystem>
#include <memory>
#include <utility>

#include "cx/base/expected.h"

namespace cxlab {

/// A folder under the system's temporary folder, taken away with its content at the end.
class ScratchFolder {
 public:
  static Expected<std::unique_ptr<ScratchFolder>> create();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace cxlab
