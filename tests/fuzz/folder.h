#pragma once
// The files of fuzz targets.

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace cxlab::fuzz {

/// A folder of this process, which goes with it.
inline const std::filesystem::path& folder() {
  static const std::filesystem::path made = [] {
    auto path = std::filesystem::temp_directory_path() / ("cxlab-fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(path);
    std::atexit([] {
      std::error_code ignored;
      std::filesystem::remove_all(folder(), ignored);
    });
    return path;
  }();
  return made;
}

}  // namespace cxlab::fuzz
