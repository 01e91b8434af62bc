#pragma once
// What targets with an environment manager share.

#include <unistd.h>

#include <filesystem>

#include "cx/bus/bus.h"
#include "tests/fuzz/fuzz.h"

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

/// The packages that come with cxlab.
inline bus::Registry& registry() {
  static bus::Registry packages = [] {
    bus::Registry made;
    promise(made.add_packages_in(std::filesystem::path(CXLAB_SOURCE_DIR) / "cx/interfaces").ok(),
            "the packages of cxlab are there");
    return made;
  }();
  return packages;
}

}  // namespace cxlab::fuzz
