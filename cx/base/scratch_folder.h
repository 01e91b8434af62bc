#pragma once
// A folder for temporary files.

#include <filesystem>
#include <memory>
#include <utility>

#include "cx/base/expected.h"

namespace cxlab {

/// A folder below the system's temporary folder. The destructor removes it with its content.
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
